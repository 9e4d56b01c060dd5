"""Law "ellipse" of all peaks at once, confined to their basins.

The elliptic flat punch is exact for every grading, so the functional F = k (d - <f>) of Barber
(1974) is a lower bound of the force for every ellipse. It is largest for the best ellipse, about
which the contour is displaced by P/Q: P is the amplitude of the edge singularity of the pressure,
Q minus its derivative with the logarithm of the size (docs/development/laws.md, "ellipse"). This
gives the force to second order and the contour to first; the contour stops at the edge of the
basin. Three compiled passes take a profile from its samples to its row of the table: `fit_rows`,
`march_rows`, `tabulate_rows`.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from asperity.halfspace.material import HalfSpace
from asperity.halfspace.transforms import edge_weights
from asperity.microcontact.law_table import INTERVALS, LawTable
from surfaces.arrays import Array, Index
from surfaces.errors import InputError
from surfaces.numerics import parallel

from .ellipse_operator import DEGREE, LOG_RATIO, between, ellipse_tables, monomials, parity_of

if TYPE_CHECKING:
    from surfaces.peaks.profiles import Profiles

__all__ = ["tabulate"]


_TURN = 0.4
_BELOW, _ABOVE = 10, 6
"""The levels (square roots of approach over reach) are in geometric progression up to `_TURN`,
where most expansions have ended, and evenly spaced beyond, where basins fill; their numbers below
and above. More levels change mean force and area by 0.2 and 0.5 %."""

_ORDERS = (0, 1, 2)
"""Harmonics n of the edge operators e_n whose mean moves a contour along its ray. Round parts of a
profile follow n = 0, lobes higher n. With 0 and 1 alone the contacts of rough summits are 2 % too
large at equal force (m = 0; 3 to 6 % at m = -0.3); with 1 alone they carry 1 % too little at equal
approach."""

_FIRST_STEPS = 8
"""Most Newton steps for the best ellipse at the smallest approach; later ones need one or two."""

_BLOCK = 256
"""Profiles that a thread takes at a time, so that their arrays stay in its cache."""

_RATIO_POINTS = 1536
"""Number of axis ratios at which the functional is evaluated."""

_SHRINK = 0.66
"""Size of each nested ellipse over the next larger one."""

_RINGS = (0, 1, 2, 4, 6)
"""Radii of the samples of one fit, as powers of sqrt(`_SHRINK`) times its size."""

_SKEW = np.exp(np.linspace(np.log(0.5), np.log(16.0), 36))
"""Axis ratios of the fitted ellipse over that of the rays; each summit gets the nearest."""


LEVELS = np.concatenate(
    [
        np.exp(np.linspace(-np.log(INTERVALS), np.log(_TURN), _BELOW)),
        np.linspace(_TURN, 1.0, _ABOVE + 1)[1:],
    ]
)
"""Square roots of the approaches relative to the reach at which the law is computed."""


@lru_cache(maxsize=1)
def _stencils() -> Array:
    """Finite-difference weights [width - 1, start, place, k] of the slope over u at level
    start + place, from the `width` levels from `start` on."""
    from ._table_kernels import WIDTH

    u = LEVELS
    out = np.zeros((WIDTH, u.size, WIDTH, WIDTH))
    for width in range(1, WIDTH + 1):
        for start in range(u.size - width + 1):
            own = u[start : start + width]
            for place in range(width):
                powers = np.vander(own / own[place] - 1, width, increasing=True)
                slope = np.linalg.inv(powers)[min(1, width - 1)] / own[place]
                out[width - 1, start, place, :width] = slope if width > 1 else 0.0
    return out


def _resampling(p: float) -> tuple[Array, Array, Index, Array]:
    """Nodes j/K, their powers p, the level below each, and the weights of `resampled`."""
    u = np.arange(1, INTERVALS + 1) / INTERVALS
    i = np.clip(np.searchsorted(LEVELS, u - 1e-9) - 1, 0, LEVELS.size - 2)
    h = LEVELS[i + 1] - LEVELS[i]
    x = (u - LEVELS[i]) / h
    y = 1 - x
    weights = [
        (1 + 2 * x) * y**2, h * x * y**2, x**2 * (3 - 2 * x), -h * x**2 * y,
        -6 * x * y / h, y * (1 - 3 * x), 6 * x * y / h, x * (3 * x - 2),
        x,
    ]  # fmt: skip
    return u, u**p, i, np.stack(weights, axis=1)


def _along_rays(m: float, samples: int) -> Array:
    """Mean of the edge operators e_n, n of `_ORDERS`, each scaled to agree on a paraboloid."""
    operators = [edge_weights(m, samples, order) for order in _ORDERS]
    scale = operators[0].sum(axis=1, keepdims=True)
    return np.asarray(
        np.mean([scale / w.sum(axis=1, keepdims=True) * w for w in operators], axis=0)
    )


def _lobes(rays: int) -> Array:
    """Weights of the correlations of the radii over lags of 0, 1, 2 ... rays, over the sum of their
    squares, in sum (n - 1) e_n^2 over the harmonics n > 2 (Wiener-Khinchin)."""
    n, lag = np.arange(3, rays // 2 + 1), np.arange(rays // 2 + 1)
    share = np.cos(2 * np.pi / rays * np.outer(lag, n)) * np.where(n < rays / 2, 4, 2) / rays
    share *= np.where((lag > 0) & (lag < rays / 2), 2, 1)[:, None]
    return np.asarray(share @ (n - 1.0))


@lru_cache(maxsize=4)
def _fit_rules(rays: int) -> tuple[Any, ...]:
    """What the fits of summits on `rays` rays share, a multiple of four, the first along the long
    axis: axis ratios of the fitted ellipse over that of the rays, and least-squares matrices.

    A summit of a broad spectrum is not one polynomial: it is fitted on several nested ellipses, and
    the contact law uses the smallest that reaches beyond the contact. The ellipses share their
    samples, and their axis ratio is rounded to one of a few, so that a fit is the product with a
    matrix made beforehand.
    """
    from ._fit_kernels import NESTED_FITS

    if rays % 4:
        raise InputError(f"the rays must be mirror images in four quadrants, got {rays} rays")
    rings = 2 * np.arange(NESTED_FITS)[:, None] + np.array(_RINGS)
    root = np.sqrt(_SHRINK)
    used, rings = np.unique(rings, return_inverse=True)
    rings = rings.reshape(NESTED_FITS, len(_RINGS))
    base = np.arange(rays // 4 + 1)
    image = np.stack([base, rays // 2 - base, rays // 2 + base, rays - base], axis=1) % rays
    share = np.where((base == 0) | (base == rays // 4), 0.5, 1.0)
    weight = np.repeat(share, len(_RINGS))
    i, j = monomials(DEGREE)
    kind = parity_of(DEGREE)
    classes = [np.flatnonzero((kind == c) & (i + j >= 2)) for c in range(4)]
    count = np.array([len(c) for c in classes])
    members = np.zeros((4, count.max(), 3), dtype=np.int64)
    matrices = np.zeros((_SKEW.size, 4, count.max(), weight.size))
    turn = 2 * np.pi * base / rays
    for n, skew in enumerate(_SKEW):
        x, y = np.cos(turn), skew * np.sin(turn)
        unit = np.stack([x, y]) / np.hypot(x, y)
        x, y = (np.multiply.outer(v, root ** np.array(_RINGS)).ravel() for v in unit)
        for c, rows in enumerate(classes):
            values = x[:, None] ** i[rows] * y[:, None] ** j[rows]
            normal = values.T @ (weight[:, None] * values)
            matrices[n, c, : rows.size] = np.linalg.solve(normal, values.T * weight)
            members[c, : rows.size] = np.stack([rows, i[rows], j[rows]], axis=1)
    return _SKEW, (root ** used.astype(float), rings, image, matrices, members, count)


@lru_cache(maxsize=8)
def _rules(m: float, rays: int, samples: int) -> tuple[Any, ...]:
    """Arguments of `fit_rows`, `march_rows` and `tabulate_rows` that depend on m and the grids."""
    from ._contour_kernels import QUARTERS

    table, moments = ellipse_tables(m)
    first, last, count = LOG_RATIO
    u = LEVELS
    punch = np.ascontiguousarray(table[:, QUARTERS])
    return (
        _fit_rules(rays),
        (
            _FIRST_STEPS, m, _fine_rows(table),
            (math.log(_SHRINK), first, (last - first) / (_RATIO_POINTS - 1), _RATIO_POINTS - 1.0),
            moments,
        ),
        (u * u, 2.0 * np.log(u / np.append(u[0], u[:-1]))),
        (u, u ** (3 + m), _stencils()),
        (
            np.ascontiguousarray(_along_rays(m, samples).T),
            (punch, first, (count - 1) / (last - first), _lobes(rays)),
            _resampling(3 + m),
        ),
    )  # fmt: skip


def _fine_rows(rows: Array) -> Array:
    """Rows of the tables at `_RATIO_POINTS` axis ratios, by cubic interpolation, in the layout of
    `_contour_kernels`: every quarter, the two single numbers and the forms in groups of their own.
    """
    from surfaces.numerics.lanes import LANES, groups

    from ._contour_kernels import FORMS, NODES, QUARTERS, WIDTH

    first, last, _ = LOG_RATIO
    fine = np.stack([between(rows, place) for place in np.linspace(first, last, _RATIO_POINTS)])
    out = groups(_RATIO_POINTS * WIDTH).reshape(_RATIO_POINTS, WIDTH, LANES)
    out[:] = 0.0
    forms = fine[:, QUARTERS + 1 :]
    forms = np.pad(forms, ((0, 0), (0, FORMS * LANES - forms.shape[1])))
    out[:, : -FORMS - 1, :NODES] = fine[:, :QUARTERS].reshape(_RATIO_POINTS, -1, NODES)
    out[:, -FORMS - 1, :2] = fine[:, [0, QUARTERS]]
    out[:, -FORMS:] = forms.reshape(_RATIO_POINTS, FORMS, LANES)
    return out.ravel()


def tabulate(profiles: Profiles, material: HalfSpace) -> LawTable:
    """Law table of a batch of profiles about their optimal ellipses; see `laws.tabulate`."""
    from surfaces.numerics.lanes import LANES, in_groups, packed

    from ._ellipse_kernels import SHAPE_ROW, STATES, march_rows
    from ._fit_kernels import NESTED_FITS, SCALES, TERMS, fit_rows
    from ._table_kernels import tabulate_rows

    n, rays = profiles.phi.shape
    m = material.m
    fitting, marching, followed, levels, rows = _rules(m, rays, profiles.t.size)
    samples = (
        packed(profiles.phi), profiles.angle, packed(profiles.weight), profiles.curvature,
        packed(profiles.edge), packed(profiles.q), profiles.valid, rays, profiles.t.size,
    )  # fmt: skip
    table = LawTable.empty(n, INTERVALS, 3 + m)
    table.centre = np.zeros((n, INTERVALS + 1, 2))
    out = tuple(table.columns.values())
    u = levels[0]
    widths = (4 * rays, NESTED_FITS * TERMS, SCALES, u.size * STATES, SHAPE_ROW, LANES)

    def part(begin: int, end: int) -> None:
        frames, coefs, scales, states, shapes, ends = (
            np.empty((end - begin, in_groups(width))) for width in widths
        )
        found = states, shapes, ends
        fit_rows(begin, end, samples, fitting, u[0] ** 2, m, frames, coefs, scales)
        march_rows(coefs, frames, scales, rays, followed, *marching, found)
        tabulate_rows(
            begin, samples, frames, scales, found, levels, m, material.modulus, *rows, out
        )

    parallel.run(part, parallel.blocks(n, 32, _BLOCK))
    return table
