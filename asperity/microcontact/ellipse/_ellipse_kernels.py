"""Compiled search for the best ellipse over the approach, for eight profiles at once.

With the flat punch of stiffness k = k_1 s^(1+m) on the ellipse (s^2 = a b), and the displacement x
of the contour from P and Q (`_contour_kernels`), sums over the edge with the weights w:

    F = k (d - <f>) + pi s^(1+m) P_1 [sum w (P x - Q x^2/2) + S sum w P / sum w],
    dF/dd of the contour = k + pi s^(1+m) P_1^2 [sum w x + S],   S = sum S_ij x_i x_j,

where P_1 is the edge amplitude of the displacement 1, <f> the mean of f under the flat punch, and
S_ij the second-order form. At the best ellipse no parameter of the ellipse changes F.

Units inside: one length and one height per profile, modulus 1. Arrays are groups of eight numbers,
one per profile (`surfaces.numerics.lanes`).
"""

from __future__ import annotations

import math

import numpy as np

from surfaces.numerics.compiled import QUOTIENTS, compiled, inner
from surfaces.numerics.lanes import (
    LANES,
    between,
    exponential,
    groups,
    in_groups,
    load,
    most,
    sine_cosine,
    splat,
    store,
)
from surfaces.numerics.vectors import absolute, entries, some, where, whole

from ._contour_kernels import FIELDS, NODES, amplitudes, displace, limits, second_order, solve
from ._fit_kernels import NESTED_FITS, TERMS, move
from .ellipse_operator import DEGREE

LARGEST_DISPLACEMENT, LARGEST_SECOND_ORDER, LARGEST_CONFINED = 0.5, 0.05, 0.5
"""Largest displacement |x| of the contour, second-order force over the force, and share of the
contour at the edge of the basin, of a level at which the expansion is trusted."""

_LATER_STEPS = 2
"""Most Newton steps at a level after the first trusted one; a trusted level takes one."""

_SMALL_STEP = 1e-3
"""Newton step, in logarithms and angles, that ends the search at a level."""

STATES = 9
"""Numbers kept per level: force; stiffness of the contour, and its change with a uniform
displacement of the free part; areas of the ellipse and of the contour, and the change of the
latter; second-order force over the force; centre."""

SHAPE = 5 + 4 * NODES
"""Numbers of a contour: semi-axes, centre, turn and displacements at the nodes."""

_SLOPE, _BEFORE, _USED, _STEP = 5, 10, 15, 20
"""Groups of five parameters of an ellipse ("pose": logarithms of the semi-axes, turn, centre). At 0
the present pose, then its slope over ln d, the pose at the level before, the pose at which the
functional was evaluated, and the Newton step."""

SHAPE_ROW = in_groups(SHAPE)
"""`SHAPE` rounded up to whole groups."""

_STRETCH, _SMALLEST, _LEVEL, _ROUND, _FIRST, _LAST, _ALIVE = 0, 1, 2, 3, 4, 5, 6
_SINGLE = 7
"""Numbers of the profile in a lane: ratio of the rays, shortest ray, level, Newton steps made at
this level, first and last trusted level, and 1 until its last level. Their number."""


@inner(fastmath=QUOTIENTS)
def _mixed(fits, position, out):
    """Polynomials interpolated linearly between two of the nested fits: `position` 0 is the largest
    ellipse, NESTED_FITS - 1 the smallest."""
    for r in range(TERMS):
        store(out, r, splat(0.0))
    for s in range(NESTED_FITS):
        weight = most(1.0 - absolute(position - s), splat(0.0))
        for r in range(3, TERMS):
            store(out, r, load(out, r) + weight * load(fits, s * TERMS + r))


@inner(fastmath=QUOTIENTS)
def _values(coefs, a, b, depth, moments, out):
    """Terms c_ij a^i b^j of f - d, and each times its degree, for the semi-axes a, b.

    Returns the mean of f - d under the pressure of the flat punch.
    """
    mean = splat(0.0)
    outer = splat(1.0)
    for j in range(DEGREE + 1):
        power = outer
        for i in range(DEGREE + 1 - j):
            k = i + j
            r = k * (k + 1) // 2 + j
            v = load(coefs, r) * power
            if k == 0:
                v -= depth
            store(out, r, v)
            store(out, TERMS + r, k * v)
            if i % 2 == 0 and j % 2 == 0:
                mean += moments[r] * v
            power *= a
        outer *= b
    return mean


@inner()
def _enter(lane, k, coefs, frames, scales, rays, pose, present):
    """Put profile k into a lane, at its first ellipse."""
    fits, edge, _, single = present
    for i in range(NESTED_FITS * TERMS):
        fits[i * LANES + lane] = coefs[k, i]
    for p in range(rays):
        edge[p * LANES + lane] = frames[k, 2 * rays + p]
    for i in range(5):
        first = scales[k, 4 + i] if i < 2 else 0.0
        pose[i * LANES + lane] = first
        pose[(_USED + i) * LANES + lane] = first
        pose[(_SLOPE + i) * LANES + lane] = 0.5 if i < 2 else 0.0
    single[_STRETCH * LANES + lane] = scales[k, 3]
    single[_SMALLEST * LANES + lane] = scales[k, 6]
    single[_LEVEL * LANES + lane] = 0.0
    single[_ROUND * LANES + lane] = 0.0
    single[_FIRST * LANES + lane] = -1.0
    single[_LAST * LANES + lane] = -1.0


@compiled(fastmath=QUOTIENTS)
def march_rows(coefs, frames, scales, rays, levels, steps, m, rows, grid, moments, found):
    """Find the best ellipses of profiles over ascending approaches, each lane at its own pace.

    `levels` are the approaches, and the logarithms of each over the one before. Fills rows of
    the states (levels * STATES), of the contours at the last trusted levels, and of the first and
    the last trusted level, -1 for both if no level is trusted. At most `steps` Newton steps are
    made before the first trusted level; a profile ends at the first untrusted level after it. A
    lane whose profile has ended takes the next one. Profiles without a fit are left out.

    The functional is evaluated on the nearest ellipse whose axis ratio is in the tables, which
    makes an error of third order in half of their spacing.
    """
    states, shapes, ends = found
    shrink, start, step, count = grid
    depths, growths = levels
    n, size = len(scales), depths.size
    pose, local, values, system, number = (
        groups(25), groups(TERMS), groups(2 * TERMS), groups(25), groups(1),
    )  # fmt: skip
    own, fields = groups(LANES * FIELDS), groups(LANES * FIELDS)
    X, limit = groups(4 * NODES), groups(4 * NODES)  # displacements of the contour
    present = groups(NESTED_FITS * TERMS), groups(rays), groups(SHAPE), groups(_SINGLE)
    fits, edge, shape, single = present
    state, recorded = groups(STATES), groups(2)
    following = _usable_from(np.int64(0), scales)
    if following == n:
        return
    who = np.full(LANES, following)
    for lane in range(LANES):
        left = following < n  # a lane for which none is left repeats the first profile, unrecorded
        who[lane] = following if left else who[0]
        _enter(lane, who[lane], coefs, frames, scales, rays, pose, present)
        single[_ALIVE * LANES + lane] = 1.0 if left else 0.0
        following = _usable_from(following + 1, scales)
    while True:
        alive = load(single, _ALIVE) > 0.0
        if not some(alive):
            break
        level, first = load(single, _LEVEL), load(single, _FIRST)
        d = entries(depths, level)
        rounds = load(single, _ROUND) + 1.0
        store(single, _ROUND, rounds)
        along, across = load(pose, _USED), load(pose, _USED + 1)
        middle = 0.5 * (along + across)
        nearest = (across - along - start) / step + 0.5
        nearest = whole(between(nearest, splat(0.0), splat(count)))
        store(number, 0, nearest)
        half = 0.5 * (start + step * nearest)
        along, across = middle - half, middle + half
        a, b, power = exponential(along), exponential(across), exponential((1 + m) * middle)
        x0, y0 = load(pose, _USED + 3), load(pose, _USED + 4)
        hs, hc = sine_cosine(0.5 * load(pose, _USED + 2))
        ts, tc = 2.0 * hs * hc, 1.0 - 2.0 * hs * hs
        position = between(middle / shrink - 1.0, splat(0.0), splat(NESTED_FITS - 1.0))
        _mixed(fits, position, local)
        move(x0, y0, ts, hs / hc, local)
        mean = _values(local, a, b, d, moments, values)
        amplitudes(values, rows, number, own, fields)
        confined = 1.6 * most(a, b) + absolute(x0) + absolute(y0) > load(single, _SMALLEST)
        for i in range(4 * NODES):
            store(limit, i, splat(1e300))
        if some(confined & alive):
            stretch = load(single, _STRETCH)
            limits(edge, rays, stretch, x0, y0, tc, ts, a, b, confined, limit)
        gain, shift, total, push, free, widest, contour, slide = displace(
            fields, limit, X, system, pose[_STEP * LANES :]
        )
        punch = load(fields, 9 * LANES + 1) * power
        edge_of_one = load(fields, 9 * LANES)
        scale = math.pi * power * edge_of_one
        force = -punch * mean
        near = (widest <= LARGEST_DISPLACEMENT) & (total - free <= LARGEST_CONFINED * total)
        small = near & (absolute(scale * gain) <= LARGEST_SECOND_ORDER * force)
        solve(system, pose[_STEP * LANES :])
        still = _advance(pose, along, across, a, b, tc, ts)
        known = first >= 0.0
        enough = where(known, splat(1.0 * _LATER_STEPS), 1.0 * steps) <= rounds
        stop = alive & ((still < _SMALL_STEP) | (known & small) | enough)
        for i in range(5):
            store(pose, _USED + i, where(stop, load(pose, _USED + i), load(pose, i)))
        if not some(stop):
            continue
        second = second_order(X, rows, number, own, fields)
        gain += push / total * second
        disk, share = math.pi * a * b, scale * gain / force
        store(state, 0, force + scale * gain)
        store(state, 1, punch + scale * edge_of_one * (shift + second))
        store(state, 2, scale * edge_of_one * free)
        store(state, 3, disk)
        store(state, 4, disk * contour)
        # change of the area with a uniform displacement of the free part
        store(state, 5, 2.0 * disk * slide)
        store(state, 6, share)
        store(state, 7, x0)
        store(state, 8, y0)
        trusted = near & (absolute(share) <= LARGEST_SECOND_ORDER) & (force > 0.0) & stop
        _keep(shape, trusted, a, b, x0, y0, load(pose, _USED + 2), X)
        first = where(trusted & (first < 0.0), level, first)
        store(single, _FIRST, first)
        store(single, _LAST, where(trusted, level, load(single, _LAST)))
        early = (first < 0.0) & (level <= 1.0 * (size // 2))
        going = stop & (trusted | early) & (level < size - 1.0)
        _predict(pose, stop, going, level, growths)
        store(single, _LEVEL, where(going, level + 1.0, level))
        store(single, _ROUND, where(stop, splat(0.0), rounds))
        store(recorded, 0, where(stop, splat(1.0), 0.0))
        store(recorded, 1, where(stop & ~going, splat(1.0), 0.0))
        store(number, 0, level)
        for lane in range(LANES):
            if recorded[lane] == 0.0:
                continue
            k, at = who[lane], int(number[lane]) * STATES
            for i in range(STATES):
                states[k, at + i] = state[i * LANES + lane]
            if recorded[LANES + lane] == 0.0:
                continue
            for i in range(SHAPE):
                shapes[k, i] = shape[i * LANES + lane]
            ends[k, 0] = single[_FIRST * LANES + lane]
            ends[k, 1] = single[_LAST * LANES + lane]
            if following < n:
                who[lane] = following
                _enter(lane, following, coefs, frames, scales, rays, pose, present)
                following = _usable_from(following + 1, scales)
            else:
                single[_ALIVE * LANES + lane] = 0.0


@inner()
def _usable_from(k, scales):
    """First profile from k on that has a fit, or the number of profiles if there is none."""
    while k < len(scales) and scales[k, LANES - 1] == 0.0:
        k += 1
    return k


@inner(fastmath=QUOTIENTS)
def _advance(pose, along, across, a, b, tc, ts):
    """Take the bounded Newton step from the evaluated pose of semi-axes a, b; returns its size."""
    for i in range(5):
        store(pose, _STEP + i, between(load(pose, _STEP + i), splat(-0.4), splat(0.4)))
    arm = 0.5 * (a / b - b / a)
    twist = between(load(pose, _STEP + 2) / arm, splat(-0.3), splat(0.3))
    twist = where(absolute(arm) >= 0.15, twist, 0.0)
    along += load(pose, _STEP)
    across += load(pose, _STEP + 1)
    still = absolute(along - load(pose, _USED)) + absolute(across - load(pose, _USED + 1))
    still += absolute(twist) + absolute(load(pose, _STEP + 3)) + absolute(load(pose, _STEP + 4))
    sx, sy = load(pose, _STEP + 3) * a, load(pose, _STEP + 4) * b
    store(pose, 0, along)
    store(pose, 1, across)
    store(pose, 2, load(pose, _USED + 2) + twist)
    store(pose, 3, load(pose, _USED + 3) + tc * sx - ts * sy)
    store(pose, 4, load(pose, _USED + 4) + ts * sx + tc * sy)
    return still


@inner(fastmath=QUOTIENTS)
def _predict(pose, stop, going, level, growths):
    """Slopes of the poses over ln d, and the poses at the next levels, extrapolated along them."""
    growth = entries(growths, level)
    later = stop & (level > 0.0)
    following = entries(growths, where(going, level + 1.0, level))
    for i in range(5):
        present, before = load(pose, i), load(pose, _BEFORE + i)
        slope = where(later, (present - before) / growth, load(pose, _SLOPE + i))
        store(pose, _SLOPE + i, slope)
        store(pose, _BEFORE + i, where(stop, present, before))
        used = load(pose, _USED + i)
        store(pose, _USED + i, where(going, present + slope * following, used))


@inner(fastmath=QUOTIENTS)
def _keep(shape, mask, a, b, x0, y0, turn, X):
    """Write the contours into `shape` where the mask holds."""
    for i, value in enumerate((a, b, x0, y0, turn)):
        store(shape, i, where(mask, value, load(shape, i)))
    for i in range(4 * NODES):
        store(shape, 5 + i, where(mask, load(X, i), load(shape, 5 + i)))
