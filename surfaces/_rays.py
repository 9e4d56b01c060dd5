"""Kernel of the profiles: sub-pixel summits, principal curvatures, and rays to the basin edge."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ._spline import evaluate, expand

_MOST_SAMPLES = 512
_FLATTEST = 1e-3  # least ratio of the principal curvatures, and least q relative to the tip
_NARROWEST = math.sqrt(1.0 / 8.0)  # least aspect of the ellipse on which the rays are spread
_FEWEST_PIXELS = 9.0
_LOCAL = 1e-4


def _quartic_rows() -> NDArray[np.float64]:
    """Least-squares coefficients of a quartic on 5 x 5 points, shape (15, 25)."""
    y, x = (a.ravel() for a in np.mgrid[-2:3, -2:3].astype(float))
    terms = [y**i * x ** (degree - i) for degree in range(5) for i in range(degree + 1)]
    return np.ascontiguousarray(np.linalg.pinv(np.stack(terms, axis=1)))


_QUARTIC = _quartic_rows()


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
        points[k] = heights[i, j]
        low, high = min(low, points[k]), max(high, points[k])
    for m in range(15):
        c[m] = 0.0
        for k in range(25):
            c[m] += _QUARTIC[m, k] * points[k]
    for k in range(25):
        h = _quartic(c, k // 5 - 2.0, k % 5 - 2.0)[0]
        if abs(h - points[k]) > _LOCAL * (high - low):
            return False
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _quartic(c, y, x):
    """Height, gradient and second derivatives (h, h_y, h_x, h_yy, h_xy, h_xx) of the quartic."""
    h, h_y, h_x, h_yy, h_xy, h_xx = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    m = 0
    for degree in range(5):
        for i in range(degree + 1):
            j = degree - i
            yi, xj = y**i, x**j
            yi1, xj1 = (i * y ** (i - 1) if i > 0 else 0.0), (j * x ** (j - 1) if j > 0 else 0.0)
            h += c[m] * yi * xj
            h_y += c[m] * yi1 * xj
            h_x += c[m] * yi * xj1
            h_xy += c[m] * yi1 * xj1
            if i > 1:
                h_yy += c[m] * i * (i - 1) * y ** (i - 2) * xj
            if j > 1:
                h_xx += c[m] * j * (j - 1) * x ** (j - 2) * yi
            m += 1
    return h, h_y, h_x, h_yy, h_xy, h_xx


@njit(cache=True, nogil=True, error_model="numpy")
def summit_of(flat, width, row, col, c, local):
    """Maximum near a pixel of the local quartic or else of the spline: damped Newton steps.

    Returns y, x [pixels], the expansion there, and whether a maximum was reached within a pixel.
    """
    y, x = float(row), float(col)
    for _ in range(20):
        e = _quartic(c, y - row, x - col) if local else expand(flat, width, y, x)
        det = e[3] * e[5] - e[4] * e[4]
        if not (det > 0.0 and e[3] < 0.0):
            break
        step_y = -(e[5] * e[1] - e[4] * e[2]) / det
        step_x = -(e[3] * e[2] - e[4] * e[1]) / det
        size = max(abs(step_y), abs(step_x))
        if size < 1e-9:
            return y, x, e, True
        scale = min(1.0, 0.5 / size)
        y += scale * step_y
        x += scale * step_x
        if abs(y - row) > 1.0 or abs(x - col) > 1.0:
            break
    return float(row), float(col), e, False


@njit(cache=True, nogil=True, error_model="numpy")
def _wrapped(at, n):
    while at < 0.0:
        at += n
    while at >= n:
        at -= n
    return at


@njit(cache=True, nogil=True, error_model="numpy")
def _pixel(at, n):
    nearest = int(at + 0.5)
    return nearest if nearest < n else nearest - n


@njit(cache=True, nogil=True, error_model="numpy")
def fit(
    heights, flat, width, labels, periodic, spacing, order, row, col, prominence, pixels, dip,
    summits, curvature, angle, phi, weight, edge, q, valid, start, stop,
):  # fmt: skip
    """Fill the profiles of the peaks ``order[start:stop]``; see `surfaces.profiles.Profiles`."""
    ny, nx = heights.shape
    dy, dx = spacing
    rays, nodes = q.shape[1:]
    rs = np.empty(_MOST_SAMPLES)
    fs = np.empty(_MOST_SAMPLES)
    quartic = np.empty(15)
    for place in range(start, stop):
        n = order[place]
        local = local_fit(heights, periodic, row[n], col[n], quartic)
        y0, x0, e, found = summit_of(flat, width, row[n], col[n], quartic, local)
        z0 = e[0] if found else heights[row[n], col[n]]
        a, b, c = -e[5] / (dx * dx), -e[4] / (dx * dy), -e[3] / (dy * dy)
        if not found:
            # a plateau, a spike or a border: the paraboloid that fills the basin
            a = 2.0 * math.pi * prominence[n] / (pixels[n] * dy * dx)
            b, c = 0.0, a
        half = math.hypot(0.5 * (a - c), b)
        k1 = 0.5 * (a + c) + half
        k2 = max(0.5 * (a + c) - half, _FLATTEST * k1)
        long_axis = 0.5 * math.atan2(2.0 * b, a - c) + 0.5 * math.pi
        if long_axis > 0.5 * math.pi:
            long_axis -= math.pi
        summits[n, 0] = (x0 + 0.5) * dx
        summits[n, 1] = (y0 + 0.5) * dy
        summits[n, 2] = z0
        curvature[n, 0] = k1
        curvature[n, 1] = k2
        angle[n] = long_axis

        aspect = max((k2 / k1) ** (1.0 / 3.0), _NARROWEST)
        total = 0.0
        for p in range(rays):
            turn = 2.0 * math.pi * p / rays
            u, v = math.cos(turn), aspect * math.sin(turn)
            phi[n, p] = long_axis + math.atan2(v, u)
            weight[n, p] = aspect / (u * u + v * v)
            total += weight[n, p]
        covered = 0.0
        for p in range(rays):
            weight[n, p] *= 2.0 * math.pi / total
            way_y, way_x = math.sin(phi[n, p]) / dy, math.cos(phi[n, p]) / dx
            pixel = 1.0 / max(abs(way_y), abs(way_x))
            edge[n, p] = 0.0
            top = 0
            outside = 0
            m = 0
            r = 0.0
            rs[0], fs[0] = 0.0, 0.0
            while found and m + 1 < _MOST_SAMPLES:
                r += pixel if m == 0 else max(0.5 * pixel, 0.1 * r)
                y, x = y0 + r * way_y, x0 + r * way_x
                if periodic:
                    y, x = _wrapped(y, ny), _wrapped(x, nx)
                elif not (-0.5 <= y <= ny - 0.5 and -0.5 <= x <= nx - 0.5):
                    break
                m += 1
                rs[m] = r
                fs[m] = z0 - evaluate(flat, width, y, x)
                label = labels[_pixel(y, ny), _pixel(x, nx)]
                outside = outside + 1 if label >= 0 and label != n else 0
                if fs[m] > fs[top] or m == 1:
                    top = m
                elif fs[m] <= fs[top] - dip:
                    break
                if outside == 2:
                    top = min(top, m - 2)
                    edge[n, p] = 0.5 * (rs[m - 2] + rs[m - 1])
                    break
            if edge[n, p] == 0.0:
                edge[n, p] = rs[top]
                if 0 < top < m:
                    left, right = rs[top] - rs[top - 1], rs[top + 1] - rs[top]
                    up = (fs[top] - fs[top - 1]) / left
                    down = (fs[top] - fs[top + 1]) / right
                    if up + down > 0.0:
                        edge[n, p] += 0.5 * (up * right - down * left) / (up + down)
            edge[n, p] = max(edge[n, p], 0.5 * pixel)
            covered += 0.5 * weight[n, p] * edge[n, p] ** 2
        valid[n] = found and covered >= _FEWEST_PIXELS * dy * dx

        for p in range(rays):
            t = phi[n, p] - long_axis
            tip = 0.5 * (k2 * math.cos(t) ** 2 + k1 * math.sin(t) ** 2)
            if not valid[n]:
                around = math.sqrt(pixels[n] * dy * dx / math.pi)
                edge[n, p] = max(edge[n, p], around)
                for j in range(nodes):
                    q[n, p, j] = tip
                continue
            way_y, way_x = math.sin(phi[n, p]) / dy, math.cos(phi[n, p]) / dx
            q[n, p, 0] = tip
            last = 0.0
            for j in range(1, nodes):
                r = edge[n, p] * j / (nodes - 1)
                y, x = y0 + r * way_y, x0 + r * way_x
                if periodic:
                    y, x = _wrapped(y, ny), _wrapped(x, nx)
                last = max(last, z0 - evaluate(flat, width, y, x), _FLATTEST * tip * r * r)
                q[n, p, j] = last / (r * r)
