"""Law "ellipse": expansion about the optimal ellipse, confined to the basin.

The elliptic flat punch is exact for every grading, so the Barber functional on ellipses is a
rigorous lower bound of the force. About its best ellipse the boundary moves locally where the
edge amplitude of the pressure is small, which gives the force to third order and the contour to
first; the contour is stopped at the basin edge.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.material import HalfSpace

from .ellipse_tables import LOG_RATIO, EllipseTables, ellipse_tables
from .fit import SummitFits, fit_summits
from .flags import Flag
from .table import LawTable

if TYPE_CHECKING:
    from surfaces import Profiles

__all__ = ["tabulate"]

Array = NDArray[np.float64]

_FIRST = 8
"""Newton steps at the smallest approach; every other one needs a single evaluation."""


def solve_states(fits: SummitFits, tables: EllipseTables, levels: Array) -> tuple[Array, Array]:
    """States and contours of all profiles at the approaches ``depth * levels**2``."""
    from ._ellipse_kernels import march

    first, last, count = LOG_RATIO
    return march(
        fits.coefs,
        fits.sizes,
        fits.edge,
        fits.stretch,
        fits.offset,
        np.ones(len(fits)),
        levels,
        _FIRST,
        tables.m,
        tables.degree,
        tables.rows,
        first,
        (last - first) / (count - 1),
        tables.moments,
        tables.parity,
        tables.order,
        tables.nodes,
    )


@lru_cache(maxsize=8)
def _slope_matrix(count: int) -> Array:
    """Matrix of the derivative at the nodes 1/count ... 1 from the nearest five of them."""
    out = np.zeros((count, count))
    width = min(5, count)
    for row in range(count):
        first = min(max(row - width // 2, 0), count - width)
        x = np.arange(first, first + width) - row
        powers = np.vander(x.astype(float), width, increasing=True)
        out[row, first : first + width] = np.linalg.inv(powers)[1] * count
    return out


def tabulate(
    profiles: Profiles, material: HalfSpace, *, law: str = "ellipse", nodes: int = 16
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
    fits = fit_summits(profiles, tables.degree)
    levels = np.arange(1, nodes + 1) / nodes
    state, _ = solve_states(fits, tables, levels)
    return _assemble(state, fits, material, levels, law)


def _assemble(
    state: Array, fits: SummitFits, material: HalfSpace, levels: Array, law: str
) -> LawTable:
    """Law table in SI from the states in units of each profile."""
    p = 3 + material.m
    n, count = state.shape[:2]
    good = np.logical_and.accumulate(_trusted(state), axis=1)
    scaled = _extend(state[..., 0] / levels**p, good)
    slope = levels ** (p - 1) * (p * scaled + levels * (scaled @ _slope_matrix(count).T))
    raw = slope / (2 * levels)
    area = second_order_area(state, raw)
    force, stiffness, area = _continue(
        state[..., 0], raw, area, good, fits.basin, levels, material.m
    )
    unit = material.modulus * fits.length ** (1 + material.m)
    flags = _flags(state, good, area, fits.basin)

    def full(values: Array, scale: Array) -> Array:
        out = np.zeros((n, count + 1))
        out[:, 1:] = values * scale[:, None]
        return out

    return LawTable(
        reach=np.where(fits.valid, fits.height, 0.0),
        force=full(force, unit * fits.height),
        stiffness=full(stiffness, unit),
        area=full(area, fits.length**2),
        flags=flags,
        spread=full(np.where(good, np.abs(state[..., 7]), 0.1), np.ones(n)),
        exponent=p,
        law=law,
    )


def _extend(values: Array, good: NDArray[np.bool_]) -> Array:
    """Values beyond the last trusted node, continued with the last difference."""
    last = np.maximum(np.count_nonzero(good, axis=1) - 1, 0)
    rows = np.arange(len(values))
    end = values[rows, last]
    step = end - values[rows, np.maximum(last - 1, 0)]
    beyond = np.arange(values.shape[1]) - last[:, None]
    return np.where(beyond > 0, end[:, None] + step[:, None] * beyond, values)


def _trusted(state: Array) -> NDArray[np.bool_]:
    """Nodes at which the expansion holds: small displacements, small F2, inside the basin."""
    return (
        np.isfinite(state).all(axis=2)
        & (state[..., 0] > 0)
        & (state[..., 6] < 0.5)
        & (np.abs(state[..., 7]) < 0.05)
        & (state[..., 8] <= 0)
    )


def _continue(
    force: Array, stiffness: Array, area: Array, good: NDArray[np.bool_], basin: Array,
    levels: Array, m: float,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Beyond the last trusted node the area grows like d until it fills the basin.

    The stiffness grows like area**((1+m)/2), the law of similar punches, and the force is its
    integral.
    """
    d = levels**2
    last = np.maximum(np.count_nonzero(good, axis=1) - 1, 0)
    rows = np.arange(len(force))
    start = d[last]
    area0 = np.clip(area[rows, last], 1e-9 * basin, basin)
    grown = np.minimum(area0[:, None] * d / start[:, None], basin[:, None])
    stiff = stiffness[rows, last][:, None] * (grown / area0[:, None]) ** ((1 + m) / 2)
    beyond = np.arange(levels.size) > last[:, None]
    area = np.where(beyond, grown, np.minimum(area, basin[:, None]))
    stiffness = np.where(beyond, stiff, stiffness)
    stiffness = np.maximum.accumulate(stiffness, axis=1)
    steps = np.zeros_like(force)
    steps[:, 1:] = 0.5 * (stiffness[:, 1:] + stiffness[:, :-1]) * np.diff(d)
    steps = np.where(beyond, steps, 0.0)
    base = np.where(beyond, force[rows, last][:, None], force)
    return base + np.cumsum(steps, axis=1), stiffness, np.maximum.accumulate(area, axis=1)


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


def _flags(state: Array, good: NDArray[np.bool_], area: Array, basin: Array) -> NDArray[np.uint8]:
    flags = np.zeros((state.shape[0], state.shape[1] + 1), dtype=np.uint8)
    inner = flags[:, 1:]
    inner[~good] |= np.uint8(Flag.CONTOUR_DOUBTFUL)
    inner[state[..., 8] > 0] |= np.uint8(Flag.BEYOND_RADIUS)
    inner[area > 0.999 * basin[:, None]] |= np.uint8(Flag.FILLED)
    return flags
