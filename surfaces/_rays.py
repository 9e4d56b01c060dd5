# mypy: disallow-untyped-defs=False
"""Kernel of the profiles: sub-pixel summits, principal curvatures, and rays to the basin edge."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ._spline import evaluate, expand

_MOST_SAMPLES = 512
_BEYOND = 1.1  # rays run on beyond their basin by this factor: see fit_profiles
_FOLD = 1.7  # half a paraboloid at the border carries 0.77 of the load, on 0.58 of the area (BEM)
_TINY = 1e-300
_FLATTEST = 1e-3  # least ratio of the principal curvatures, and least q relative to the tip
_NARROWEST = math.sqrt(1.0 / 8.0)  # least aspect of the ellipse on which the rays are spread
_LOCAL = 1e-4  # largest misfit of the local quartic, relative to the range of its points

SUMMIT, PLATEAU, RIM = 0, -1, -2


def _quartic_rows() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Least-squares quartic on 5 x 5 points: coefficients (15, 25) and residuals (25, 25)."""
    y, x = (a.ravel() for a in np.mgrid[-2:3, -2:3].astype(float))
    terms = [y**i * x ** (degree - i) for degree in range(5) for i in range(degree + 1)]
    columns = np.stack(terms, axis=1)
    rows = np.ascontiguousarray(np.linalg.pinv(columns))
    return rows, np.eye(25) - columns @ rows


_QUARTIC, _RESIDUAL = _quartic_rows()


@njit(cache=True, nogil=True, error_model="numpy")
def local_fit(heights, periodic, row, col, c):
    """Quartic c (15,) through the 5 x 5 points about a pixel; True where it represents them.

    It does if no point is off by more than `_LOCAL` of their range. Such a fit is as good as the
    spline and does not feel kinks of the map that are three or more pixels away.
    """
    ny, nx = heights.shape
    points = np.empty(25)
    low, high = np.inf, -np.inf
    for k in range(25):
        i, j = row + k // 5 - 2, col + k % 5 - 2
        if periodic:
            i, j = i % ny, j % nx
        elif not (0 <= i < ny and 0 <= j < nx):
            return False
        points[k] = heights[i, j] - heights[row, col]
        low, high = min(low, points[k]), max(high, points[k])
    for m in range(25):
        off = 0.0
        for k in range(25):
            off += _RESIDUAL[m, k] * points[k]
        if abs(off) > _LOCAL * (high - low):
            return False
    for m in range(15):
        c[m] = 0.0
        for k in range(25):
            c[m] += _QUARTIC[m, k] * points[k]
    c[0] += heights[row, col]
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _quartic(c, y, x):
    """Height, gradient and second derivatives (h, h_y, h_x, h_yy, h_xy, h_xx) of the quartic."""
    h, h_y, h_x, h_yy, h_xy, h_xx = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(4, -1, -1):  # Horner in x; each coefficient is a polynomial in y
        a, a_y, a_yy = 0.0, 0.0, 0.0
        for i in range(4 - j, -1, -1):
            degree = i + j
            a_yy = a_yy * y + 2.0 * a_y
            a_y = a_y * y + a
            a = a * y + c[degree * (degree + 1) // 2 + i]
        h_xx = h_xx * x + 2.0 * h_x
        h_x = h_x * x + h
        h_xy = h_xy * x + h_y
        h = h * x + a
        h_y = h_y * x + a_y
        h_yy = h_yy * x + a_yy
    return h, h_y, h_x, h_yy, h_xy, h_xx


@njit(cache=True, nogil=True, error_model="numpy")
def climb(heights, flat, width, labels, periodic, row, col, n, c):
    """Climb from the summit pixel of peak n to the maximum of the interpolated surface.

    Newton steps with the absolute values of the principal curvatures, of at most half a pixel,
    on the local quartic `c` where it represents the map and else on the spline. Returns y, x
    [pixels], the expansion there and what was found: `SUMMIT`, `PLATEAU` (none within reach),
    `RIM` (the same at the border of a map) or 1 + m, if it leads into the basin of another peak m.
    """
    ny, nx = heights.shape
    local = local_fit(heights, periodic, row, col, c)
    y, x = float(row), float(col)
    for _ in range(30):
        e = _quartic(c, y - row, x - col) if local else expand(flat, width, y, x)
        half = math.hypot(0.5 * (e[3] - e[5]), e[4])
        mean = 0.5 * (e[3] + e[5])
        size = abs(mean) + half
        if size == 0.0:
            break
        high, low = mean + half, mean - half
        turn = 0.5 * math.atan2(2.0 * e[4], e[5] - e[3])
        along_x, along_y = math.cos(turn), math.sin(turn)
        first = (e[2] * along_x + e[1] * along_y) / max(abs(high), 1e-6 * size)
        second = (e[1] * along_x - e[2] * along_y) / max(abs(low), 1e-6 * size)
        step_y = first * along_y + second * along_x
        step_x = first * along_x - second * along_y
        length = max(abs(step_y), abs(step_x))
        if high < 0.0 and length < 1e-9:
            if not periodic and not (0.0 <= y <= ny - 1.0 and 0.0 <= x <= nx - 1.0):
                break
            return y, x, e, SUMMIT
        scale = min(1.0, 0.5 / max(length, 1e-300))
        y += scale * step_y
        x += scale * step_x
        away = max(abs(y - row), abs(x - col))
        at_y, at_x = y, x
        if periodic:
            at_y, at_x = _wrapped(y, ny), _wrapped(x, nx)
        elif not (-0.5 <= y < ny - 0.5 and -0.5 <= x < nx - 0.5):
            break
        label = labels[_pixel(at_y, ny), _pixel(at_x, nx)]
        if away > 1.25 and label >= 0 and label != n:
            return float(row), float(col), e, 1 + label
        if away > (1.25 if local else 3.0):
            if not local:
                break
            local = False
    if not periodic and (row in (0, ny - 1) or col in (0, nx - 1)):
        return float(row), float(col), e, RIM
    return float(row), float(col), e, PLATEAU


@njit(cache=True, nogil=True, error_model="numpy")
def summits(
    heights, flat, width, labels, periodic, row, col, places, expansions, kinds, first, last
):
    """Climb from the peaks [first, last): places (n, 2), expansions (n, 6) and kinds (n,)."""
    c = np.empty(15)
    for n in range(first, last):
        y, x, e, kind = climb(heights, flat, width, labels, periodic, row[n], col[n], n, c)
        places[n, 0] = y
        places[n, 1] = x
        kinds[n] = kind
        for k in range(6):
            expansions[n, k] = e[k]


@njit(cache=True, nogil=True, error_model="numpy")
def aspect_of(k1, k2):
    """Aspect of the ellipse on which the rays are spread: the root of that of the contact."""
    return max((k2 / k1) ** (1.0 / 3.0), _NARROWEST)


@njit(cache=True, nogil=True, error_model="numpy")
def _wrapped(at, n):
    while at < 0.0:
        at += n
    while at >= n:
        at -= n
    return at


@njit(cache=True, nogil=True, error_model="numpy")
def _folded(way, fold):
    """Component of a ray; across a border it always leads inwards, and further."""
    return fold * abs(way) if fold != 0.0 else way


@njit(cache=True, nogil=True, error_model="numpy")
def _pixel(at, n):
    nearest = int(at + 0.5)
    return nearest if nearest < n else nearest - n


@njit(cache=True, nogil=True, error_model="numpy")
def _frame(a, b, c):
    """Principal curvatures k1 >= k2 > 0 of (a x^2 + 2 b x y + c y^2)/2 and the axis of k2."""
    half = math.hypot(0.5 * (a - c), b)
    k1 = 0.5 * (a + c) + half
    k2 = max(0.5 * (a + c) - half, _FLATTEST * k1)
    axis = 0.5 * math.atan2(2.0 * b, a - c) + 0.5 * math.pi
    return k1, k2, axis - math.pi if axis > 0.5 * math.pi else axis


@njit(cache=True, nogil=True, error_model="numpy")
def edge_of(flat, width, labels, owner, periodic, dip, n, place, top_height, way, rs, fs):
    """Length of a ray of peak n from `place` along `way` (pixels per metre), in steps of half a
    pixel that grow with the radius; `rs` and `fs` are room for its samples.
    """
    ny, nx = labels.shape
    way_y, way_x = way
    pixel = 1.0 / max(abs(way_y), abs(way_x))
    limit = np.inf
    if periodic:  # half-way to the image of the summit
        limit = min(0.5 * ny / max(abs(way_y), _TINY), 0.5 * nx / max(abs(way_x), _TINY))
    top = 0
    outside = 0
    m = 0
    r = 0.0
    rs[0], fs[0] = 0.0, 0.0
    while m + 1 < rs.size:
        r += pixel if m == 0 else max(0.5 * pixel, 0.1 * r)
        y, x = place[0] + r * way_y, place[1] + r * way_x
        if periodic:
            y, x = _wrapped(y, ny), _wrapped(x, nx)
        elif not (-0.5 <= y < ny - 0.5 and -0.5 <= x < nx - 0.5):
            break
        m += 1
        rs[m] = r
        fs[m] = top_height - evaluate(flat, width, y, x)
        label = labels[_pixel(y, ny), _pixel(x, nx)]
        outside = outside + 1 if label >= 0 and owner[label] != n else 0
        if fs[m] > fs[top] or m == 1:
            top = m
        elif fs[m] <= fs[top] - dip:
            break
        if outside == 2:
            limit = min(limit, _BEYOND * 0.5 * (rs[m - 2] + rs[m - 1]))
        if r > limit:
            break
    edge = rs[top]
    if 0 < top < m:  # the vertex of the parabola through the highest sample
        left, right = rs[top] - rs[top - 1], rs[top + 1] - rs[top]
        up = (fs[top] - fs[top - 1]) / left
        down = (fs[top] - fs[top + 1]) / right
        if up + down > 0.0:
            edge += 0.5 * (up * right - down * left) / (up + down)
    return max(min(edge, limit), 0.5 * pixel)


@njit(cache=True, nogil=True, error_model="numpy")
def fit(
    heights, flat, width, labels, owner, periodic, spacing, order, row, col, prominence, pixels,
    dip, places, expansions, kinds, summit, curvature, angle, phi, weight, edge, q, start, stop,
):  # fmt: skip
    """Fill the profiles of the peaks ``order[start:stop]``; see `surfaces.profiles.Profiles`."""
    ny, nx = heights.shape
    dy, dx = spacing
    rays, nodes = q.shape[1:]
    rs = np.empty(_MOST_SAMPLES)
    fs = np.empty(_MOST_SAMPLES)
    for rank in range(start, stop):
        n = order[rank]
        found = kinds[n] == SUMMIT
        y0, x0 = places[n]
        z0 = expansions[n, 0] if found else heights[row[n], col[n]]
        # without a summit: the round paraboloid that fills the basin down to the saddle
        a = 2.0 * math.pi * prominence[n] / (pixels[n] * dy * dx)
        b, c = 0.0, a
        if found:
            a = -expansions[n, 5] / (dx * dx)
            b = -expansions[n, 4] / (dx * dy)
            c = -expansions[n, 3] / (dy * dy)
        k1, k2, angle[n] = _frame(a, b, c)
        curvature[n, 0], curvature[n, 1] = k1, k2
        summit[n, 0], summit[n, 1], summit[n, 2] = (x0 + 0.5) * dx, (y0 + 0.5) * dy, z0
        fold_y, fold_x = 0.0, 0.0
        if kinds[n] == RIM:
            fold_y = _FOLD if row[n] == 0 else (-_FOLD if row[n] == ny - 1 else 0.0)
            fold_x = _FOLD if col[n] == 0 else (-_FOLD if col[n] == nx - 1 else 0.0)

        aspect = aspect_of(k1, k2)
        total = 0.0
        for p in range(rays):
            turn = 2.0 * math.pi * p / rays
            u, v = math.cos(turn), aspect * math.sin(turn)
            phi[n, p] = angle[n] + math.atan2(v, u)
            weight[n, p] = aspect / (u * u + v * v)
            total += weight[n, p]
        for p in range(rays):
            weight[n, p] *= 2.0 * math.pi / total
            turn = phi[n, p] - angle[n]
            tip = 0.5 * (k2 * math.cos(turn) ** 2 + k1 * math.sin(turn) ** 2)
            q[n, p, 0] = tip
            if kinds[n] > 0:  # the basin of another peak
                edge[n, p] = math.sqrt(pixels[n] * dy * dx / math.pi)
                for j in range(1, nodes):
                    q[n, p, j] = tip
                continue
            way_y = _folded(math.sin(phi[n, p]) / dy, fold_y)
            way_x = _folded(math.cos(phi[n, p]) / dx, fold_x)
            edge[n, p] = edge_of(
                flat, width, labels, owner, periodic, dip, n, (y0, x0), z0, (way_y, way_x), rs, fs
            )
            last = 0.0
            for j in range(1, nodes):
                r = edge[n, p] * j / (nodes - 1)
                y, x = y0 + r * way_y, x0 + r * way_x
                if periodic:
                    y, x = _wrapped(y, ny), _wrapped(x, nx)
                last = max(last, z0 - evaluate(flat, width, y, x), _FLATTEST * tip * r * r)
                q[n, p, j] = last / (r * r)
            if not found:
                q[n, p, 0] = q[n, p, 1]
