# mypy: disallow-untyped-defs=False
"""Kernel of the profiles: rays from the summits to the edges of their basins."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ._climb import FLATTEST, RIM, SUMMIT, nearest, wrapped
from ._spline import evaluate

_MOST_SAMPLES = 512
_BEYOND = 1.1  # rays run on beyond their basin by this factor: see fit_profiles
_FOLD = 1.7  # half a paraboloid at the border carries 0.77 of the load, on 0.58 of the area (BEM)
_TINY = 1e-300
_NARROWEST = math.sqrt(1.0 / 8.0)  # least aspect of the ellipse on which the rays are spread


@njit(cache=True, nogil=True, error_model="numpy")
def aspect_of(k1, k2):
    """Aspect of the ellipse on which the rays are spread: the root of that of the contact."""
    return max((k2 / k1) ** (1.0 / 3.0), _NARROWEST)


@njit(cache=True, nogil=True, error_model="numpy")
def _folded(way, fold):
    """Component of a ray; across a border it always leads inwards, and further."""
    return fold * abs(way) if fold != 0.0 else way


@njit(cache=True, nogil=True, error_model="numpy")
def _edge(flat, width, labels, owner, periodic, dip, n, y0, x0, z0, step_y, step_x, radii, fs):
    """Length of a ray of peak n: to the first local maximum of f, or to its limit.

    `step_y` and `step_x` lead one pixel on, `radii` and the length are in units of that; `fs` is
    room for the samples.
    """
    ny, nx = labels.shape
    limit = np.inf
    if periodic:  # half-way to the image of the summit
        limit = min(0.5 * ny / max(abs(step_y), _TINY), 0.5 * nx / max(abs(step_x), _TINY))
    top, outside, last = 0, 0, 0
    fs[0] = 0.0
    for m in range(1, radii.size):
        y, x = y0 + radii[m] * step_y, x0 + radii[m] * step_x
        if periodic:
            y, x = wrapped(y, ny), wrapped(x, nx)
        elif not (-0.5 <= y < ny - 0.5 and -0.5 <= x < nx - 0.5):
            break
        last = m
        fs[m] = z0 - evaluate(flat, width, y, x)
        label = labels[nearest(y, ny), nearest(x, nx)]
        outside = 0 if label == n or label < 0 or owner[label] == n else outside + 1
        if m == 1 or fs[m] > fs[top]:
            top = m
        elif fs[m] <= fs[top] - dip:
            break
        if outside == 2:
            limit = min(limit, _BEYOND * 0.5 * (radii[m - 2] + radii[m - 1]))
        if radii[m] > limit:
            break
    edge = radii[top]
    if 0 < top < last:  # the vertex of the parabola through the highest sample
        left, right = radii[top] - radii[top - 1], radii[top + 1] - radii[top]
        up = (fs[top] - fs[top - 1]) / left
        down = (fs[top] - fs[top + 1]) / right
        if up + down > 0.0:
            edge += 0.5 * (up * right - down * left) / (up + down)
    return max(min(edge, limit), 0.5)


@njit(cache=True, nogil=True, error_model="numpy")
def fan(count, aspect, cosines, sines, weights):
    """Directions and quadrature weights of the rays of one peak, in the frame of its ellipse.

    Equal steps of the parameter of the ellipse of semi-axes 1 and `aspect`; `cosines` and `sines`
    hold those of the parameter on entry and those of the directions on return.
    """
    total = 0.0
    for p in range(count):
        u, v = cosines[p], aspect * sines[p]
        inverse = 1.0 / (u * u + v * v)
        length = math.sqrt(inverse)
        cosines[p], sines[p] = u * length, v * length
        weights[p] = inverse
        total += inverse
    for p in range(count):
        weights[p] *= 2.0 * math.pi / total


@njit(cache=True, nogil=True, error_model="numpy")
def _steps():
    """Radii [pixels] at which the rays are looked at: steps of half a pixel that grow with it."""
    radii = np.zeros(_MOST_SAMPLES)
    radii[1] = 1.0
    for m in range(2, _MOST_SAMPLES):
        radii[m] = radii[m - 1] + max(0.5, 0.1 * radii[m - 1])
    return radii


@njit(cache=True, nogil=True, error_model="numpy")
def fit(
    flat, width, labels, owner, periodic, spacing, row, col, pixels, dip, places, kinds, height,
    curvature, angle, rows, order, phi, weight, edge, q, start, stop,
):  # fmt: skip
    """Fill the rays of the peaks ``rows[order[start:stop]]``; see `surfaces.profiles.Profiles`."""
    ny, nx = labels.shape
    dy, dx = spacing
    rays, nodes = q.shape[1:]
    steps_x, steps_y = np.empty(rays), np.empty(rays)
    for p in range(rays):
        steps_x[p] = math.cos(2.0 * math.pi * p / rays)
        steps_y[p] = math.sin(2.0 * math.pi * p / rays)
    along, across = np.empty(rays), np.empty(rays)
    shares, inverse_squares = np.zeros(nodes), np.ones(nodes)
    for j in range(1, nodes):
        shares[j] = j / (nodes - 1.0)
        inverse_squares[j] = 1.0 / (shares[j] * shares[j])
    radii = _steps()
    fs = np.empty(_MOST_SAMPLES)
    for rank in range(start, stop):
        k = order[rank]
        n = rows[k]
        y0, x0, z0 = places[n, 0], places[n, 1], height[n]
        k1, k2 = curvature[n, 0], curvature[n, 1]
        fold_y, fold_x = 0.0, 0.0
        if kinds[n] == RIM:
            fold_y = _FOLD if row[n] == 0 else (-_FOLD if row[n] == ny - 1 else 0.0)
            fold_x = _FOLD if col[n] == 0 else (-_FOLD if col[n] == nx - 1 else 0.0)
        for p in range(rays):
            along[p], across[p] = steps_x[p], steps_y[p]
        fan(rays, aspect_of(k1, k2), along, across, weight[k])
        axis_x, axis_y = math.cos(angle[n]), math.sin(angle[n])
        for p in range(rays):
            # the rays p and -p lie symmetric about the axis
            turn = math.atan2(across[p], along[p]) if 2 * p <= rays else angle[n] - phi[k, rays - p]
            phi[k, p] = angle[n] + turn
            q[k, p, 0] = 0.5 * (k2 * along[p] * along[p] + k1 * across[p] * across[p])
        if kinds[n] > 0:  # the basin of another peak
            for p in range(rays):
                edge[k, p] = math.sqrt(pixels[n] * dy * dx / math.pi)
                for j in range(1, nodes):
                    q[k, p, j] = q[k, p, 0]
            continue
        for p in range(rays):
            to_y = _folded((along[p] * axis_y + across[p] * axis_x) / dy, fold_y)
            to_x = _folded((along[p] * axis_x - across[p] * axis_y) / dx, fold_x)
            pixel = 1.0 / max(abs(to_y), abs(to_x))
            way_y, way_x = to_y * pixel, to_x * pixel
            end = _edge(
                flat, width, labels, owner, periodic, dip, n, y0, x0, z0, way_y, way_x, radii, fs
            )
            edge[k, p] = end * pixel
            square = edge[k, p] * edge[k, p]
            inverse, least = 1.0 / square, FLATTEST * q[k, p, 0] * square
            last = 0.0
            for j in range(1, nodes):
                r = end * shares[j]
                y, x = y0 + r * way_y, x0 + r * way_x
                if periodic:
                    y, x = wrapped(y, ny), wrapped(x, nx)
                f = z0 - evaluate(flat, width, y, x)
                floor = least * shares[j] * shares[j]
                last = f if f > last else last
                last = floor if floor > last else last
                q[k, p, j] = last * inverse * inverse_squares[j]
            if kinds[n] != SUMMIT:
                q[k, p, 0] = q[k, p, 1]
