"""How loops are compiled, in one place.

The machine code is kept on disk, threads run beside it, and no wrapper for callers in C is made:
nobody calls it, and it took a twentieth of the compilation.
"""

from __future__ import annotations

from functools import partial

from numba import njit

__all__ = ["compiled"]

compiled = partial(njit, cache=True, nogil=True, no_cfunc_wrapper=True)
"""Decorator of a compiled loop; takes further options of `numba.njit`."""
