"""How much memory boundary elements take, and whether it is there."""

from __future__ import annotations

from asperity.errors import InputError
from asperity.halfspace.scene import Boundary
from surfaces.numerics.memory import available_bytes

__all__ = ["estimated_bytes", "fits", "require_memory"]

_BYTES_PER_POINT = {"periodic": 60, "free": 70}
"""Estimate of `estimated_bytes`, by boundary."""


def estimated_bytes(shape: tuple[int, int], boundary: Boundary) -> int:
    """Peak above the loaded map [bytes], at moderate contact.

    Measured with `benchmarks/bem.py`: 20 to 47 bytes per point (periodic) and 38 to 50 (free) at up
    to 20 % of contact, 57 along a curve; a full contact takes about twice as much.
    """
    return _BYTES_PER_POINT[boundary] * shape[0] * shape[1]


def fits(shape: tuple[int, int], boundary: Boundary, copies: int) -> bool:
    """Whether several solutions at the same time fit in the memory that is available."""
    return copies * estimated_bytes(shape, boundary) <= available_bytes()


def require_memory(shape: tuple[int, int], boundary: Boundary) -> None:
    """Refuse a grid that will not fit.

    Raises
    ------
    InputError
        If the estimate exceeds the memory that is available.
    """
    need, free = estimated_bytes(shape, boundary), available_bytes()
    if need > free:
        raise InputError(
            f"a {boundary} grid of {shape[0]} x {shape[1]} needs about {need / 2**30:.1f} GiB and "
            f"{free / 2**30:.1f} GiB are available; use a coarser map or bem_curve(accuracy=...)"
        )
