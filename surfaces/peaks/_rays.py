"""Kernel of the profiles: rays from the summits to the edges of their basins.

Many rays are sampled side by side, eight samples at a time: the spline costs half as much per point
as if it were evaluated at one point.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surfaces.numerics.compiled import BORROWING, compiled, inner
from surfaces.numerics.splines import LANES, PAD, TAPS, WEIGHTS, load, splat, spline_values
from surfaces.numerics.vectors import multiply_add, store, where, whole

from ._climb import FLATTEST, prefetch_block

_BEYOND = 1.1  # rays run on beyond their basin by this factor: see fit_profiles
_TIED = 1e-9  # share of the way from the start within which two pixels are equally near
_TOGETHER = 64  # rays
_CHUNK = 8  # groups of samples
_RAY = np.dtype(
    [
        ("peak", np.int64),
        ("y", np.float64),  # summit [pixels]
        ("x", np.float64),
        ("z", np.float64),
        ("way_y", np.float64),  # step of one pixel
        ("way_x", np.float64),
        ("fall", np.float64),  # tilt of the surface [m per step]
        ("dip", np.float64),  # how far f may fall again
        ("end", np.float64),  # length, or what limits it [steps]
        ("top", np.int64),  # number of the highest sample
        ("high", np.float64),  # it, and the samples before and after it
        ("before", np.float64),
        ("after", np.float64),
        ("latest", np.float64),
        ("outside", np.bool_),  # whether the latest lies in another basin
    ]
)


@inner(forceinline=True, **BORROWING)
def _least(a, b):
    return where(a < b, a, b)


@inner(forceinline=True, **BORROWING)
def _inside(value, center, n, inverse):
    """`value` less the multiple of the side n that brings `center` into the map; `inverse` is 1/n,
    or 0 if the map is not periodic."""
    return value - n * whole(center * inverse)


@inner(forceinline=True, **BORROWING)
def _along(start, way, r, n, inverse, margin):
    """Coordinates [pixels] along an axis, kept in the map or its margin, and nearest pixels; of two
    equally near ones that towards the start: rays of a mirrored map see the same pixels."""
    value = _least(multiply_add(r, way, splat(start)), splat(n + margin))
    value = -_least(-value, splat(margin))
    pixel = whole(value + 0.5 - _TIED * (value - start))
    return _inside(value, value, n, inverse), _inside(pixel, pixel + 0.5, n, inverse)


@inner(forceinline=True, **BORROWING)
def ray_places(
    y, x, way_y, way_x, scale, most, radii, first, cell, corners, rest, weights, pixels, at, into
):
    """Eight places on a ray, and what `spline_values` needs there.

    They lie at ``(y, x) + r (way_y, way_x)`` with ``r = min(scale radii[first:], most)``, kept
    inside the cell or no further out than its margin. Written are `corners` of the coefficients and
    fractions of a pixel over x in `rest`, from `at` on; eight `weights` over y for each tap, from
    ``TAPS * at`` on; and the nearest `pixels` (-1 beyond the border), from `into` on, unless that
    is negative. `cell` holds height and width of the map, their inverses (zero if it is not
    periodic), the margin, the width of the coefficients and the corner of the first pixel.
    """
    ny, nx, margin, width = cell[0], cell[1], cell[4], cell[5]
    r = _least(scale * load(radii, first), splat(most))
    high, row = _along(y, way_y, r, ny, cell[2], margin)
    wide, col = _along(x, way_x, r, nx, cell[3], margin)
    if into >= 0:
        there = (row >= 0.0) & (row < ny) & (col >= 0.0) & (col < nx)
        store(pixels, into, where(there, multiply_add(row, nx, col), -1.0))
    row, col = whole(high), whole(wide)
    store(corners, at, multiply_add(row, width, col) + cell[6])
    store(rest, at, wide - col)
    t = high - row
    for tap in range(TAPS):
        share = splat(WEIGHTS[0, TAPS - 1, tap])
        for power in range(TAPS - 2, -1, -1):
            share = multiply_add(share, t, WEIGHTS[0, power, tap])
        store(weights, TAPS * at + tap * LANES, share)


@inner(forceinline=True, **BORROWING)
def rising_nodes(zs, at, z, least, high, scale, squares, inverses, first):
    """Turn the eight heights from `at` on into f/r^2 at the nodes of a ray, from `first` on.

    f is z minus the height, at least `least` times the square of the node, and at least `high`, its
    value at the node before, so that it never falls. Returns f at the last node. `scale` is one
    over the squared length of the ray.
    """
    for k in range(LANES):
        high = max(high, max(z - zs[at + k], least * squares[first + k]))
        zs[at + k] = high * (scale * inverses[first + k])
    return high


@inner(**BORROWING)
def _look(
    flat, cell, rays, live, groups, radii, first, corners, rest, weights, pixels, out
):  # fmt: skip
    """Heights and pixels at `groups` times LANES of the `radii` of each ray of `live`.

    The radii are those from `first` on in steps of the ray; if `first` is 0, they are shares of the
    length of the ray.
    """
    nodes = first == 0
    for start in range(0, live.size * groups, _CHUNK):
        stop = min(start + _CHUNK, live.size * groups)
        for group in range(start, stop):
            ray = rays[live[group // groups]]
            most = np.inf if nodes else max(1.0, 1.1 * ray.end, ray.end + 0.5)
            ray_places(
                ray.y, ray.x, ray.way_y, ray.way_x, ray.end if nodes else 1.0, most, radii,
                first + group % groups * LANES, cell, corners, rest, weights, pixels,
                (group - start) * LANES, -1 if nodes else group * LANES,
            )  # fmt: skip
        for group in range(start, stop):
            at = (group - start) * LANES
            spline_values(flat, int(cell[5]), corners, at, weights, rest, out, group * LANES)
            ray = rays[live[group // groups]]
            if ray.fall != 0.0:
                scale = ray.end if nodes else 1.0
                most = np.inf if nodes else max(1.0, 1.1 * ray.end, ray.end + 0.5)
                for k in range(LANES):
                    radius = min(scale * radii[first + group % groups * LANES + k], most)
                    out[group * LANES + k] -= ray.fall * radius


@inner(**BORROWING)
def _march(
    flat, cell, labels, owner, rays, live, radii, corners, rest, weights, pixels, zs
):  # fmt: skip
    """Find the `end` of the rays of `live`: the first local maximum of f, or their limit.

    LANES samples of each ray are taken at once, as long as it goes on.
    """
    going = live.size
    for first in range(1, radii.size, LANES):
        _look(
            flat, cell, rays, live[:going], np.int64(1), radii, first, corners, rest, weights,
            pixels, zs,
        )  # fmt: skip
        count, going = going, 0
        for k in range(count):
            live[going] = live[k]
            going += _advance(rays[live[k]], zs, pixels, k * LANES, labels, owner, radii, first)
        if going == 0:
            break


@inner(forceinline=True, **BORROWING)
def _advance(ray, zs, pixels, at, labels, owner, radii, first):
    """Advance a ray over the samples of height and pixel from `at` on, at the radii from index
    `first` on; returns whether it goes on.

    It ends where f has fallen by the dip, at the border of the map, and at the first sample beyond
    its length. Two successive samples in another basin set its length.
    """
    for k in range(LANES):
        m, pixel, f = first + k, pixels[at + k], ray.z - zs[at + k]
        if pixel < 0:
            return False
        if f > ray.high:
            ray.before, ray.high, ray.after, ray.top = ray.latest, f, np.nan, m
        else:
            if m == ray.top + 1:
                ray.after = f
            if f <= ray.high - ray.dip:
                return False
        outside = labels[pixel] >= 0 and owner[labels[pixel]] != ray.peak
        if outside and ray.outside:
            ray.end = min(ray.end, _BEYOND * 0.5 * (radii[m - 2] + radii[m - 1]))
        if radii[m] > ray.end:
            return False
        ray.latest, ray.outside = f, outside
    return True


@inner(forceinline=True, **BORROWING)
def _crest(ray, radii):
    """Radius of the maximum of f: the vertex of the parabola through its highest sample and the
    two beside it."""
    edge = radii[ray.top]
    if ray.top > 0:
        left, right = edge - radii[ray.top - 1], radii[ray.top + 1] - edge
        up, down = (ray.high - ray.before) / left, (ray.high - ray.after) / right
        if up + down > 0.0:
            edge += 0.5 * (up * right - down * left) / (up + down)
    return max(min(edge, ray.end), 0.5)


def scratch(rays: int, nodes: int) -> tuple[Any, tuple[Any, ...], tuple[Any, ...]]:
    """Working arrays of `fit` for `rays` rays of a peak and `nodes` nodes of a ray."""
    together, block = max(_TOGETHER, rays), _CHUNK * LANES
    numbers = (together, block, together * nodes)
    values = (block, block * TAPS, nodes, nodes, together * nodes)
    return (
        np.empty(together, _RAY),
        tuple(np.empty(size, np.int64) for size in numbers),
        tuple(np.empty(size) for size in values),
    )


@compiled(**BORROWING)
def fit(
    flat, cell, labels, owner, dip, peak, y, x, z, way_y, way_x, fall, pixel, limit, radii, shares,
    tip, slot, edge, q, rays, numbers, values, first, last,
):  # fmt: skip
    """Fill the lengths and nodes of the rays of some peaks; see `surfaces.peaks.profiles.Profiles`.

    Parameters
    ----------
    flat, cell
        Coefficients of the surface, and what `ray_places` needs of the map.
    labels, owner
        Basin of each pixel (flat), and the peak that stands for each peak.
    dip, peak, y, x, z
        How far f may fall [m], number and summit [pixels; m] of each peak, shape (n,).
    way_y, way_x, fall, pixel, limit
        Steps of one pixel, by how much the surface is taken to fall along them [m], their length
        [m], and how many there may be, shape (n, rays).
    radii, shares
        Numbers of steps to look at, and nodes in shares of the length.
    tip
        Half the curvatures along the rays, shape (n, rays).
    slot, edge, q
        Row of each peak in the lengths [m] and the nodes.
    rays, numbers, values
        `scratch`.
    first, last
        Peaks to fill, from `first` to before `last`.
    """
    count, nodes = q.shape[1:]
    groups = shares.size // LANES
    live, corners, pixels = numbers
    rest, weights, squares, inverses, zs = values
    nx, width = int(cell[1]), int(cell[5])
    for j in range(shares.size):
        squares[j] = shares[j] * shares[j]
        inverses[j] = 1.0 / squares[j]
    peaks = max(1, _TOGETHER // count)
    for start in range(first, last, peaks):
        some = min(peaks, last - start)
        used = some * count
        for n in range(start, start + some):
            if n + peaks < last:
                row, col = int(y[n + peaks]), int(x[n + peaks])
                prefetch_block(flat, width, row + PAD - 6, col + PAD - 6, 14, 14)
                prefetch_block(labels, nx, row - 5, col - 5, 11, 11)
            for p in range(count):
                k = (n - start) * count + p
                ray, live[k] = rays[k], k
                ray.peak, ray.y, ray.x, ray.z = peak[n], y[n], x[n], z[n]
                ray.way_y, ray.way_x, ray.fall = way_y[n, p], way_x[n, p], fall[n, p]
                ray.end, ray.dip = limit[n, p], dip[n]
                ray.high, ray.latest, ray.top, ray.outside = -np.inf, 0.0, 0, False
        _march(
            flat, cell, labels, owner, rays, live[:used], radii, corners, rest, weights, pixels, zs
        )  # fmt: skip
        for k in range(used):
            rays[k].end, live[k] = _crest(rays[k], radii), k
        _look(
            flat, cell, rays, live[:used], groups, shares, np.int64(0), corners, rest, weights,
            pixels, zs,
        )  # fmt: skip
        for n in range(start, start + some):
            row = slot[n]
            for p in range(count):
                k = (n - start) * count + p
                length = rays[k].end * pixel[n, p]
                square = length * length
                edge[row, p] = length
                q[row, p, 0] = tip[n, p]
                at, high = k * shares.size, 0.0
                for group in range(groups):
                    high = rising_nodes(
                        zs, at + group * LANES, rays[k].z, FLATTEST * tip[n, p] * square, high,
                        1.0 / square, squares, inverses, group * LANES,
                    )  # fmt: skip
                for j in range(nodes - 1):
                    q[row, p, j + 1] = zs[at + j]
