"""Compiled loops over contacts: table evaluation, and the expansion of sampled profiles."""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange

__all__ = ["evaluate_table", "expand_profiles", "resample"]


@njit(cache=True, nogil=True)
def evaluate_table(rows, approach, reach, force, stiffness, area, p):  # type: ignore[no-untyped-def]
    """Force, its derivative and area at `approach`; see `LawTable`."""
    n = rows.size
    intervals = force.shape[1] - 1
    out = np.zeros((3, n))
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
        scale1 = u1 ** (-p)
        s1 = force[row, j + 1] * scale1
        g1 = (2.0 * u1 * u1 * top * stiffness[row, j + 1] - p * force[row, j + 1]) * scale1 / u1
        b1 = area[row, j + 1] / (u1 * u1)
        if j == 0:
            s, g, b = s1 + g1 * (u - u1), g1, b1
        else:
            u0 = j * step
            scale0 = u0 ** (-p)
            s0 = force[row, j] * scale0
            g0 = (2.0 * u0 * u0 * top * stiffness[row, j] - p * force[row, j]) * scale0 / u0
            y = 1.0 - x
            s = s0 * (1.0 + 2.0 * x) * y * y + s1 * x * x * (3.0 - 2.0 * x)
            s += step * x * y * (g0 * y - g1 * x)
            g = 6.0 * x * y * (s1 - s0) / step
            g += g0 * y * (1.0 - 3.0 * x) + g1 * x * (3.0 * x - 2.0)
            b = area[row, j] / (u0 * u0) * y + b1 * x
        power = u**p
        out[0, i] = power * s
        out[1, i] = power * (p * s / u + g) / (2.0 * u * top)
        out[2, i] = b * u * u
    return out


@njit(cache=True, nogil=True)
def _slopes(t, q, out):  # type: ignore[no-untyped-def]
    """Parabolic slopes dq/dt at the nodes of one ray."""
    last = t.size - 1
    for j in range(1, last):
        low, high = t[j] - t[j - 1], t[j + 1] - t[j]
        below, above = (q[j] - q[j - 1]) / low, (q[j + 1] - q[j]) / high
        out[j] = (below * high + above * low) / (low + high)
    out[0] = 2.0 * (q[1] - q[0]) / (t[1] - t[0]) - out[1]
    out[last] = 2.0 * (q[last] - q[last - 1]) / (t[last] - t[last - 1]) - out[last - 1]


@njit(cache=True, nogil=True)
def _sample_ray(t, bins, q, slope, edge, radius, out):  # type: ignore[no-untyped-def]
    """f, r f' and r^2 f'' of one ray at the radii; beyond the edge f goes on as a parabola."""
    last = t.size - 1
    scale = (bins.size - 1) / t[last]
    top = edge * t[last]
    end = top * top * q[last]
    end_slope = max(2.0 * top * q[last] + top * top * slope[last] / edge, 0.0)
    for j in range(radius.size):
        r = radius[j]
        if r >= top:
            over = r - top
            out[0, j] = end + (end_slope + q[last] * over) * over
            out[1, j] = r * (end_slope + 2.0 * q[last] * over)
            out[2, j] = r * r * 2.0 * q[last]
            continue
        s = r / edge
        c = bins[int(s * scale)]
        while t[c + 1] < s:
            c += 1
        width = t[c + 1] - t[c]
        x = (s - t[c]) / width
        y = 1.0 - x
        rise = q[c + 1] - q[c]
        g0, g1 = slope[c] * width, slope[c + 1] * width
        value = q[c] + rise * x * x * (3.0 - 2.0 * x) + x * y * (g0 * y - g1 * x)
        first = (6.0 * x * y * rise + g0 * y * (1.0 - 3.0 * x) + g1 * x * (3.0 * x - 2.0)) / width
        second = (6.0 * (y - x) * rise + g0 * (6.0 * x - 4.0) + g1 * (6.0 * x - 2.0)) / (
            width * width
        )
        square = r * r
        out[0, j] = square * value
        out[1, j] = square * (2.0 * value + s * first)
        out[2, j] = square * (2.0 * value + s * (4.0 * first + s * second))


@njit(cache=True, nogil=True, parallel=True)
def expand_profiles(phi, weight, edge, t, bins, q, valid, top, fractions, nodes, rules, harmonics):  # type: ignore[no-untyped-def]
    """Approach, its slope, mean profile and squared edge amplitudes at a grid of radii.

    For contact i and radius ``top[i] * fractions[l]`` the row holds: 0 D, 1 a D', 2 the mean of
    G~, 3 mean square of the published numerator, 4 the same harmonic-resolved, 5 the sum of
    (m + (1-m) n) <e_n^2>, 6 and 7 the smallest and largest numerator (published), 8 and 9
    (harmonic), 10 the share of angle on which the circle lies beyond the ray's end.
    `rules` holds the radial weights, shape (2, harmonics + 3, points): of f and of r f'; the last
    row pair that of a D' (r f', r^2 f''). `harmonics` holds m + (1-m) n for n = 0 ... N + 1; what
    the harmonics up to N leave over is treated as if it were harmonic N + 1.
    """
    peaks, rays = phi.shape
    radii, points = fractions.size, nodes.size
    count = harmonics.size - 1
    out = np.zeros((peaks, radii, 11))
    for i in prange(peaks):
        if not valid[i]:
            continue
        slope = np.empty((rays, t.size))
        cosine, sine = np.empty((count, rays)), np.empty((count, rays))
        share = weight[i] / (2.0 * math.pi)
        for k in range(rays):
            _slopes(t, q[i, k], slope[k])
            for n in range(count):
                cosine[n, k] = math.cos(n * phi[i, k])
                sine[n, k] = math.sin(n * phi[i, k])
        sample = np.empty((3, points))
        applied = np.empty((count + 1, rays))
        radius = np.empty(points)
        for step in range(radii):
            a = top[i] * fractions[step]
            for j in range(points):
                radius[j] = a * nodes[j]
            mean_g, mean_slope, beyond = 0.0, 0.0, 0.0
            for k in range(rays):
                _sample_ray(t, bins, q[i, k], slope[k], edge[i, k], radius, sample)
                g, dslope = 0.0, 0.0
                for j in range(points):
                    g += rules[0, count + 1, j] * sample[0, j]
                    dslope += rules[0, count + 2, j] * sample[1, j]
                    dslope += rules[1, count + 2, j] * sample[2, j]
                for n in range(count + 1):
                    total = 0.0
                    for j in range(points):
                        total += rules[0, n, j] * sample[0, j] + rules[1, n, j] * sample[1, j]
                    applied[n, k] = total
                mean_g += share[k] * g
                mean_slope += share[k] * dslope
                if a > edge[i, k] * t[t.size - 1]:
                    beyond += share[k]
            _reduce(applied, share, cosine, sine, harmonics, out[i, step])
            out[i, step, 1] = mean_slope
            out[i, step, 2] = mean_g
            out[i, step, 10] = beyond
    return out


@njit(cache=True, nogil=True)
def _reduce(applied, share, cosine, sine, harmonics, row):  # type: ignore[no-untyped-def]
    """Angular part of `expand_profiles` for one radius."""
    count, rays = cosine.shape
    published_mean, approach, resolved = 0.0, 0.0, 0.0
    for k in range(rays):
        approach += share[k] * applied[0, k]
        published_mean += share[k] * applied[2, k]
    row[0] = approach
    edge = applied[count].copy()
    for n in range(count):
        re, im, tail_re, tail_im = 0.0, 0.0, 0.0, 0.0
        for k in range(rays):
            re += share[k] * applied[n, k] * cosine[n, k]
            im += share[k] * applied[n, k] * sine[n, k]
            tail_re += share[k] * applied[count, k] * cosine[n, k]
            tail_im += share[k] * applied[count, k] * sine[n, k]
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
    row[6] = row[8] = math.inf
    row[7] = row[9] = -math.inf
    for k in range(rays):
        published = applied[2, k] - published_mean
        row[3] += share[k] * published * published
        row[4] += share[k] * edge[k] * edge[k]
        row[6] = min(row[6], published)
        row[7] = max(row[7], published)
        row[8] = min(row[8], edge[k])
        row[9] = max(row[9], edge[k])
    row[5] += harmonics[count] * max(row[4] - resolved, 0.0)


@njit(cache=True, nogil=True)
def resample(u, force, area, second, flags, good, basin, intervals, p):  # type: ignore[no-untyped-def]
    """Columns of the law table from values over rising ``u = sqrt(approach)``.

    The table of a contact ends where `area` reaches `basin`, else at its last `good` value.
    Between the given values force/u^p and area/u^2 are cubic through the four nearest.
    """
    peaks = good.size
    reach = np.zeros(peaks)
    values = np.zeros((4, peaks, intervals + 1))
    marks = np.zeros((peaks, intervals + 1), dtype=np.uint8)
    w, dw = np.empty(4), np.empty(4)
    for i in range(peaks):
        last = good[i] - 1
        if last < 3:
            continue
        filled = False
        for k in range(last + 1):
            if area[i, k] >= basin[i]:
                last, filled = k, True
                break
        end = u[i, last]
        if filled and last > 0:
            share = (basin[i] - area[i, last - 1]) / (area[i, last] - area[i, last - 1])
            square = u[i, last - 1] ** 2
            end = math.sqrt(square + share * (end * end - square))
        reach[i] = end * end
        base = 0
        for j in range(1, intervals + 1):
            x = end * j / intervals
            while base + 4 < good[i] and u[i, base + 2] < x:
                base += 1
            _lagrange(u[i], base, x, w, dw)
            s, ds, b = 0.0, 0.0, 0.0
            for k in range(4):
                node = u[i, base + k]
                scaled = force[i, base + k] / node**p
                s += w[k] * scaled
                ds += dw[k] * scaled
                b += w[k] * area[i, base + k] / (node * node)
            power = x**p
            values[0, i, j] = power * s
            values[1, i, j] = power * (p * s / x + ds) / (2.0 * x)
            values[2, i, j] = max(b * x * x, values[2, i, j - 1])
            near = base
            while near < last and u[i, near] < x:
                near += 1
            marks[i, j] = flags[i, near]
            values[3, i, j] = second[i, near] / (force[i, near] + 1e-300)
        if filled:
            values[2, i, intervals] = max(basin[i], values[2, i, intervals - 1])
            marks[i, intervals] |= 128
    return reach, values[0], values[1], values[2], marks, values[3]


@njit(cache=True, nogil=True)
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
