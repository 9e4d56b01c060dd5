"""One stress case: a question to one engine, and its judge."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["Case"]

SECONDS = 10.0
"""Time that a case may take on two processors [s], unless it states another."""


@dataclass(frozen=True)
class Case:
    """A question to one engine, and its judge.

    Attributes
    ----------
    theme, name, engine
        What is stiff or extreme, how far, and who is asked.
    against
        What the answer is judged against.
    judge
        Asks, and gives the error over what is allowed; raises an error of the package where the
        engine refuses.
    seconds
        Time that it may take [s].
    must_refuse
        Whether any answer is wrong.
    """

    theme: str
    name: str
    engine: str
    against: str
    judge: Callable[[], float]
    seconds: float = SECONDS
    must_refuse: bool = False
