"""Estimate of the memory of boundary elements, and a check that it is available."""

from __future__ import annotations

from asperity.halfspace.load_points import Boundary
from surfaces.numerics import memory

__all__ = ["estimated_bytes", "fits", "require_memory"]

_BYTES_PER_POINT = {"periodic": 60, "free": 70}
"""Bytes per point if the area fraction is not known, by boundary."""

_OF_CONTACT = {"periodic": (22, 110), "free": (40, 60)}
"""Bytes per point of one load at light contact, and their increase up to full contact."""


def estimated_bytes(shape: tuple[int, int], boundary: Boundary, share: float | None = None) -> int:
    """Peak above the loaded map [bytes], at moderate contact or at a `share` of the area.

    Measured: 21, 24 and 41 bytes per point at 0.2, 4 and 18 % of contact (periodic) and 40 at 3 %
    (free); 57 along a curve.
    """
    least, most = _OF_CONTACT[boundary]
    each = _BYTES_PER_POINT[boundary] if share is None else least + most * share
    return int(each * shape[0] * shape[1])


def fits(shape: tuple[int, int], boundary: Boundary, copies: int) -> bool:
    """Whether several solutions at the same time fit in the memory that is available."""
    return copies * estimated_bytes(shape, boundary) <= memory.available_bytes()


def require_memory(shape: tuple[int, int], boundary: Boundary, share: float | None = None) -> None:
    """Refuse a grid that will not fit, at moderate contact or at a `share` of the area."""
    memory.require_memory(
        estimated_bytes(shape, boundary, share),
        f"a {boundary} grid of {shape[0]} x {shape[1]} points",
        "take fewer points, or bem_curve(accuracy=...)",
    )
