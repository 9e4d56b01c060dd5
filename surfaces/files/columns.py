"""Height maps in lists of points: three columns x, y, z in any order of rows."""

from __future__ import annotations

import numpy as np

from surfaces.arrays import Array, Index
from surfaces.errors import FileFormatError

__all__ = ["gridded"]


_OFF = 0.1
"""Distance of a point from its line of the grid, over that of two lines, that is rounding."""


def gridded(table: Array) -> tuple[Array, tuple[float, float]] | None:
    """Heights (ny, nx) and pixel size (dy, dx) of a table of points, (n, 3), of which the columns
    are x, y, z in one unit of length; None if it is no such list. Points that are repeated are
    refused (FileFormatError).

    Notes
    -----
    The first two columns run over the lines of an even grid, give or take a tenth of a pixel, and
    hold at least half of all points. The others are missing. The lowest y is
    the first row of the map.
    """
    if table.shape[1] != 3 or len(table) < 9 or not np.isfinite(table[:, :2]).all():
        return None
    across, along = _lines(table[:, 0]), _lines(table[:, 1])
    if across is None or along is None:
        return None
    (column, dx), (row, dy) = across, along
    shape = int(row.max()) + 1, int(column.max()) + 1
    points = shape[0] * shape[1]
    if min(shape) < 3 or points > 2 * len(table):
        return None
    place = row * shape[1] + column
    if np.bincount(place).max() > 1:
        raise FileFormatError(
            "three columns whose first two run over the points of a grid hold some of these points "
            "repeatedly; leave one of each"
        )
    heights = np.full(points, np.nan)
    heights[place] = table[:, 2]
    return heights.reshape(shape), (dy, dx)


def _lines(values: Array) -> tuple[Index, float] | None:
    """Number of the line of an even grid on which each value lies, and the distance of two."""
    order = np.sort(values)
    gaps = np.diff(order)
    falling = np.sort(gaps)[::-1]
    # a fall by ten: from the gaps between lines to those on one, or from holes to lines
    falls = (falling[2:] <= _OFF * falling[1:-1]) & (falling[1:-1] > 0.0)
    for rank in 1 + np.flatnonzero(falls):
        first = np.append(0, 1 + np.flatnonzero(gaps >= falling[rank]))
        lines = np.add.reduceat(order, first) / np.diff(first, append=order.size)
        length = lines[-1] - lines[0]
        step = length / round(length / np.median(np.diff(lines)))
        place = (values - lines[0]) / step
        number = np.round(place)
        if np.abs(place - number).max() <= _OFF:
            return number.astype(np.int64), float(step)
    return None
