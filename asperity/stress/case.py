"""One stress case: a question to one engine, and its judge."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["BEM", "Case"]

BEM = "boundary elements"
"""Name of that engine."""

SECONDS = 10.0
"""Time that a case may take on two processors [s], unless it states another."""


@dataclass(frozen=True)
class Case:
    """A question to one engine, and its judge.

    The theme, the name and the engine say what is stiff or extreme, how far, and who is asked;
    `against` what the answer is judged against. The judge asks, and gives the error over what is
    allowed; it raises an error of the package where the engine refuses. A case may take so many
    seconds. Where it `must_refuse` any answer is wrong.
    """

    theme: str
    name: str
    engine: str
    against: str
    judge: Callable[[], float]
    seconds: float = SECONDS
    must_refuse: bool = False
