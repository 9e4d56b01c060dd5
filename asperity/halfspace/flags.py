"""Validity flags of a contact."""

from __future__ import annotations

from enum import IntFlag

__all__ = ["INVALID", "Flag"]


class Flag(IntFlag):
    """Validity bits of a contact; 0 means that nothing was found wrong.

    `CONTOUR_DOUBTFUL`: min a(phi)/a < 0.5 or max |a(phi) - a|/a > 0.5. `CONTOUR_NEGATIVE`: some
    a(phi) <= 0. `TURNING`: the approach is no rising function of the radius here (D' <= 0), there
    is no solution. `NEGATIVE_GAP`: f < 0 inside the contact (a higher neighbour). `RAY_TURNS`: f
    falls along a ray inside the contact. `SECOND_SUMMIT`: another summit stands inside {f < d}.
    `BEYOND_RADIUS`: the contact leaves the sampled radius on some ray. `FILLED`: the contact
    covers its whole basin.
    """

    CONTOUR_DOUBTFUL = 1
    CONTOUR_NEGATIVE = 2
    TURNING = 4
    NEGATIVE_GAP = 8
    RAY_TURNS = 16
    SECOND_SUMMIT = 32
    BEYOND_RADIUS = 64
    FILLED = 128


INVALID = Flag.CONTOUR_NEGATIVE | Flag.TURNING | Flag.NEGATIVE_GAP | Flag.SECOND_SUMMIT
