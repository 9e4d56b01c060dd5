"""Kernel of the profiles: rays from the summits to the edges of their basins.

Many rays go on side by side, so that the surface is evaluated at many points at once: one point
costs half as much then as on its own.
"""

from __future__ import annotations

import numpy as np
from numba import from_dtype, njit

from ._climb import FLATTEST
from ._spline_form import LANES, TAPS, ray_places, spline_values

_BEYOND = 1.1  # rays run on beyond their basin by this factor: see fit_profiles
_TOGETHER = 64  # rays
_CHUNK = 8  # groups of samples

_RAY = from_dtype(
    np.dtype(
        [
            ("peak", np.int64),
            ("y", np.float64),  # summit [pixels]
            ("x", np.float64),
            ("z", np.float64),
            ("way_y", np.float64),  # step of one pixel
            ("way_x", np.float64),
            ("end", np.float64),  # length, or what limits it [steps]
            ("top", np.int64),  # number of the highest sample
            ("high", np.float64),  # it, and the samples before and after it
            ("before", np.float64),
            ("after", np.float64),
            ("latest", np.float64),
            ("outside", np.int64),  # samples in a row that lie in another basin
        ]
    )
)


@njit(cache=True, nogil=True, error_model="numpy")
def _look(
    flat, cell, rays, live, groups, radii, first, nodes, corners, rest, weights, pixels, out
):  # fmt: skip
    """Heights and pixels at `groups` times LANES of the `radii` of each ray of `live`.

    The radii from `first` on, in steps; if `nodes`, in shares of the length of the ray.
    """
    for start in range(0, live.size * groups, _CHUNK):
        stop = min(start + _CHUNK, live.size * groups)
        for group in range(start, stop):
            ray = rays[live[group // groups]]
            most = np.inf if nodes else max(1.0, 1.1 * ray.end, ray.end + 0.5)
            ray_places(
                ray.y, ray.x, ray.way_y, ray.way_x, ray.end if nodes else 1.0, most, radii,
                first + group % groups * LANES, cell, corners, rest, weights, pixels,
                (group - start) * LANES, group * LANES,
            )  # fmt: skip
        for group in range(start, stop):
            at = (group - start) * LANES
            spline_values(flat, int(cell[5]), corners, at, weights, rest, out, group * LANES)


@njit(cache=True, nogil=True, error_model="numpy")
def _march(flat, cell, labels, owner, dip, rays, live, radii, corners, rest, weights, pixels, zs):
    """Find the `end` of the rays of `live`: the first local maximum of f, or their limit.

    LANES samples of each ray are taken at once, as long as it goes on.
    """
    going = live.size
    for first in range(1, radii.size, LANES):
        _look(
            flat, cell, rays, live[:going], 1, radii, first, False, corners, rest, weights, pixels,
            zs,
        )  # fmt: skip
        count, going = going, 0
        for k in range(count):
            ray = rays[live[k]]
            f, high, top, outside = ray.latest, ray.high, ray.top, ray.outside
            for i in range(LANES):
                pixel = pixels[k * LANES + i]
                if pixel < 0:
                    break
                m = first + i
                previous, f = f, ray.z - zs[k * LANES + i]
                if m == 1 or f > high:
                    ray.before, high, ray.after, top = previous, f, np.nan, m
                else:
                    ray.after = f if m == top + 1 else ray.after
                    if f <= high - dip:
                        break
                label = labels[pixel]
                own = label == ray.peak or label < 0 or owner[label] == ray.peak
                outside = 0 if own else outside + 1
                if outside == 2:
                    ray.end = min(ray.end, _BEYOND * 0.5 * (radii[m - 2] + radii[m - 1]))
                if radii[m] > ray.end:
                    break
            else:
                live[going] = live[k]
                going += 1
            ray.latest, ray.high, ray.top, ray.outside = f, high, top, outside
        if going == 0:
            break


@njit(cache=True, nogil=True, error_model="numpy")
def _crest(ray, radii):
    """Where f is highest: at the vertex of the parabola through the highest of its samples."""
    edge = radii[ray.top]
    if ray.top > 0:
        left, right = edge - radii[ray.top - 1], radii[ray.top + 1] - edge
        up, down = (ray.high - ray.before) / left, (ray.high - ray.after) / right
        if up + down > 0.0:
            edge += 0.5 * (up * right - down * left) / (up + down)
    return max(min(edge, ray.end), 0.5)


@njit(cache=True, nogil=True, error_model="numpy")
def fit(
    flat, cell, labels, owner, dip, peak, y, x, z, way_y, way_x, pixel, limit, radii, shares, tip,
    slot, edge, q,
):  # fmt: skip
    """Fill the lengths and nodes of the rays of some peaks; see `surfaces.profiles.Profiles`.

    Parameters
    ----------
    flat, cell
        Coefficients of the surface, and what `ray_places` needs of the map.
    labels, owner, dip
        Basin of each pixel (flat), the peak that stands for each peak, and how far f may fall.
    peak, y, x, z
        Number and summit [pixels; m] of each peak, shape (n,).
    way_y, way_x, pixel, limit
        Steps of one pixel, their length [m], and how many there may be, shape (n, rays).
    radii, shares
        Numbers of steps to look at, and nodes in shares of the length.
    tip
        Half the curvatures along the rays, shape (n, rays).
    slot, edge, q
        Row of each peak in the lengths [m] and the nodes.
    """
    count, nodes = q.shape[1:]
    groups = shares.size // LANES
    rays, live = np.empty(_TOGETHER, _RAY), np.empty(_TOGETHER, np.int64)
    zs = np.empty(_TOGETHER * shares.size)
    pixels, corners = np.empty(zs.size, np.int64), np.empty(_CHUNK * LANES, np.int64)
    rest, weights = np.empty(_CHUNK * LANES), np.empty(_CHUNK * LANES * TAPS)
    squares = shares * shares
    inverses = 1.0 / squares
    for start in range(0, peak.size * count, _TOGETHER):
        used = min(_TOGETHER, peak.size * count - start)
        for k in range(used):
            n, p = (start + k) // count, (start + k) % count
            ray, live[k] = rays[k], k
            ray.peak, ray.y, ray.x, ray.z = peak[n], y[n], x[n], z[n]
            ray.way_y, ray.way_x, ray.end = way_y[n, p], way_x[n, p], limit[n, p]
            ray.high, ray.latest, ray.top, ray.outside = 0.0, 0.0, 0, 0
        _march(
            flat, cell, labels, owner, dip, rays, live[:used], radii, corners, rest, weights,
            pixels, zs,
        )  # fmt: skip
        for k in range(used):
            rays[k].end, live[k] = _crest(rays[k], radii), k
        _look(
            flat, cell, rays, live[:used], groups, shares, 0, True, corners, rest, weights, pixels,
            zs,
        )  # fmt: skip
        for k in range(used):
            n, p = (start + k) // count, (start + k) % count
            row = slot[n]
            length = rays[k].end * pixel[n, p]
            edge[row, p] = length
            f, scale = 0.0, 1.0 / (length * length)
            least = FLATTEST * tip[n, p] * length * length
            q[row, p, 0] = tip[n, p]
            for j in range(nodes - 1):
                f = max(f, rays[k].z - zs[k * shares.size + j], least * squares[j])
                q[row, p, j + 1] = f * scale * inverses[j]
