"""How loops are compiled, in one place.

The machine code is kept on disk, threads run beside it, and no wrapper for callers in C is made:
nobody calls it, and it took a twentieth of the compilation. Numbers are divided as numpy divides
them: a test of each divisor, with its exception, would be compiled too.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from numba import njit

from surfaces.errors import AsperityError

__all__ = ["QUOTIENTS", "SUMS", "compiled", "inner"]

SUMS = {"reassoc", "contract", "nsz"}
"""What a loop may do with sums: take terms in another order, fuse products into them, and forget
the sign of zero. Infinities and NaN keep their meaning."""

QUOTIENTS = SUMS | {"arcp"}
"""The same, and multiply by the inverse in place of a division."""


def compiled(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Decorator of a compiled loop; takes further options of `numba.njit`.

    Raises
    ------
    AsperityError
        If the machine code can be kept nowhere.
    """
    shared = {"error_model": "numpy", "cache": True, "nogil": True, "no_cfunc_wrapper": True}
    own = partial(njit, **shared, **options)

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


inner = partial(njit, error_model="numpy", no_cfunc_wrapper=True, no_cpython_wrapper=True)
"""Decorator of a loop that compiled loops alone call. They hold its code, which is kept with
theirs; no wrapper for callers in Python is made, which took up to half of its compilation."""
