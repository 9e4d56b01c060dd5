"""Progress of a long run: a bar, or a function of the caller's."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from asperity.errors import InputError
from surfaces.errors import shown

__all__ = ["Progress", "bar", "reported", "require_function"]

Progress = bool | Callable[[Any], object] | None
"""What `progress` of a public function takes: True for a bar, or a function that is called."""


def require_function(name: str, given: object) -> None:
    """Refuse what cannot be called, before it would be; None is not to be."""
    if given is not None and not callable(given):
        raise InputError(f"{name} is {shown(given)}; give a function, or leave it out")


@contextmanager
def bar(
    total: int | None, label: str, *, hidden: bool | None = None
) -> Iterator[Callable[[Any], None]]:
    """A progress bar on standard error, advanced by one at each call, which shows text it is given.

    The total number of calls is None if it is not known; the label stands before the bar; `hidden`
    None hides it where standard error is no terminal.
    """
    from tqdm import tqdm

    with tqdm(total=total, desc=label, disable=hidden, leave=False) as shown:

        def advance(told: Any) -> None:
            if isinstance(told, str):
                shown.set_postfix_str(told)
            shown.update(1)

        yield advance


@contextmanager
def reported(
    progress: Progress, total: int | None, label: str
) -> Iterator[Callable[[Any], object] | None]:
    """The function that a run calls as it goes on; None if nobody asked."""
    if progress is True:
        with bar(total, label, hidden=False) as advance:
            yield advance
    else:
        asked = None if progress is False else progress
        require_function("progress", asked)
        yield asked
