"""How loops are compiled, in one place.

The machine code is kept on disk, threads run beside it, and no wrapper for callers in C is made:
nobody calls it, and it took a twentieth of the compilation.
"""

from __future__ import annotations

from functools import partial

from numba import njit

__all__ = ["compiled", "inner"]

compiled = partial(njit, cache=True, nogil=True, no_cfunc_wrapper=True)
"""Decorator of a compiled loop; takes further options of `numba.njit`."""

inner = partial(njit, no_cfunc_wrapper=True, no_cpython_wrapper=True)
"""Decorator of a loop that compiled loops alone call. They hold its code, which is kept with
theirs; no wrapper for callers in Python is made, which took up to half of its compilation."""
