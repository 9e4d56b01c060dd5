"""Numba kernel of the frames and fits of a block of profiles."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from surfaces.numerics.compiled import QUOTIENTS, compiled, inner
from surfaces.numerics.lane_functions import (
    between,
    exponential,
    least,
    logarithm,
    most,
    sine_cosine,
)
from surfaces.numerics.lane_layout import collect_rows, groups, ordered, spread_rows
from surfaces.numerics.lanes import LANES, load, splat, store
from surfaces.numerics.vectors import root, where, whole

from ._fit_kernels import FITS, TERMS, fit, fit_space, usable

SMALLEST_RATIO = 1 / 40
"""Least axis ratio of the ellipses on which a summit is fitted."""

SCALES = LANES
"""Numbers of a profile: length, height, area of the basin in squared lengths, ratio of the rays,
semi-axes of the first ellipse as logarithms, shortest ray, and 1 where there is a usable fit."""

_POWER = 0.63
"""The axis ratio of a Hertzian contact is about this power of the ratio of curvatures."""


@inner(fastmath=QUOTIENTS)
def _frame(phi, angle, weight, large, small, edge, q, nodes, skews, rays, scales, frame, wide):
    """Length, height, ratio of the rays and number of the base ellipse of profiles.

    Fills, in groups, `frame` with the directions of the rays in the axes of the summit, their
    lengths, and their lengths in the ellipse of semi-axes 1/`wide`; and all `scales` but the
    semi-axes and the last. Returns the numbers. The ellipse has about the axis ratio of the
    Hertzian contact; the largest fit reaches 1.1 times the rms distance of the basin edge in units
    of it.
    """
    ray = rays // 8
    for p in range(rays):
        turn = load(phi, p) - angle
        turn -= (2 * math.pi) * whole(turn * (0.5 / math.pi) + 0.5)
        s, c = sine_cosine(0.5 * turn)
        store(frame, p, 1.0 - 2.0 * s * s)
        store(frame, rays + p, 2.0 * s * c)
    stretch = math.tan(2 * math.pi * ray / rays) * load(frame, ray) / load(frame, rays + ray)
    ratio = between(small / large, splat(0.0), splat(1.0))
    ratio = most(_POWER * logarithm(most(ratio, splat(1e-300))), splat(math.log(SMALLEST_RATIO)))
    ratio = where(large > 0.0, ratio, 0.0)
    step = math.log(skews[1] / skews[0])
    number = whole(-(ratio + logarithm(stretch) + math.log(skews[0])) * (1 / step) + 0.5)
    number = between(number, splat(0.0), splat(skews.size - 1.0))
    across = root(skews[0] * exponential(step * number) * stretch)
    along = 1.0 / across
    square, top = splat(0.0), splat(0.0)
    for p in range(rays):
        cx, cy, length = load(frame, p) * along, load(frame, rays + p) * across, load(edge, p)
        unit = cx * cx + cy * cy
        square += length * length * unit
        store(frame, 3 * rays + p, 1.0 / root(unit))
        top = most(load(q, p * nodes + nodes - 1) * length * length, top)
    length = 1.1 * root(square * (1 / rays))
    inverse = 1.0 / length
    basin, smallest = splat(0.0), splat(1e300)
    for p in range(rays):
        own = load(edge, p) * inverse
        store(frame, 2 * rays + p, own)
        store(frame, 3 * rays + p, load(frame, 3 * rays + p) * length)
        basin += 0.5 * load(weight, p) * own * own
        smallest = least(own, smallest)
    store(scales, 0, length)
    store(scales, 1, 2.0 * top)
    store(scales, 2, basin)
    store(scales, 3, stretch)
    store(scales, 6, smallest)
    store(wide, 0, along)
    store(wide, 1, across)
    return number


@inner(fastmath=QUOTIENTS)
def _first_ellipse(coefs, depth, m, scales):
    """Logarithms of the semi-axes for the paraboloids in the smallest fits."""
    o = (FITS - 1) * TERMS
    along, across = most(load(coefs, o + 3), splat(1e-300)), most(load(coefs, o + 5), splat(1e-30))
    ratio = most(_POWER * logarithm(along / across), splat(math.log(SMALLEST_RATIO)))
    mean = logarithm(across) + (0.5 / _POWER) * ratio
    size = 0.5 * (math.log(0.5 * depth * (1 + m)) - mean)
    store(scales, 4, size - 0.5 * ratio)
    store(scales, 5, size + 0.5 * ratio)


def frame_space(rays: int, nodes: int, rules: tuple[Any, ...]) -> tuple[Any, ...]:
    """Working groups of `fit_rows`.

    A block, directions, weights, lengths and nodes of the rays; frames, scales, semi-axes, numbers
    of base ellipses, fits and single numbers; those of `fit`.
    """
    radii, rings, image = rules[1][:3]
    row = -(-rays // LANES)
    samples = (LANES, row * LANES, row * LANES, row * LANES, -(-rays * nodes // LANES) * LANES)
    own = (4 * rays, SCALES, 2, 1, -(-FITS * TERMS // LANES) * LANES, 3)
    fitting = fit_space(rays, radii.size, image.shape[0] * rings.shape[1])
    return tuple(map(groups, samples)), tuple(map(groups, own)), fitting


@compiled()
def fit_rows(begin, end, profiles, rules, depth, m, frames, coefs, scales, space):
    """Frames (rows of directions, lengths and reaches of the rays), fits and scales of profiles.

    Row 0 of the results belongs to the profile `begin`; the last of the `scales` is zero where a
    profile has no usable fit. `depth` is the smallest approach.
    """
    phis, angles, weights, curvatures, edges, qs, valid, rays, nodes = profiles
    skews, fitting = rules
    n = end - begin
    (block, phi, weight, edge, q), (frame, own, wide, numbers, fits, single), working = space
    who, chosen = np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    axes, number = np.zeros((n, 2)), np.zeros(n, np.int64)
    for i in range(0, n, LANES):
        count = min(LANES, n - i)
        for lane in range(LANES):
            k = begin + i + min(lane, count - 1)
            who[lane] = k
            single[lane], single[LANES + lane] = angles[k], curvatures[k, 0]
            single[2 * LANES + lane] = curvatures[k, 1]
        for source, target in ((phis, phi), (weights, weight), (edges, edge), (qs, q)):
            spread_rows(source, who, target, block)
        found = _frame(
            phi, load(single, 0), weight, load(single, 1), load(single, 2), edge, q, nodes, skews,
            rays, own, frame, wide,
        )  # fmt: skip
        store(numbers, 0, found)
        for lane in range(LANES):
            who[lane] = i + lane
        for source, rows in ((frame, frames), (own, scales)):
            collect_rows(source, rows, who, count, block)
        for lane in range(count):
            k = i + lane
            axes[k, 0], axes[k, 1] = wide[lane], wide[LANES + lane]
            fine = valid[begin + k] and scales[k, 0] > 0.0 and scales[k, 1] > 0.0
            number[k] = int(numbers[lane]) if fine else skews.size
            scales[k, LANES - 1] = 0.0
    order = ordered(number, skews.size)
    taken = 0
    for i in range(n):
        k = order[i]
        if number[k] == skews.size:
            break
        for lane in range(taken, LANES):
            who[lane] = k
        taken += 1
        if taken < LANES and i + 1 < n and number[order[i + 1]] == number[k]:
            continue
        for lane in range(LANES):
            wide[lane], wide[LANES + lane] = axes[who[lane], 0], axes[who[lane], 1]
            chosen[lane] = begin + who[lane]
        for source, at, target in (
            (frames, who, frame), (scales, who, own), (edges, chosen, edge), (qs, chosen, q)
        ):  # fmt: skip
            spread_rows(source, at, target, block)
        fit(
            q, nodes, edge, 0.25 / load(own, 1), frame[3 * rays * LANES :], wide, fitting,
            number[k], fits, working,
        )  # fmt: skip
        _first_ellipse(fits, depth, m, own)
        store(own, SCALES - 1, usable(fits))
        for source, rows in ((fits, coefs), (own, scales)):
            collect_rows(source, rows, who, taken, block)
        taken = 0
