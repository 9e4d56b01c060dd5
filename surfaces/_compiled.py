"""How loops are compiled, in one place.

The machine code is kept on disk, threads run beside it, and no wrapper for callers in C is made:
nobody calls it, and it took a twentieth of the compilation.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from numba import njit

from .errors import AsperityError

__all__ = ["compiled", "inner"]


def compiled(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Decorator of a compiled loop; takes further options of `numba.njit`.

    Raises
    ------
    AsperityError
        If the machine code can be kept nowhere.
    """
    own = partial(njit, cache=True, nogil=True, no_cfunc_wrapper=True, **options)

    def compile_when_called(function: Callable[..., Any]) -> Any:
        try:
            return own(function)
        except RuntimeError as error:
            if "no locator available" not in str(error):
                raise
            raise AsperityError(
                "no folder takes compiled code; set NUMBA_CACHE_DIR to one that does"
            ) from error

    return compile_when_called


inner = partial(njit, no_cfunc_wrapper=True, no_cpython_wrapper=True)
"""Decorator of a loop that compiled loops alone call. They hold its code, which is kept with
theirs; no wrapper for callers in Python is made, which took up to half of its compilation."""
