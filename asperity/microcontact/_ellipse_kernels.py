"""Numba kernels of the contact law about the optimal ellipse, for eight profiles at once.

Units inside: one length and one height per profile, modulus 1. Arrays are groups of eight numbers,
one per profile (`_lanes`).
"""

from __future__ import annotations

import math

from numba import njit

from ._contour_kernels import FIELDS, NODES, amplitudes, displace, limits, second_order
from ._lanes import (
    FAST,
    LANES,
    absolute,
    add,
    between,
    exponential,
    groups,
    least,
    load,
    logarithm,
    most,
    sine_cosine,
    some,
    splat,
    store,
    where,
    whole,
)
from ._polynomial_kernels import TERMS, move, solve
from .ellipse_tables import DEGREE

WIDEST, SHARE, CONFINED = 0.5, 0.05, 0.5
"""Limits of trust: displacement of the contour, share of F2, confined share of the contour."""

_AGAIN = 2
"""Newton steps at most at a level after the first trusted one: a single one where it is trusted."""

_STILL = 1e-3
"""Newton step, in logarithms and angles, that ends the search at a level."""

STATES = 9
"""Numbers kept per level: force, stiffness of the first-order contour and its change with a
uniform displacement, areas of the ellipse and of the contour and the change of the latter,
share of F2, and the centre."""

SHAPE = 5 + 4 * NODES
"""Numbers of a contour: semi-axes, centre, turn and displacements at the nodes."""

_SLOPE, _BEFORE, _USED, _STEP = 5, 10, 15, 20
"""Groups of the poses: the present one, its slopes, that at the level before, the one that the
functional was evaluated at, and the Newton step."""


@njit(cache=True, nogil=True)
def march_space():
    """Working groups of `march`: poses, local polynomial, its values, fields of the contour,
    displacements and their limits, and a system of five."""
    return (
        groups(25),
        groups(TERMS),
        groups(2 * TERMS),
        groups(LANES * FIELDS),
        groups(LANES * FIELDS),
        groups(4 * NODES),
        groups(4 * NODES),
        groups(25),
        groups(1),
    )


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _mixed(fit, fits, position, out):
    """Polynomials between two nested ones: `position` 0 is the largest, fits - 1 the smallest."""
    for r in range(TERMS):
        store(out, r, splat(0.0))
    for s in range(fits):
        weight = most(1.0 - absolute(position - s), splat(0.0))
        for r in range(3, TERMS):
            store(out, r, load(out, r) + weight * load(fit, s * TERMS + r))


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _values(coefs, a, b, depth, moments, out):
    """Monomials at the ends of the axes: f minus the approach, and each times its degree.

    Returns the mean of f minus the approach under the flat punch.
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


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _start(fit, depth, m, pose):
    """Ellipses of the paraboloids in the smallest fits."""
    along, across = most(load(fit, 3), splat(1e-300)), most(load(fit, 5), splat(1e-30))
    ratio = most(0.63 * logarithm(along / across), splat(-math.log(40.0)))
    across = logarithm(across)
    mean = across + 0.5 / 0.63 * ratio
    size = 0.5 * (math.log(0.5 * depth * (1 + m)) - mean)
    store(pose, 0, size - 0.5 * ratio)
    store(pose, 1, size + 0.5 * ratio)
    for i in range(2, 5):
        store(pose, i, splat(0.0))


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def march(
    fit, shrink, fits, edge, rays, stretch, levels, most_steps, m, rows, grid, moments, state,
    shape, space,
):  # fmt: skip
    """Follow eight profiles through the approaches levels**2.

    Fills the groups of state (levels, STATES), and of `shape` (SHAPE) with the contours at the
    last trusted levels. `most_steps` Newton steps at most before the first trusted level; a profile
    ends at the first level after it that is not trusted. Returns the first and the last trusted
    levels, -1 for both where there are none.

    The functional is evaluated on the nearest ellipse whose axis ratio is in the tables: the error
    is of third order in half of their spacing.
    """
    pose, local, values, own, fields, X, limit, system, number = space
    start, step, count = grid
    smallest = splat(1e300)
    for p in range(rays):
        smallest = least(smallest, load(edge, p))
    _start(fit[(fits - 1) * TERMS * LANES :], levels[0] ** 2, m, pose)
    for i in range(5):
        store(pose, _SLOPE + i, splat(0.5 if i < 2 else 0.0))
    first, last = splat(-1.0), splat(-1.0)
    alive = first < 0.0
    for level in range(levels.size):
        d, growth = levels[level] ** 2, 1.0
        if level > 0:
            growth = 2 * math.log(levels[level] / levels[level - 1])
            for i in range(5):
                add(pose, i, load(pose, _SLOPE + i) * growth)
        for i in range(5):
            store(pose, _USED + i, load(pose, i))
        known = first >= 0.0
        active = alive
        rounds = 0.0
        while True:
            rounds += 1.0
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
            _mixed(fit, fits, between(middle / shrink - 1.0, splat(0.0), splat(fits - 1.0)), local)
            move(x0, y0, ts, hs / hc, local)
            mean = _values(local, a, b, d, moments, values)
            amplitudes(values, rows, number, own, fields)
            confined = 1.6 * most(a, b) + absolute(x0) + absolute(y0) > smallest
            for i in range(4 * NODES):
                store(limit, i, splat(1e300))
            if some(confined & alive):
                limits(edge, rays, stretch, x0, y0, tc, ts, a, b, confined, limit)
            gain, shift, total, push, free, widest, contour, slide = displace(
                fields, limit, X, system, pose[_STEP * LANES :]
            )
            punch = load(fields, 9 * LANES + 1) * power
            edge_of_one = load(fields, 9 * LANES)
            scale = math.pi * power * edge_of_one
            force = -punch * mean
            filled = total - free
            small = (widest <= WIDEST) & (absolute(scale * gain) <= SHARE * force)
            small = small & (filled <= CONFINED * total)
            solve(system, pose[_STEP * LANES :])
            for i in range(5):
                store(pose, _STEP + i, between(load(pose, _STEP + i), splat(-0.4), splat(0.4)))
            arm = 0.5 * (a / b - b / a)
            twist = between(load(pose, _STEP + 2) / arm, splat(-0.3), splat(0.3))
            twist = where(absolute(arm) >= 0.15, twist, 0.0)
            along += load(pose, _STEP)
            across += load(pose, _STEP + 1)
            still = absolute(along - load(pose, _USED)) + absolute(across - load(pose, _USED + 1))
            still += absolute(twist) + absolute(load(pose, _STEP + 3))
            still += absolute(load(pose, _STEP + 4))
            sx, sy = load(pose, _STEP + 3) * a, load(pose, _STEP + 4) * b
            store(pose, 0, along)
            store(pose, 1, across)
            store(pose, 2, load(pose, _USED + 2) + twist)
            store(pose, 3, x0 + tc * sx - ts * sy)
            store(pose, 4, y0 + ts * sx + tc * sy)
            enough = where(known, splat(_AGAIN), most_steps) <= rounds
            active = active & ~((still < _STILL) | (known & small) | enough)
            if not some(active):
                break
            for i in range(5):
                store(pose, _USED + i, where(active, load(pose, i), load(pose, _USED + i)))
        second = second_order(X, rows, number, own, fields)
        gain += push / total * second
        disk, share = math.pi * a * b, scale * gain / force
        o = level * STATES
        store(state, o, force + scale * gain)
        store(state, o + 1, punch + scale * edge_of_one * (shift + second))
        store(state, o + 2, scale * edge_of_one * free)
        store(state, o + 3, disk)
        store(state, o + 4, disk * contour)
        store(state, o + 5, 2.0 * disk * slide)
        store(state, o + 6, share)
        store(state, o + 7, x0)
        store(state, o + 8, y0)
        trusted = (widest <= WIDEST) & (absolute(share) <= SHARE) & (filled <= CONFINED * total)
        trusted = trusted & (force > 0.0) & alive
        _keep(shape, trusted, a, b, x0, y0, load(pose, _USED + 2), X)
        for i in range(5):
            if level > 0:
                change = load(pose, i) - load(pose, _BEFORE + i)
                store(pose, _SLOPE + i, change / growth)
            store(pose, _BEFORE + i, load(pose, i))
        first = where(trusted & (first < 0.0), splat(1.0 * level), first)
        last = where(trusted, splat(1.0 * level), last)
        if level <= levels.size // 2:
            alive = alive & (trusted | (first < 0.0))
        else:
            alive = trusted
        if not some(alive):
            break
    return first, last


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _keep(shape, mask, a, b, x0, y0, turn, X):
    """Remember the contours where the mask holds."""
    store(shape, 0, where(mask, a, load(shape, 0)))
    store(shape, 1, where(mask, b, load(shape, 1)))
    store(shape, 2, where(mask, x0, load(shape, 2)))
    store(shape, 3, where(mask, y0, load(shape, 3)))
    store(shape, 4, where(mask, turn, load(shape, 4)))
    for i in range(4 * NODES):
        store(shape, 5 + i, where(mask, load(X, i), load(shape, 5 + i)))
