"""Kernels of the summits: the climb to the sub-pixel maximum, and the curvatures there."""

from __future__ import annotations

import math

import numpy as np

from surfaces.arrays import Array
from surfaces.numerics.compiled import compiled, inner
from surfaces.numerics.splines import PAD, expand
from surfaces.numerics.vectors import prefetch

from .peaks import PLATEAU, RIM, SUMMIT

FLATTEST = 1e-3  # least ratio of the principal curvatures
_LOCAL = 1e-4  # largest misfit of the local quartic, relative to the range of its points
_LEVEL = 1e-6  # ratio of curvatures below which rounding may decide the smaller one

_LONGEST = 0.45  # step [pixels]; several of half a pixel would end between two pixels

_AHEAD = 8  # summits
_LINE = 64  # bytes of a cache line


@inner()
def prefetch_block(array, width, row, col, rows, cols):
    """Prefetch `rows` x `cols` elements from (row, col) on, of an array of rows of `width`: summits
    lie scattered over the map, and each would wait for memory."""
    step = _LINE // array.itemsize
    for i in range(row, row + rows):
        for j in range(0, cols + step - 1, step):
            prefetch(array, i * width + col + min(j, cols - 1))


def _quartic_rows() -> tuple[Array, Array]:
    """Least-squares quartic on 5 x 5 points: coefficients (15, 25) and residuals (25, 25)."""
    y, x = (a.ravel() for a in np.mgrid[-2:3, -2:3].astype(float))
    terms = [y**i * x ** (degree - i) for degree in range(5) for i in range(degree + 1)]
    columns = np.stack(terms, axis=1)
    rows = np.ascontiguousarray(np.linalg.pinv(columns))
    return rows, np.eye(25) - columns @ rows


_QUARTIC, _RESIDUAL = _quartic_rows()


@inner()
def local_fit(heights, periodic, row, col, c):
    """Quartic through the 5 x 5 points about a pixel, the first 15 of c (40,); True where it
    represents them.

    It does if no point is off by more than `_LOCAL` of their range. Such a fit is as good as the
    spline and does not feel kinks of the map that are three or more pixels away.
    """
    ny, nx = heights.shape
    low, high = np.inf, -np.inf
    inside = 2 <= row < ny - 2 and 2 <= col < nx - 2
    if not (inside or periodic):
        return False
    top = heights[row, col]
    for a in range(5):
        i = row + a - 2 if inside else (row + a - 2) % ny
        for b in range(5):
            j = col + b - 2 if inside else (col + b - 2) % nx
            z = heights[i, j] - top
            c[15 + 5 * a + b] = z
            low = z if z < low else low
            high = z if z > high else high
    for m in range(25):
        off = 0.0
        for k in range(25):
            off += _RESIDUAL[m, k] * c[15 + k]
        if abs(off) > _LOCAL * (high - low):
            return False
    for m in range(15):
        c[m] = 0.0
        for k in range(25):
            c[m] += _QUARTIC[m, k] * c[15 + k]
    c[0] += top
    return True


@inner()
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


@inner()
def _newton(e):
    """Newton step uphill, with the absolute values of the principal curvatures.

    Returns the step along y and x, and whether the expansion `e` is concave. An expansion that is
    level along a ridge, where the curvature is rounding, counts as concave.
    """
    mean, shear, cross = 0.5 * (e[3] + e[5]), 0.5 * (e[3] - e[5]), e[4]
    half = math.sqrt(shear * shear + cross * cross)
    size = abs(mean) + half
    high, low = mean + half, mean - half
    if high < -_LEVEL * size:
        scale = -1.0 / (high * low)
        return (e[5] * e[1] - cross * e[2]) * scale, (e[3] * e[2] - cross * e[1]) * scale, True
    turn = 0.5 * math.atan2(2.0 * cross, e[5] - e[3])
    along_x, along_y = math.cos(turn), math.sin(turn)
    first = (e[2] * along_x + e[1] * along_y) / max(abs(high), _LEVEL * size)
    second = (e[1] * along_x - e[2] * along_y) / max(abs(low), _LEVEL * size)
    step_y = first * along_y + second * along_x
    step_x = first * along_x - second * along_y
    return step_y, step_x, high < _LEVEL * size


@inner()
def climb(heights, flat, width, labels, periodic, row, col, n, tilt, c):
    """Climb from the summit pixel of peak n to the maximum of the interpolated surface.

    The surface is tilted: it falls by `tilt` (2,) [m per pixel] along y and x.

    Newton steps with the absolute values of the principal curvatures, of at most `_LONGEST`,
    on the local quartic `c` where it represents the map and else on the spline. Returns y, x
    [pixels], the expansion there and what was found: `SUMMIT`, `PLATEAU` (none within reach),
    `RIM` (the same at the border of a map) or 1 + m, if it leads into the basin of another peak m.
    """
    ny, nx = heights.shape
    local = local_fit(heights, periodic, row, col, c)
    y, x = float(row), float(col)
    for _ in range(30):
        e = _quartic(c, y - row, x - col) if local else expand(flat, width, y, x)
        if e[3] == 0.0 and e[4] == 0.0 and e[5] == 0.0:
            break
        e = (e[0], e[1] - tilt[0], e[2] - tilt[1], e[3], e[4], e[5])
        step_y, step_x, concave = _newton(e)
        length = max(abs(step_y), abs(step_x))
        if concave and length < 1e-9:
            if not periodic and not (0.0 <= y <= ny - 1.0 and 0.0 <= x <= nx - 1.0):
                break
            return y, x, e, SUMMIT
        scale = _LONGEST / length if length > _LONGEST else 1.0
        y += scale * step_y
        x += scale * step_x
        away = max(abs(y - row), abs(x - col))
        if not periodic and not (-0.5 <= y < ny - 0.5 and -0.5 <= x < nx - 0.5):
            break
        if away > 1.25:
            label = labels[math.floor(y + 0.5) % ny, math.floor(x + 0.5) % nx]
            if label >= 0 and label != n:
                return float(row), float(col), e, 1 + label
        if away > (1.25 if local else 3.0):
            if not local:
                break
            local = False
    if not periodic and (row in (0, ny - 1) or col in (0, nx - 1)):
        return float(row), float(col), e, RIM
    return float(row), float(col), e, PLATEAU


@compiled()
def summits(
    heights, spline, labels, periodic, row, col, tilt, order, places, expansions, kinds, first, last
):
    """Climb from the peaks ``order[first:last]``: places (n, 2), expansions (n, 6), kinds (n,)."""
    flat, width, c = spline.ravel(), spline.shape[1], np.empty(40)
    for k in range(first, last):
        n = order[k]
        if k + _AHEAD < last:
            other = order[k + _AHEAD]
            prefetch_block(heights, heights.shape[1], row[other] - 2, col[other] - 2, 5, 5)
            prefetch_block(flat, width, row[other] + PAD - 3, col[other] + PAD - 3, 8, 8)
        y, x, e, kind = climb(heights, flat, width, labels, periodic, row[n], col[n], n, tilt[n], c)
        places[n, 0] = y
        places[n, 1] = x
        kinds[n] = kind
        for i in range(6):
            expansions[n, i] = e[i]


@compiled()
def uphill(heights, labels, owner, periodic, tilt, rows, row, col):
    """Move the pixels (row, col) of the peaks `rows` to the maxima of the tilted map about them.

    Steps lead to the highest of the eight neighbors of the same peak. A walk once round a periodic
    cell would climb for ever (a level ridge that runs round it): its pixel stays where it is.
    """
    ny, nx = heights.shape
    for n in rows:
        y, x = row[n], col[n]
        while True:
            best, up, right = 0.0, 0, 0
            here = heights[y % ny, x % nx]
            for step in range(9):
                r, c = y + step // 3 - 1, x + step % 3 - 1
                if not periodic and (r < 0 or c < 0 or r >= ny or c >= nx):
                    continue
                label = labels[r % ny, c % nx]
                if label < 0 or owner[label] != n:
                    continue
                rise = heights[r % ny, c % nx] - here
                rise -= tilt[n, 0] * (r - y) + tilt[n, 1] * (c - x)
                if rise > best:
                    best, up, right = rise, r - y, c - x
            if best == 0.0:
                break
            y, x = y + up, x + right
            if abs(y - row[n]) >= ny or abs(x - col[n]) >= nx:
                y, x = row[n], col[n]
                break
        row[n], col[n] = y % ny, x % nx


@inner()
def _frame(a, b, c):
    """Principal curvatures k1 >= k2 > 0 of (a x^2 + 2 b x y + c y^2)/2 and the axis of k2."""
    half = math.hypot(0.5 * (a - c), b)
    k1 = 0.5 * (a + c) + half
    k2 = max(0.5 * (a + c) - half, FLATTEST * k1)
    axis = 0.5 * math.atan2(2.0 * b, a - c) + 0.5 * math.pi
    return k1, k2, axis - math.pi if axis > 0.5 * math.pi else axis


@compiled()
def frames(height, rows, spacing, depth, pixels, places, expansions, kinds):
    """Place and height (n, 3), principal curvatures (n, 2) and direction (n,) of all peaks.

    Without a summit: the `height` of the pixel, and the round paraboloid that fills the basin down
    to its `depth`, whose axis lies along the border if it stands there (of so many `rows`). A tip
    such as that of r^4 is round as well: all that it has of a curvature is rounding, which has no
    axis.
    """
    dy, dx = spacing
    summit, curvature = np.empty((height.size, 3)), np.empty((height.size, 2))
    angle = np.empty(height.size)
    for n in range(height.size):
        found = kinds[n] == SUMMIT
        filled = 2.0 * math.pi * depth[n] / (pixels[n] * dy * dx)
        a, b, c = filled, 0.0, filled
        if found:
            a = -expansions[n, 5] / (dx * dx)
            b = -expansions[n, 4] / (dx * dy)
            c = -expansions[n, 3] / (dy * dy)
            if a + c < _LEVEL * filled:
                a, b, c = 0.5 * (a + c), 0.0, 0.5 * (a + c)
        curvature[n, 0], curvature[n, 1], angle[n] = _frame(a, b, c)
        if kinds[n] == RIM and (places[n, 0] == 0.0 or places[n, 0] == rows - 1.0):
            angle[n] = 0.0
        summit[n, 0], summit[n, 1] = (places[n, 1] + 0.5) * dx, (places[n, 0] + 0.5) * dy
        summit[n, 2] = expansions[n, 0] if found else height[n]
    return summit, curvature, angle
