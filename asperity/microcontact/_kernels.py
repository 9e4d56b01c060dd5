"""Compiled loops over contacts: table evaluation, and the expansion of sampled profiles."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ._lanes import FAST

__all__ = ["evaluate_table", "expand_profiles", "resample"]


@njit(cache=True, nogil=True)
def evaluate_table(rows, approach, reach, force, stiffness, area, p):  # type: ignore[no-untyped-def]
    """Force, its derivative and area at `approach`; see `LawTable`."""
    n = rows.size
    intervals = force.shape[1] - 1
    out = np.zeros((3, n))
    scale = np.ones(intervals + 1)
    for j in range(1, intervals + 1):
        scale[j] = (j / intervals) ** (-p)
    for i in range(n):
        row, d = rows[i], approach[i]
        top = reach[row]
        if d <= 0.0 or top <= 0.0:
            continue
        if d >= top:
            out[0, i] = force[row, intervals] + stiffness[row, intervals] * (d - top)
            out[1, i] = stiffness[row, intervals]
            out[2, i] = area[row, intervals]
            continue
        u = math.sqrt(d / top)
        x = u * intervals
        j = min(int(x), intervals - 1)
        x -= j
        step = 1.0 / intervals
        u1 = (j + 1) * step
        s1 = force[row, j + 1] * scale[j + 1]
        g1 = 2.0 * u1 * top * stiffness[row, j + 1] * scale[j + 1] - p * s1 / u1
        b1 = area[row, j + 1] / (u1 * u1)
        if j == 0:
            s, g, b = s1 + g1 * (u - u1), g1, b1
        else:
            u0 = j * step
            s0 = force[row, j] * scale[j]
            g0 = 2.0 * u0 * top * stiffness[row, j] * scale[j] - p * s0 / u0
            y = 1.0 - x
            s = s0 * (1.0 + 2.0 * x) * y * y + s1 * x * x * (3.0 - 2.0 * x)
            s += step * x * y * (g0 * y - g1 * x)
            g = 6.0 * x * y * (s1 - s0) / step
            g += g0 * y * (1.0 - 3.0 * x) + g1 * x * (3.0 * x - 2.0)
            b = area[row, j] / (u0 * u0) * y + b1 * x
        power = u * u * u if p == 3.0 else u**p
        out[0, i] = power * s
        out[1, i] = power * (p * s / u + g) / (2.0 * u * top)
        out[2, i] = b * u * u
    return out


@njit(cache=True, nogil=True, fastmath=FAST, error_model="numpy")
def _cubics(q, out):  # type: ignore[no-untyped-def]
    """Coefficients of powers of x in [0, 1] on the cells of all rays, with parabolic slopes."""
    last = q.shape[1] - 1
    for k in range(q.shape[0]):
        before = q[k, 1] - q[k, 0]
        slope = before - 0.5 * (q[k, 2] - q[k, 1] - before)
        for c in range(last):
            rise = q[k, c + 1] - q[k, c]
            if c + 1 < last:
                following = 0.5 * (rise + q[k, c + 2] - q[k, c + 1])
            else:
                following = rise + 0.5 * (rise - before)
            out[k, c, 0] = q[k, c]
            out[k, c, 1] = slope
            out[k, c, 2] = 3.0 * rise - 2.0 * slope - following
            out[k, c, 3] = slope + following - 2.0 * rise
            slope, before = following, rise


@njit(cache=True, nogil=True, fastmath=FAST, error_model="numpy")
def _sample(cubics, edge, a, nodes, out):  # type: ignore[no-untyped-def]
    """f, r f', r^2 f'' at ``r = a nodes``, nodes rising, on all rays, shape (3 points, rays).

    Beyond the end of a ray f goes on with its last slope and the curvature 2q.
    """
    rays, cells, points = cubics.shape[0], cubics.shape[1], nodes.size
    furthest = a * nodes[points - 1]
    for k in range(rays):
        ratio, square = a / edge[k], edge[k] * edge[k]
        for j in range(points):
            s = ratio * nodes[j]
            x = s * cells
            cell = min(int(x), cells - 1)
            x -= cell
            c1, c2, c3 = cubics[k, cell, 1], cubics[k, cell, 2], cubics[k, cell, 3]
            value = cubics[k, cell, 0] + x * (c1 + x * (c2 + x * c3))
            first = s * cells * (c1 + x * (2.0 * c2 + 3.0 * x * c3))
            second = s * s * cells * cells * (2.0 * c2 + 6.0 * x * c3)
            scale = square * s * s
            out[j, k] = scale * value
            out[points + j, k] = scale * (2.0 * value + first)
            out[2 * points + j, k] = scale * (2.0 * value + 4.0 * first + second)
        if furthest < edge[k]:
            continue
        last = cells - 1
        c1, c2, c3 = cubics[k, last, 1], cubics[k, last, 2], cubics[k, last, 3]
        q = cubics[k, last, 0] + c1 + c2 + c3
        slope = max(2.0 * q + (c1 + 2.0 * c2 + 3.0 * c3) * cells, 0.0)
        for j in range(points):
            s = ratio * nodes[j]
            if s >= 1.0:
                over = s - 1.0
                out[j, k] = square * (q + (slope + q * over) * over)
                out[points + j, k] = square * s * (slope + 2.0 * q * over)
                out[2 * points + j, k] = square * s * s * 2.0 * q


@njit(cache=True, nogil=True)
def expand_profiles(begin, end, phi, weight, edge, q, valid, top, fractions, nodes, rules,
                    harmonics, out):  # type: ignore[no-untyped-def]  # fmt: skip
    """Approach, its slope, mean profile and squared edge amplitudes at a grid of radii.

    Fills, for the contacts [begin, end) and the radii ``top[i] * fractions[l]``, rows of: 0 D,
    1 a D', 2 the mean of G~, 3 mean square of the published numerator, 4 the same
    harmonic-resolved, 5 the sum of (m + (1-m) n) <e_n^2>, 6 and 7 the smallest and largest
    numerator (published), 8 and 9 (harmonic), 10 the share of angle on which the circle lies
    beyond the ray's end. `rules` holds the radial weights, shape (N + 4, 3 points), of f, r f' and
    r^2 f'' for the operators n = 0 ... N + 1, for G~ and for a D'. `harmonics` holds
    m + (1-m) n for n = 0 ... N + 1; what the harmonics up to N leave over is treated as harmonic
    N + 1.
    """
    rays = phi.shape[1]
    count = harmonics.size - 1
    cubics = np.empty((rays, q.shape[2] - 1, 4))
    cosine, sine = np.empty((count, rays)), np.empty((count, rays))
    share, rest = np.empty(rays), np.empty(rays)
    sample, applied = np.empty((3 * nodes.size, rays)), np.empty((count + 3, rays))
    for i in range(begin, end):
        if not valid[i]:
            continue
        _cubics(q[i], cubics)
        for k in range(rays):
            share[k] = weight[i, k] / (2.0 * math.pi)
            c, s = math.cos(phi[i, k]), math.sin(phi[i, k])
            cosine[0, k], sine[0, k] = 1.0, 0.0
            for n in range(1, count):
                cosine[n, k] = cosine[n - 1, k] * c - sine[n - 1, k] * s
                sine[n, k] = sine[n - 1, k] * c + cosine[n - 1, k] * s
        for step in range(fractions.size):
            a = top[i] * fractions[step]
            _sample(cubics, edge[i], a, nodes, sample)
            np.dot(rules, sample, applied)
            row = out[i - begin, step]
            _reduce(applied, share, cosine, sine, harmonics, rest, row)
            for k in range(rays):
                row[2] += share[k] * applied[count + 1, k]
                row[1] += share[k] * applied[count + 2, k]
                if a > edge[i, k]:
                    row[10] += share[k]


@njit(cache=True, nogil=True, fastmath=FAST)
def _reduce(applied, share, cosine, sine, harmonics, edge, row):  # type: ignore[no-untyped-def]
    """Angular part of `expand_profiles` for one radius; `edge` is working space."""
    count, rays = cosine.shape
    published_mean, approach, resolved = 0.0, 0.0, 0.0
    for k in range(rays):
        approach += share[k] * applied[0, k]
        published_mean += share[k] * applied[2, k]
        edge[k] = applied[count, k]
    row[0] = approach
    for n in range(count):
        re, im, tail_re, tail_im = 0.0, 0.0, 0.0, 0.0
        for k in range(rays):
            c, s = share[k] * cosine[n, k], share[k] * sine[n, k]
            re += c * applied[n, k]
            im += s * applied[n, k]
            tail_re += c * applied[count, k]
            tail_im += s * applied[count, k]
        if n == 0:
            for k in range(rays):
                edge[k] -= tail_re
            continue
        re, im = 2.0 * re, 2.0 * im
        tail_re, tail_im = 2.0 * tail_re, 2.0 * tail_im
        power = 0.5 * (re * re + im * im)
        resolved += power
        row[5] += harmonics[n] * power
        for k in range(rays):
            edge[k] += (re - tail_re) * cosine[n, k] + (im - tail_im) * sine[n, k]
    lowest, highest, smallest, largest = math.inf, -math.inf, math.inf, -math.inf
    square, published_square = 0.0, 0.0
    for k in range(rays):
        published = applied[2, k] - published_mean
        published_square += share[k] * published * published
        square += share[k] * edge[k] * edge[k]
        lowest, highest = min(lowest, published), max(highest, published)
        smallest, largest = min(smallest, edge[k]), max(largest, edge[k])
    row[3], row[4] = published_square, square
    row[6], row[7], row[8], row[9] = lowest, highest, smallest, largest
    row[5] += harmonics[count] * max(square - resolved, 0.0)


@njit(cache=True, nogil=True)
def resample(u, ratios, flags, good, basin, intervals, p):  # type: ignore[no-untyped-def]
    """Columns of the law table from values over rising ``u = sqrt(approach)``.

    `ratios` holds force/u^p, area/u^2 and spread, shape (3, peaks, radii); between the radii they
    are cubic through the four nearest. The table of a contact ends where the area reaches
    `basin`, else at its last `good` value.
    """
    peaks = good.size
    reach = np.zeros(peaks)
    values = np.zeros((4, peaks, intervals + 1))
    marks = np.zeros((peaks, intervals + 1), dtype=np.uint8)
    for i in range(peaks):
        last = good[i] - 1
        if last < 3:
            continue
        w, dw = np.empty(4), np.empty(4)
        end, filled = u[i, last], False
        for k in range(last + 1):
            area = ratios[1, i, k] * u[i, k] ** 2
            if area >= basin[i]:
                before = ratios[1, i, k - 1] * u[i, k - 1] ** 2 if k else 0.0
                square = u[i, k - 1] ** 2 if k else 0.0
                share = (basin[i] - before) / (area - before)
                end = math.sqrt(square + share * (u[i, k] ** 2 - square))
                filled = True
                break
        reach[i] = end * end
        base, near = 0, 0
        for j in range(1, intervals + 1):
            x = end * j / intervals
            while base + 4 < good[i] and u[i, base + 2] < x:
                base += 1
            while near < last and u[i, near] < x:
                near += 1
            _lagrange(u[i], base, x, w, dw)
            s, ds, b = 0.0, 0.0, 0.0
            for k in range(4):
                s += w[k] * ratios[0, i, base + k]
                ds += dw[k] * ratios[0, i, base + k]
                b += w[k] * ratios[1, i, base + k]
            power = x ** (p - 2.0)
            values[0, i, j] = max(power * x * x * s, values[0, i, j - 1])
            values[1, i, j] = max(0.5 * power * (p * s + x * ds), 0.5 * values[0, i, j] / (x * x))
            area = min(b * x * x, basin[i]) if filled else b * x * x
            values[2, i, j] = max(area, values[2, i, j - 1])
            values[3, i, j] = ratios[2, i, near]
            marks[i, j] = flags[i, near]
        if filled:
            values[2, i, intervals] = basin[i]
            marks[i, intervals] |= 128
    return reach, values[0], values[1], values[2], marks, values[3]


@njit(cache=True, nogil=True, error_model="numpy")
def _lagrange(u, base, x, w, dw):  # type: ignore[no-untyped-def]
    """Weights of the value and of the slope at x of the cubic through four nodes."""
    for k in range(4):
        below, product, slope = 1.0, 1.0, 0.0
        for j in range(4):
            if j == k:
                continue
            below *= u[base + k] - u[base + j]
            slope = slope * (x - u[base + j]) + product
            product *= x - u[base + j]
        w[k] = product / below
        dw[k] = slope / below
