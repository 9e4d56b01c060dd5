"""Law "ellipse" of all peaks at once, confined to their basins.

The elliptic flat punch is exact for every grading, so the Barber functional on ellipses is a
rigorous lower bound of the force. About its best ellipse the boundary moves locally where the
edge amplitude of the pressure is small, which gives the force to third order and the contour to
first; the contour is stopped at the basin edge.
"""

from __future__ import annotations

import dataclasses
import itertools
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.material import HalfSpace
from asperity.transforms import gauss_jacobi
from surfaces import _threads

from .ellipse_tables import LOG_RATIO, EllipseTables, ellipse_tables
from .fit import SummitFits, fit_summits
from .flags import Flag
from .table import LawTable

if TYPE_CHECKING:
    from surfaces import Profiles

__all__ = ["second_order_area", "tabulate"]

Array = NDArray[np.float64]

_ORDER = 0
"""Harmonic whose edge operator carries a contour on along its ray."""

LEVELS = np.exp(np.linspace(np.log(1 / 60), 0.0, 23))
"""Square roots of the approaches, relative to the reach, at which the law is computed."""

_BLOCK = 512
"""Profiles tabulated at a time: their arrays stay in the cache."""

_FIRST = 8
"""Newton steps at the smallest approach; every other one needs a single evaluation."""


def solve_states(fits: SummitFits, tables: EllipseTables, levels: Array) -> tuple[Array, Array]:
    """States and contours of all profiles at the approaches ``depth * levels**2``."""
    from ._ellipse_kernels import STATES, march

    first, last, count = LOG_RATIO
    state = np.zeros((len(fits), levels.size, STATES))
    shape = np.zeros((len(fits), levels.size, 5 + 4 * tables.nodes.size))
    inputs = (
        fits.coefs,
        fits.sizes,
        fits.edge,
        fits.stretch,
        fits.offset,
        levels,
        _FIRST,
        True,
        tables.m,
        tables.rows,
        first,
        (last - first) / (count - 1),
        tables.moments,
        tables.parity,
        tables.nodes,
        state,
        shape,
    )
    march(0, len(fits), *inputs)
    return state, shape


@lru_cache(maxsize=8)
def _slope_matrix(count: int) -> Array:
    """Matrix of the derivative per step from the nearest five of `count` equispaced values."""
    out = np.zeros((count, count))
    width = min(5, count)
    for row in range(count):
        first = min(max(row - width // 2, 0), count - width)
        x = np.arange(first, first + width) - row
        powers = np.vander(x.astype(float), width, increasing=True)
        out[row, first : first + width] = np.linalg.inv(powers)[1]
    return out


@lru_cache(maxsize=8)
def _resampling(nodes: int) -> tuple[Array, Array, Array, Array, Array]:
    """Matrices from the levels to u = j/nodes, j = 1 ... nodes.

    Value and derivative over u of the cubic Hermite through values and derivatives, and linear
    interpolation.
    """
    u = np.arange(1, nodes + 1) / nodes
    i = np.clip(np.searchsorted(LEVELS, u) - 1, 0, LEVELS.size - 2)
    h = LEVELS[i + 1] - LEVELS[i]
    x = (u - LEVELS[i]) / h
    row = np.arange(nodes)
    out = [np.zeros((nodes, LEVELS.size)) for _ in range(5)]
    for m, low, high in (
        (out[0], (1 + 2 * x) * (1 - x) ** 2, x * x * (3 - 2 * x)),
        (out[1], h * x * (1 - x) ** 2, h * x * x * (x - 1)),
        (out[2], 6 * x * (x - 1) / h, 6 * x * (1 - x) / h),
        (out[3], (1 - x) * (1 - 3 * x), x * (3 * x - 2)),
        (out[4], 1 - x, x),
    ):
        m[row, i] = low
        m[row, i + 1] = high
    return out[0], out[1], out[2], out[3], out[4]


def tabulate(
    profiles: Profiles, material: HalfSpace, *, law: str = "ellipse", nodes: int = 32
) -> LawTable:
    """Law table of a batch of profiles about their optimal ellipses.

    Parameters
    ----------
    profiles
        Batch of sampled profiles (`surfaces.fit_profiles`).
    material
        Half-space, any m.
    law
        "ellipse".
    nodes
        Intervals of the table.
    """
    tables = ellipse_tables(material.m)

    def part(start: int, stop: int) -> list[LawTable]:
        bounds = [*range(start, stop, _BLOCK), stop]
        return [
            _tabulate_rows(_rows(profiles, a, b), material, tables, nodes, law)
            for a, b in itertools.pairwise(bounds)
        ]

    if len(profiles.height) == 0:
        return _tabulate_rows(profiles, material, tables, nodes, law)
    parts = _threads.run(part, _threads.blocks(len(profiles.height), 64))
    return _joined([table for tables in parts for table in tables])


def _rows(profiles: Profiles, start: int, stop: int) -> Profiles:
    """The profiles [start, stop)."""
    cut = {
        field.name: getattr(profiles, field.name)[start:stop]
        for field in dataclasses.fields(profiles)
        if field.name != "t"
    }
    return dataclasses.replace(profiles, **cut)


def _joined(tables: list[LawTable]) -> LawTable:
    """One table of the rows of several."""
    if len(tables) == 1:
        return tables[0]
    names = ("reach", "force", "stiffness", "area", "flags", "spread", "centre")
    columns = {name: np.concatenate([getattr(one, name) for one in tables]) for name in names}
    return dataclasses.replace(tables[0], **columns)


def _tabulate_rows(
    profiles: Profiles, material: HalfSpace, tables: EllipseTables, nodes: int, law: str
) -> LawTable:
    fits = fit_summits(profiles, tables.degree)
    state, shape = solve_states(fits, tables, LEVELS)
    good = state[..., 9] > 0
    filling = follow_basins(profiles, fits, shape, good, LEVELS, tables)
    return _assemble(state, filling, good, fits, material, nodes, law)


def follow_basins(
    profiles: Profiles, fits: SummitFits, shape: Array, good: NDArray[np.bool_], levels: Array,
    tables: EllipseTables,
) -> Array:  # fmt: skip
    """Area and punch stiffness (n, levels, 2) of the contours on rays from the last good node."""
    from ._basin_kernels import fill_basins

    first, last, count = LOG_RATIO
    nq = tables.nodes.size
    column = tables.order.size * nq + nq
    turned = profiles.phi - profiles.angle[:, None]
    out = np.zeros((len(fits), levels.size, 4))
    inputs = (
        np.ascontiguousarray(profiles.q),
        moment_weights(tables.m, profiles.t.size, _ORDER),
        np.ascontiguousarray(profiles.weight),
        np.stack([np.cos(turned), np.sin(turned)], axis=-1),
        fits.edge,
        fits.length,
        fits.height,
        shape,
        _ends(good)[1],
        levels,
        nq,
        tables.m,
        _ORDER + 3 + tables.m,
        np.ascontiguousarray(tables.rows[:, column]),
        first,
        (last - first) / (count - 1),
        0.5 * (1 + tables.m),
        out,
    )
    fill_basins(0, len(fits), *inputs)
    return out


@lru_cache(maxsize=8)
def moment_weights(m: float, nodes: int, order: int, radii: int = 13) -> Array:
    """Weights (radii, nodes) of ``h(a) = int t**(order+3) q(a t) (1-t*t)**((m-1)/2) dt``.

    ``a`` runs over equispaced fractions of the ray from 0 to 1, ``q`` over equispaced nodes with
    local cubics between them. The edge operator of harmonic `order` of one ray is
    ``a*a * ((order + 3 + m) h + a h')`` (theory 5).
    """
    t, w = gauss_jacobi(m, 24)
    out = np.zeros((radii, nodes))
    last = nodes - 1
    for row, a in zip(out, np.linspace(0, 1, radii), strict=True):
        position = a * t * last
        i = np.clip(position.astype(int), 1, last - 2)
        u = position - i
        cubic = (
            -u * (u - 1) * (u - 2) / 6,
            (u + 1) * (u - 1) * (u - 2) / 2,
            -(u + 1) * u * (u - 2) / 2,
            (u + 1) * u * (u - 1) / 6,
        )
        for k, share in enumerate(cubic):
            np.add.at(row, i + k - 1, share * w * t ** (order + 3))
    return out


def _assemble(
    state: Array, filling: Array, good: NDArray[np.bool_], fits: SummitFits,
    material: HalfSpace, nodes: int, law: str,
) -> LawTable:  # fmt: skip
    """Law table in SI from the states in units of each profile."""
    p = 3 + material.m
    step = np.log(LEVELS[1] / LEVELS[0])
    scaled = _extend(state[..., 0] / LEVELS**p, good)
    slope = scaled @ _slope_matrix(LEVELS.size).T / step
    raw = LEVELS ** (p - 2) * (p * scaled + slope) / 2
    spot = _extend(second_order_area(state, raw) / LEVELS**2, good) * LEVELS**2
    force, stiffness, area = _continue(scaled * LEVELS**p, raw, spot, filling, good, fits.basin)
    scaled = force / LEVELS**p
    slope = 2 * stiffness * LEVELS ** (1 - p) - p * scaled / LEVELS
    value, value_slope, change, change_slope, linear = _resampling(nodes)
    u = np.arange(1, nodes + 1) / nodes
    s = scaled @ value.T + slope @ value_slope.T
    g = scaled @ change.T + slope @ change_slope.T
    force, stiffness = _convex(s * u**p, u ** (p - 2) * (p * s + u * g) / 2, u * u)
    area = np.maximum.accumulate((area / LEVELS**2) @ linear.T * u**2, axis=1)
    unit = material.modulus * fits.length ** (1 + material.m)
    trusted = good.astype(float) @ linear.T > 0.999
    error = np.where(good, np.abs(state[..., 7]), 0.05) @ linear.T
    flags = np.zeros((len(fits), nodes + 1), dtype=np.uint8)
    flags[:, 1:][~trusted] |= np.uint8(Flag.BEYOND_RADIUS)
    flags[:, 1:][area > 0.999 * fits.basin[:, None]] |= np.uint8(Flag.FILLED)

    def full(values: Array, scale: Array) -> Array:
        out = np.zeros((len(fits), nodes + 1))
        out[:, 1:] = values * scale[:, None]
        return out

    return LawTable(
        reach=np.where(fits.valid, fits.height, 0.0),
        force=full(force, unit * fits.height),
        stiffness=full(stiffness, unit),
        area=full(area, fits.length**2),
        flags=flags,
        spread=full(error, np.ones(len(fits))),
        exponent=p,
        law=law,
        centre=_centre(filling[..., 2:], fits, linear),
    )


def _convex(force: Array, stiffness: Array, d: Array) -> tuple[Array, Array]:
    """Force with rising secants over the approach d, and stiffness between them.

    Where the secants fall they are replaced by the mean of their rising envelopes.
    """
    steps = np.diff(d, prepend=0.0)
    secant = np.diff(force, axis=1, prepend=0.0) / steps
    upper = np.maximum.accumulate(secant, axis=1)
    lower = np.minimum.accumulate(secant[:, ::-1], axis=1)[:, ::-1]
    secant = 0.5 * (upper + lower)
    stiffness = np.maximum(stiffness, secant)
    stiffness[:, :-1] = np.minimum(stiffness[:, :-1], secant[:, 1:])
    return np.cumsum(secant * steps, axis=1), stiffness


def _centre(local: Array, fits: SummitFits, linear: Array) -> Array:
    """Centres (n, nodes + 1, 2) in the axes of the map, from those at the levels."""
    along, across = (local[..., k] @ linear.T * fits.length[:, None] for k in range(2))
    c, s = np.cos(fits.angle)[:, None], np.sin(fits.angle)[:, None]
    out = np.zeros((len(fits), along.shape[1] + 1, 2))
    out[:, 1:, 0] = c * along - s * across
    out[:, 1:, 1] = s * along + c * across
    return out


def _ends(good: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First and last trusted level of each profile; both 0 where there is none."""
    first = np.argmax(good, axis=1)
    last = good.shape[1] - 1 - np.argmax(good[:, ::-1], axis=1)
    return first, np.where(good.any(axis=1), last, 0)


def _extend(values: Array, good: NDArray[np.bool_]) -> Array:
    """Values continued from the trusted levels: constant below, by the last difference above."""
    first, last = _ends(good)
    rows = np.arange(len(values))
    end = values[rows, last]
    step = end - values[rows, np.maximum(last - 1, first)]
    place = np.arange(values.shape[1])
    beyond = place - last[:, None]
    above = np.where(beyond > 0, end[:, None] + step[:, None] * beyond, values)
    return np.where(place < first[:, None], values[rows, first][:, None], above)


def _continue(
    force: Array, stiffness: Array, area: Array, filling: Array, good: NDArray[np.bool_],
    basin: Array,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Beyond the last trusted node: planforms on rays, their stiffness, and its integral.

    The ratios of stiffness and area of the two descriptions at the last trusted node fade as the
    basin fills.
    """
    last = _ends(good)[1]
    rows = np.arange(len(force))
    beyond = np.arange(LEVELS.size) > last[:, None]
    start = filling[rows, last]
    grown = np.where(beyond, filling[..., 0], start[:, :1])
    room = np.maximum(basin - start[:, 0], 1e-9 * basin)
    fade = np.clip((basin[:, None] - grown) / room[:, None], 0.0, 1.0)
    stiff = np.where(beyond, filling[..., 1], start[:, 1:2])
    stiff = stiff * _ratio(stiffness[rows, last], start[:, 1])[:, None] ** fade
    spot = grown * _ratio(area[rows, last], start[:, 0])[:, None] ** fade
    stiffness = np.maximum.accumulate(np.where(beyond, stiff, stiffness), axis=1)
    area = np.maximum.accumulate(np.where(beyond, spot, area), axis=1)
    steps = np.zeros_like(force)
    width = np.diff(LEVELS)
    low, high = LEVELS[:-1], LEVELS[1:]
    # stiffness linear in the level u over d = u*u
    steps[:, 1:] = (
        width * (stiffness[:, :-1] * (2 * low + high) + stiffness[:, 1:] * (low + 2 * high)) / 3
    )
    base = np.where(beyond, force[rows, last][:, None], force)
    return base + np.cumsum(np.where(beyond, steps, 0.0), axis=1), stiffness, area


def _ratio(inner: Array, outer: Array) -> Array:
    """Ratio of the two descriptions where they meet, kept to what a mended summit can need."""
    usable = (inner > 0) & (outer > 0)
    return np.clip(np.divide(inner, outer, out=np.ones(len(inner)), where=usable), 0.5, 2.0)


def second_order_area(state: Array, stiffness: Array) -> Array:
    """Contact area whose contour has the stiffness dF/dd to second order.

    The unknown second-order displacement is taken uniform along the contour; the result stays
    between the ellipse and the first-order contour.
    """
    weight = np.maximum(state[..., 2], 1e-12)
    uniform = np.clip((stiffness - state[..., 1]) / weight, -0.3, 0.3)
    area = state[..., 4] + uniform * state[..., 5]
    low = np.minimum(state[..., 3], state[..., 4])
    return np.clip(area, low, np.maximum(state[..., 3], state[..., 4]))
