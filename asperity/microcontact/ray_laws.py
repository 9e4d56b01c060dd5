"""Laws of all peaks at once by sums over their sampled rays.

"paper" (Popov, Li & Willert 2023) and "harmonic" are expansions about a circle; "ritz" carries free
rays on inside the basins by Newton steps.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.errors import Flag
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.transforms import count_below, gauss_jacobi, lagrange, moment_weights
from surfaces.arrays import Array, Index, Mask
from surfaces.numerics import parallel

from .law_table import INTERVALS, LawTable

if TYPE_CHECKING:
    from surfaces.peaks.profiles import Profiles

__all__ = ["bounded", "expected_error", "ritz_forces", "tabulate_expansion", "tabulate_ritz"]


_HARMONICS = 5
"""Harmonics with an operator of their own; the rest is treated as the next one."""

_OVERSHOOT = 1.15
"""Largest radius of the tables over the radius of the basin's area."""

_SMALLEST_RADIUS, _GRADING = 0.02, 1.3
"""Smallest radius over the largest, and exponent of the spacing of the radii."""

_LIMIT = 0.5
"""Largest second-order part over the first-order force; least area, and least stiffness of one
contact, over those of the circle."""

_FIRST, _QUADRATIC, _CUBIC, _OPERATORS = 1.4, 11.0, 1.0, 1.0
"""Factors of x, x^2, x^(3/2) and of the difference between both second orders."""

_BLOCK = 512
"""Profiles tabulated at a time: their arrays stay in the cache."""

_TABLE_ROUNDS, _COMPARISON_ROUNDS = 8, 4
"""Times that a level of free rays is iterated at most: for a table, and for a comparison."""


def tabulate_expansion(
    profiles: Profiles,
    material: HalfSpace,
    *,
    law: str,
    nodes: int = 16,
    radii: int = 14,
    points: int = 5,
) -> LawTable:
    """Law table of the profiles by "paper" (Popov et al., equations 22-25, 49, 50) or "harmonic"
    (harmonic by harmonic, with the second-order force and area); see `laws.tabulate`.

    Notes
    -----
    The table of a contact ends (its reach) where its contact area equals the area of its basin,
    ``1/2 sum weight edge^2``; or at 1.15 times the radius of that area, if the contact stays
    smaller; or before the mean profile turns over (D' <= 0). The expansion is evaluated at `radii`
    radii by a radial rule of `points` points.

    All quantities are computed on a grid of radii a, where everything is explicit, and
    interpolated to the approaches in the normalized forms F/u^(3+m), A/u^2, u = sqrt(d). Beyond
    the end of a ray f goes on with its last slope and the curvature 2q, so that the mean profile
    keeps rising; the flag `BEYOND_RADIUS` says where that is used. Where the expansion leaves its
    range the table is bounded (F2 <= F/2, the area between half and twice that of the circle) and
    flagged `CONTOUR_DOUBTFUL`. A profile that is marked as unresolved is used as it is given.
    """
    from ._ray_kernels import QUANTITIES, expand_profiles

    m = material.m
    fractions = _OVERSHOOT * np.linspace(_SMALLEST_RADIUS, 1.0, radii) ** _GRADING
    top = np.sqrt(0.5 * np.sum(profiles.weight * profiles.edge**2, axis=1) / np.pi)
    t, weights = gauss_jacobi(m, points)
    usable = np.all(np.isfinite(profiles.q), axis=(1, 2)) & np.all(profiles.edge > 0, axis=1)
    sampled = (profiles.phi, profiles.weight, profiles.edge, profiles.q)
    rays = (*map(np.ascontiguousarray, sampled), usable, top)
    harmonics = m + (1 - m) * np.arange(_HARMONICS + 2.0)
    inputs = (rays, fractions, t, _radial(t, weights), harmonics, m)
    table = LawTable.empty(top.size, nodes, 3 + m)

    def part(start: int, stop: int) -> None:
        rows = start + np.flatnonzero(usable[start:stop])
        found = np.zeros((stop - start, radii, QUANTITIES))
        expand_profiles(start, stop, *inputs, found)
        if rows.size:
            _tabulate(found[rows - start], top[rows, None] * fractions, material, law, table, rows)

    parallel.run(part, parallel.blocks(top.size, 64, _BLOCK))
    return table


def _radial(t: Array, weights: Array) -> Array:
    """Radial weights of the operators n = 0 ... N + 1, of G~ and of a D'."""
    powers = [*range(1, _HARMONICS + 3), 1, -1]
    return np.stack([weights * t**power for power in powers])


def _tabulate(
    found: Array, a: Array, material: HalfSpace, law: str, table: LawTable, rows: Index
) -> None:
    """Fill the `rows` of a table from the quantities over the radii `a` [m], (n, radii)."""
    m, modulus, p = material.m, material.modulus, 3 + material.m
    rising = np.logical_and.accumulate((found[..., 0] > 0) & (found[..., 1] > 0), axis=1)
    good = np.count_nonzero(rising, axis=1)
    approach = np.where(rising, found[..., 0], 1.0)
    slope = np.where(rising, found[..., 1], 1.0) / a
    first = 2 * modulus * a ** (1 + m) * (approach / (1 + m) - found[..., 2])
    second = modulus * a**m * found[..., 4] / slope
    area, odd = _area(found, a, slope, second, material, law)
    low, high = (6, 7) if law == "paper" else (8, 9)
    flags = np.zeros(a.shape, dtype=np.uint8)
    largest = np.maximum(-found[..., low], found[..., high])
    flags[largest > 0.5 * slope * a] |= np.uint8(Flag.CONTOUR_DOUBTFUL)
    flags[found[..., high] >= slope * a] |= np.uint8(Flag.CONTOUR_NEGATIVE)
    flags[found[..., 10] > 0] |= np.uint8(Flag.BEYOND_RADIUS)
    force = first + np.minimum(second, _LIMIT * first) if law == "harmonic" else first
    odd |= (law == "harmonic") & (second > _LIMIT * first)
    flags[odd] |= np.uint8(Flag.CONTOUR_DOUBTFUL)
    spread = expected_error(first, second, modulus * a**m * found[..., 3] / slope, law)
    ratios = np.stack([force / approach ** (p / 2), area / approach])
    k = np.flatnonzero(good >= 4)
    basin = np.pi * (a[k, -1] / _OVERSHOOT) ** 2
    _resample(approach[k], ratios[:, k], spread[k], flags[k], good[k], basin, table, rows[k])


def _resample(
    approach: Array,
    ratios: Array,
    spread: Array,
    flags: NDArray[np.uint8],
    good: Index,
    basin: Array,
    table: LawTable,
    rows: Index,
) -> None:
    """Fill the `rows` of a table from values over rising approaches [m], (n, radii).

    `ratios` holds force/u^p and area/u^2 with u = sqrt(approach); between the radii they are cubic
    through the four nearest. The table of a contact ends where the area reaches `basin`, else at
    its last `good` value.
    """
    p, nodes, every = table.exponent, table.nodes, np.arange(len(rows))
    inside = np.arange(approach.shape[1]) < good[:, None]
    area = ratios[1] * approach
    full = inside & (area >= basin[:, None])
    filled = full.any(axis=1)
    last = np.where(filled, full.argmax(axis=1), good - 1)
    (depth, before), (most, less) = (
        (values[every, last], np.where(last > 0, values[every, last - 1], 0.0))
        for values in (approach, area)
    )
    share = np.divide(basin - less, most - less, out=np.ones(len(rows)), where=filled)
    reach = before + share * (depth - before)
    u = np.sqrt(approach)
    x = np.sqrt(reach)[:, None] * (np.arange(1, nodes + 1) / nodes)
    risen = np.maximum.accumulate(np.where(inside, u, np.inf), axis=1)
    below = count_below(risen, x)
    base = np.clip(below - 2, 0, good[:, None] - 4)
    four = every[:, None, None], base[..., None] + np.arange(4)
    level, rise = lagrange(u[four], x)
    s, spot = (np.sum(level * values[four], axis=2) for values in ratios)
    ds = np.sum(rise * ratios[0][four], axis=2)
    force = np.maximum.accumulate(np.maximum(x**p * s, 0.0), axis=1)
    stiffness = np.maximum(0.5 * x ** (p - 2) * (p * s + x * ds), 0.5 * force / x**2)
    spot *= x**2
    spot = np.where(filled[:, None], np.minimum(spot, basin[:, None]), spot)
    spot = np.maximum.accumulate(np.maximum(spot, 0.0), axis=1)
    spot[filled, -1] = basin[filled]
    near = every[:, None], np.minimum(below, good[:, None] - 1)
    marks = flags[near]
    marks[filled, -1] |= np.uint8(Flag.FILLED)
    table.reach[rows] = reach
    names = "force", "stiffness", "area", "flags", "spread"
    for name, values in zip(names, (force, stiffness, spot, marks, spread[near]), strict=True):
        getattr(table, name)[rows, 1:] = values


def _area(
    found: Array, a: Array, slope: Array, second: Array, material: HalfSpace, law: str
) -> tuple[Array, Mask]:
    """Contact area over the radii, bounded and made to rise, and where that changed it."""
    m = material.m
    if law == "paper":
        area = np.pi * (a * a + found[..., 3] / slope**2)
    else:
        change = _derivative(second / a ** (3 + m), a, 3 + m)
        shift = change / (2 * material.modulus * a**m * slope) - found[..., 5] / (2 * a * slope**2)
        area = np.pi * (a * a + 2 * a * shift + found[..., 4] / slope**2)
    rising = np.maximum.accumulate(bounded(area, np.pi * a * a), axis=1)
    return rising, rising != area


def bounded(second: Array, first: Array) -> Array:
    """Second-order areas or stiffnesses, kept between half and twice the `first` ones, those of
    the circle; beyond, the expansion has no meaning."""
    return np.clip(second, (1 - _LIMIT) * first, first / (1 - _LIMIT))


def _derivative(ratio: Array, a: Array, p: float) -> Array:
    """Derivative over a of ``ratio a^p`` on the grid of radii, which is common up to a factor."""
    change = np.gradient(ratio, a[0] / a[0, -1], axis=1, edge_order=2) / a[:, -1:]
    return np.asarray(a ** (p - 1) * (p * ratio + a * change))


def expected_error(first: Array, resolved: Array, published: Array, law: str) -> Array:
    """Relative error of the force to be expected of the law "paper", which leaves out the
    second-order force F2, or "harmonic", which leaves out what follows it.

    From the first-order force [N] and F2 [N] with the operator of each harmonic, `resolved`, and
    with that of n = 2, `published`.

    Notes
    -----
    With x = F2/F: 1.4 x + 11 x^2 for "paper", x^(3/2) + 11 x^2 + |difference of the two F2| / F
    for "harmonic". The forms are those of the next orders; the factors cover 95 % of the
    boundary-element errors of polygonal, rounded, irregular and elliptic bodies and of summits of
    rough maps, and are judged on others (`docs/development/laws.md`).
    """
    total = first + resolved
    safe = np.where(total > 0, total, 1.0)
    x = np.where(total > 0, resolved / safe, 0.0)
    if law == "paper":
        return np.asarray(_FIRST * x + _QUADRATIC * x * x)
    difference = np.where(total > 0, np.abs(resolved - published) / safe, 0.0)
    return np.asarray(_CUBIC * x**1.5 + _QUADRATIC * x * x + _OPERATORS * difference)


def tabulate_ritz(profiles: Profiles, material: HalfSpace) -> LawTable:
    """Law table of the profiles by free rays inside their basins; see `laws.tabulate`."""
    levels = np.arange(1, INTERVALS + 1) / INTERVALS
    reach, length, height, out = _march(profiles, material.m, levels, _TABLE_ROUNDS)
    unit = material.modulus * length ** (1 + material.m)
    table = LawTable.empty(length.size, INTERVALS, 3 + material.m)
    table.reach[:] = reach
    columns = (table.force, unit * height), (table.stiffness, unit), (table.area, length**2)
    for k, (column, scale) in enumerate(columns):
        column[:, 1:] = np.maximum.accumulate(out[..., k], axis=1) * scale[:, None]
    table.flags[:, 1:][out[..., 3] > 0] |= np.uint8(Flag.BEYOND_RADIUS)
    table.flags[:, 1:][out[..., 3] > 0.999] |= np.uint8(Flag.FILLED)
    return table


def ritz_forces(profiles: Profiles, material: HalfSpace, levels: Array) -> Array:
    """Forces [N] of "ritz" at the approaches reach * levels**2, levels rising, shape (n, levels),
    within a few per cent."""
    reach, length, height, out = _march(profiles, material.m, levels, _COMPARISON_ROUNDS)
    unit = np.where(reach > 0, material.modulus * length ** (1 + material.m) * height, 0.0)
    return np.asarray(out[..., 0] * unit[:, None])


def _march(
    profiles: Profiles, m: float, levels: Array, rounds: int
) -> tuple[Array, Array, Array, Array]:
    """Reach [m], units of length and height [m], and force, stiffness, area, filled share."""
    from ._ray_kernels import march_rays

    length = profiles.edge.max(axis=1, initial=0.0)
    top = (profiles.q[:, :, -1] * profiles.edge**2).max(axis=1, initial=0.0)
    height = 2.0 / (1.0 + m) * top  # the approach at which a paraboloid of this height fills
    valid = profiles.valid & (length > 0) & (height > 0)
    length, height = np.where(valid, length, 1.0), np.where(valid, height, 1.0)
    out = np.zeros((length.size, levels.size, 4))
    inputs = (
        np.ascontiguousarray(profiles.q),
        np.ascontiguousarray(profiles.weight),
        profiles.edge / length[:, None],
        length**2 / height,
    )
    weights = np.ascontiguousarray(moment_weights(m, profiles.q.shape[2]))

    def part(begin: int, end: int) -> None:
        march_rays(begin, end, inputs, weights, levels, m, rounds, out)

    parallel.run(part, parallel.blocks(length.size, 1 + 72 // levels.size))
    return np.where(valid, height, 0.0), length, height, out
