"""Estimate of the memory of boundary elements, and a check that it is available."""

from __future__ import annotations

from asperity.halfspace.scene import Boundary
from surfaces.numerics import memory

__all__ = ["estimated_bytes", "fits", "require_memory"]

_BYTES_PER_POINT = {"periodic": 65, "free": 78}
"""Bytes per point if the area fraction is not known, by boundary."""

_OF_CONTACT = {"periodic": (30, 110), "free": (48, 70)}
"""Bytes per point of one load at light contact, and their increase up to full contact."""


def estimated_bytes(shape: tuple[int, int], boundary: Boundary, share: float | None = None) -> int:
    """Peak above the loaded map [bytes], at moderate contact or at a `share` of the area.

    Measured on 2048 x 2048 points: 30, 31, 35 and 44 bytes per point at 0.1, 4, 10 and 19 % of
    contact (periodic), 47 and 51 at 0.1 and 9 % (free). Along a curve up to 10 %: 43 (periodic),
    and 71 on 1024 x 1024 points (free).
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
