"""The split length of the Ewald sum: how far near pairs reach, and what is left to the mesh."""

from __future__ import annotations

import math

__all__ = ["NEAREST", "RUNG", "long_enough", "split_length"]

NEIGHBOURS = 15
"""Neighbours within the cut-off, on average."""

FEW, NEAREST = 3_500, 11
"""Points whose mesh is short, and their neighbours: pairs and mesh then take the same time."""

WIDEST = 3.0
"""Least split length over the root of the widest variance: moments must stay an expansion."""

LARGEST_CUT = 0.499
"""Largest cut-off of a periodic cell over its shorter side."""

RUNG = 1.19
"""Ratio of the cut-offs that plans of a periodic cell may have: they share meshes then."""


def split_length(
    count: int,
    size: tuple[float, float],
    periodic: bool,
    widest: float,
    cut: float,
    neighbours: float | None = None,
) -> float:
    """Split length eta [m] of an interaction.

    Parameters
    ----------
    count
        Number of points.
    size
        Cell, or extent of the points on a free half-space, (Ly, Lx) [m].
    periodic
        Whether the cell repeats.
    widest
        Largest variance of a footprint [m^2].
    cut
        Cut-off of the near pairs over the split length.
    neighbours
        Neighbours within the cut-off, on average; as many as are fastest if None.
    """
    if neighbours is None:
        neighbours = NEAREST if count <= FEW else NEIGHBOURS
    # within this distance of a point there are `neighbours` of a plane or, if more, of a line
    reach = max(
        math.sqrt(neighbours / math.pi * size[0] * size[1] / count),
        0.5 * neighbours * max(size) / count,
    )
    floor = cut * WIDEST * math.sqrt(widest)
    reach = max(reach, floor)
    if periodic:
        return _repeated(reach, floor, LARGEST_CUT * min(size)) / cut
    return max(min(reach, 1.01 * math.hypot(*size)), 0.02 * math.hypot(*size), floor) / cut


def long_enough(
    eta: float, widest: float, periodic: bool, cut: float, size: tuple[float, float]
) -> bool:
    """Whether a split length is that of footprints of the variance `widest`, or the largest that
    the cell has."""
    largest = periodic and cut * eta >= LARGEST_CUT * min(size)
    return largest or eta >= WIDEST * math.sqrt(widest)


def _repeated(wanted: float, least: float, most: float) -> float:
    """The cut-off nearest to that wanted, and not below the least, of those that plans share."""
    if wanted >= most:
        return most
    rungs = round(math.log(most / wanted, RUNG))
    if most * RUNG**-rungs < least:
        rungs -= 1
    return most * RUNG ** -max(rungs, 0)
