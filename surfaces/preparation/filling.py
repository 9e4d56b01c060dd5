"""Fill missing points with the harmonic surface through the points about them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix, diags
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator, cg, splu

from surfaces.arrays import Array, Index, Mask
from surfaces.errors import SurfaceError, as_number
from surfaces.heightmap import HeightMap, require_map
from surfaces.numerics.memory import require_memory
from surfaces.numerics.stored_array import Source, array_of, windows

__all__ = ["fill_missing", "middle", "quick_fill", "replaced"]


_BYTES = 400
"""Memory that a missing point takes while it is filled."""

_BLOCK = 64
"""Pixels in the blocks on which conjugate gradients are preconditioned."""

_STEPS = ((1, 0), (-1, 0), (0, 1), (0, -1))
"""Rows and columns from a point to its neighbors."""


def fill_missing(hm: HeightMap, *, limit: float = 0.1) -> HeightMap:
    """Fill missing points with the harmonic surface through the points about them.

    Parameters
    ----------
    hm
        The map.
    limit
        Largest fraction of the points that may be filled.

    Returns
    -------
    HeightMap
        History step ``fill`` with the count, the fraction and the largest gap [pixels].

    Raises
    ------
    SurfaceError
        If more points are missing than the limit allows, or a gap is too large for the memory.

    Notes
    -----
    Solves Laplace's equation on the missing points (five-point stencil with the true pixel sizes;
    no flux across the border of a map that is not periodic). The filled heights lie between those
    around them: no summit is invented. Gaps are solved by conjugate gradients, to 1e-12 of the
    heights about them; those of a map on disk one after the other. (Factors of a gap that holds
    scattered points fill up: 512 x 512 points of which 85 % are missing took over 400 s.)

    Examples
    --------
    >>> import numpy as np
    >>> import surfaces
    >>> y, x = np.mgrid[:32, :48]
    >>> heights = 1e-9 * (x + y)
    >>> heights[10, 10] = np.nan
    >>> surfaces.fill_missing(surfaces.HeightMap(heights, 1e-6)).missing
    0
    """
    require_map(hm)
    count, size = hm.missing, hm.source.size
    fraction = count / size
    if not fraction <= as_number("limit", limit):
        raise SurfaceError(
            f"{count} of {size} points are missing ({100 * fraction:.3g} %), more than the "
            f"fill limit of {100 * limit:.3g} %; crop the map or raise fill_limit (--fill-limit)"
        )
    step: dict[str, Any] = {
        "step": "fill",
        "method": "harmonic",
        "count": count,
        "fraction": fraction,
    }
    if count == 0:
        return hm.replace(step=step)
    places, filled, step["largest_gap"] = _harmonic(hm)
    return hm.with_rows(replaced(hm.source, places, filled), step=step)


def _harmonic(hm: HeightMap) -> tuple[Index, Array, int]:
    """Places of the missing points, their heights, and the largest gap [pixels].

    A place is a number in scan order. The map is gone through once; gaps are solved as soon as all
    of their points have been met.
    """
    places, around = np.empty(0, np.int64), np.empty((len(_STEPS), 0))
    level = middle(hm.source)
    solved: list[tuple[Index, Array]] = []
    largest = 0
    for begin, end, window in windows(hm.source, below=1):
        missing = np.isnan(window[: end - begin])
        found = np.flatnonzero(missing) + begin * hm.shape[1]
        places = np.append(places, found)
        if not places.size:
            continue
        require_memory(
            _BYTES * places.size,
            f"filling {places.size} missing points, of gaps that reach into rows {begin} to {end},",
            "raise the limit of memory (--memory), crop the map (--crop) or leave the points "
            "missing (--fill none)",
        )
        around = np.hstack([around, _heights_about(hm, found, window, begin)])
        matrix, right, unmet = _equations(hm, places, around, level)
        gaps, gap = connected_components(matrix, directed=False)
        waits = np.zeros(gaps, bool)
        waits[gap[unmet]] = True
        ready = np.flatnonzero(~waits[gap])
        if ready.size:
            largest = max(largest, int(np.bincount(gap[ready]).max()))
            place = places[ready]
            blocks = _blocks(hm, place)
            heights = _by_gradients(matrix[ready][:, ready], right[ready], blocks)
            solved.append((place, heights + level))
        waiting = waits[gap]
        places, around = places[waiting], around[:, waiting]
    places, filled = (np.concatenate(part) for part in zip(*solved, strict=True))
    order = np.argsort(places)
    return places[order], filled[order], largest


def _heights_about(hm: HeightMap, places: Index, window: Array, begin: int) -> Array:
    """Heights of the neighbors of points of a window, shape (4, points): NaN where they are missing
    too, infinite beyond the border of a map that is not periodic."""
    (ny, nx), before = hm.shape, hm.source[begin - 1]
    rows, columns = np.divmod(places, nx)
    around = np.empty((len(_STEPS), places.size))
    for values, (dr, dc) in zip(around, _STEPS, strict=True):
        r, c = rows + dr, columns + dc
        values[:] = window[(r - begin) % len(window), c % nx]
        above = r < begin
        values[above] = before[c[above]]
        if not hm.periodic:
            values[(r < 0) | (r >= ny) | (c < 0) | (c >= nx)] = np.inf
    return around


def _equations(
    hm: HeightMap, places: Index, around: Array, level: float
) -> tuple[csc_matrix, Array, Mask]:
    """Matrix and right side, heights about a level, of the Laplace equation on missing points, and
    which of them have a missing neighbor that is not among them."""
    (ny, nx), count = hm.shape, len(places)
    rows, columns = np.divmod(places, nx)
    total, right, unmet = np.zeros(count), np.zeros(count), np.zeros(count, bool)
    pairs: list[tuple[Index, Index, Array]] = []
    ratio = hm.spacing[1] / hm.spacing[0]
    for values, (dr, dc) in zip(around, _STEPS, strict=True):
        weight = ratio if dr else 1 / ratio
        total[~np.isinf(values)] += weight
        known = np.isfinite(values)
        right[known] += weight * (values[known] - level)
        unknown = np.flatnonzero(np.isnan(values))
        wanted = (rows[unknown] + dr) % ny * nx + (columns[unknown] + dc) % nx
        other = np.minimum(np.searchsorted(places, wanted), count - 1)
        met = places[other] == wanted
        unmet[unknown[~met]] = True
        pairs.append((unknown[met], other[met], np.full(int(met.sum()), -weight)))
    i, j, w = (np.concatenate(part) for part in zip(*pairs, strict=True))
    matrix = coo_matrix((w, (i, j)), shape=(count, count)) + diags(total)
    return matrix.tocsc(), right, unmet


def _blocks(hm: HeightMap, places: Index) -> Index:
    """Number of the block that each of some points lies in: blocks of about `_BLOCK` pixels that
    are square in metres, since the points of the shorter spacing hang together most."""
    rows, columns = (
        axis // max(1, round(math.sqrt(_BLOCK * other / own)))
        for axis, own, other in zip(
            np.divmod(places, hm.shape[1]), hm.spacing, hm.spacing[::-1], strict=True
        )
    )
    return np.asarray(rows * (columns.max() + 1) + columns)


def _by_gradients(matrix: csc_matrix, right: Array, blocks: Index) -> Array:
    """Solution by conjugate gradients, of points in some blocks.

    Notes
    -----
    Preconditioned by the points alone and by their sums over the blocks, which takes some hundred
    rounds for a gap of any size.
    """
    block = np.unique(blocks, return_inverse=True)[1]
    spread = csr_matrix((np.ones(len(right)), block, np.arange(len(right) + 1)))
    coarse = splu((spread.T @ matrix @ spread).tocsc(), permc_spec="MMD_AT_PLUS_A")
    diagonal = matrix.diagonal()

    def smooth(values: Array) -> Array:
        return np.asarray(spread @ coarse.solve(spread.T @ values))

    guess = LinearOperator(matrix.shape, matvec=lambda values: values / diagonal + smooth(values))
    filled, status = cg(matrix.tocsr(), right, x0=smooth(right), rtol=1e-12, maxiter=4000, M=guess)
    if status != 0:
        raise SurfaceError(
            f"filling {len(right)} missing points did not converge; crop the map to the measured "
            "part"
        )
    return np.asarray(filled)


def middle(heights: Source) -> float:
    """Median over the blocks of the medians of the heights present."""
    medians = []
    for _, _, rows in windows(heights):
        present = rows[~np.isnan(rows)]
        if present.size:
            medians.append(float(np.median(present)))
    return float(np.median(medians))


def replaced(source: Source, places: Index, heights: Array) -> Iterator[tuple[int, Array]]:
    """Blocks of rows with other heights at some places, numbers in scan order that rise."""
    for begin, _, window in windows(source):
        rows = window.copy()
        start = begin * rows.shape[1]
        part = slice(*np.searchsorted(places, (start, start + rows.size)))
        rows.flat[places[part] - start] = heights[part]
        yield begin, rows


def quick_fill(z: Source) -> Source:
    """Quick fill by averages over ever coarser blocks, a stand-in for medians; NaN is missing."""
    if not any(np.isnan(window).any() for _, _, window in windows(z)):
        return z
    ny, nx = z.shape
    coarse = quick_fill(array_of(_halved(z), (-(-ny // 2), -(-nx // 2)), z))

    def filled() -> Iterator[tuple[int, Array]]:
        for begin, end, rows in windows(z):
            fine = coarse[begin // 2 : -(-end // 2)].repeat(2, axis=0).repeat(2, axis=1)
            fine = fine[begin % 2 :][: len(rows), :nx]
            yield begin, np.where(np.isnan(rows), fine, rows)

    return array_of(filled(), z.shape, z)


def _halved(z: Source) -> Iterator[tuple[int, Array]]:
    """Means over 2 x 2 points, where some are present, in blocks of rows."""
    ny, nx = z.shape
    for begin, end, window in windows(z, below=1):
        first = begin + begin % 2
        rows = window[first - begin : min(end + end % 2, ny) - begin]
        even = np.pad(rows, ((0, len(rows) % 2), (0, nx % 2)), constant_values=np.nan)
        blocks = even.reshape(len(even) // 2, 2, even.shape[1] // 2, 2)
        present = ~np.isnan(blocks)
        count = present.sum(axis=(1, 3))
        total = np.where(present, blocks, 0.0).sum(axis=(1, 3))
        yield first // 2, np.where(count > 0, total / np.maximum(count, 1.0), np.nan)
