"""Tables that all profiles share: the elliptic contact over its axis ratio, and their fits.

`EllipseTables` holds, by Galin's operator (`ellipse_operator`), the amplitude of the edge
singularity of each displacement monomial at nodes on a quarter of the ellipse, and the second-order
effect of a displaced contour. It takes a fraction of a second to make.

`FitRules` holds least-squares matrices. A summit of a broad spectrum is not one polynomial: it is
fitted on several nested ellipses, and the law uses the smallest that reaches beyond the contact.
The ellipses share their samples, and their axis ratio is rounded to one of a few, so that a fit is
one product with a matrix.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from surfaces.errors import InputError

from .ellipse_operator import (
    DEGREE,
    edge_operator,
    fourier_moments,
    monomials,
    parity_of,
    product_weights,
    punch_moments,
    steeper_operator,
)

__all__ = [
    "LANES",
    "LOG_RATIO",
    "EllipseTables",
    "FitRules",
    "between",
    "edge_slopes",
    "ellipse_tables",
    "fit_rules",
]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

LANES = 8
"""Nodes on a quarter of the ellipse in the tables: DEGREE + 1, padded by the last one."""

LOG_RATIO = (math.log(1 / 80), math.log(2.5), 64)
"""First and last ln(b/a) of the tables and the number of nodes."""

SHRINK = 0.66
"""Size of each nested ellipse over the next larger one."""

_RINGS = (0, 1, 2, 4, 6)
"""Radii of the samples of one fit, as powers of sqrt(`SHRINK`) times its size."""

_SKEW = np.exp(np.linspace(np.log(0.5), np.log(16.0), 36))
"""Axis ratios of the fitted ellipse over that of the rays; each summit gets the nearest."""


@dataclass(frozen=True)
class EllipseTables:
    """Tables of the elliptic contact of one grading exponent.

    Parameters
    ----------
    rows
        One row per ln(b/a): edge amplitudes (monomial, node) flattened, quadrature weights of
        ``gamma**(m-1)`` at the nodes, stiffness of the unit punch (s = 1, modulus 1), and the
        upper triangles of the second-order stiffness form of the four parity classes. Every
        quarter is padded to `LANES` nodes by its last one, without weight.
    moments
        Mean of each monomial under the flat-punch pressure of the ellipse.
    order
        Degree of each monomial.
    """

    rows: Array
    moments: Array
    order: NDArray[np.int64]


def _free_fields(
    m: float, ratio: Array, degree: int, t: Array
) -> Iterator[tuple[int, Index, Array, list[Array]]]:
    """Fields ``P (1 - rho**2)**((m-3)/2)``, P a polynomial, that cause no displacement.

    Yields for each parity class: 0 for cosines or 1 for sines; the numbers k of the Fourier modes
    that P has at the edge; these modes at the parameters t, shape (t, k); the first and the second
    coefficient of P there in powers of ``1 - rho**2``, shape (ratio, t, k) each.
    """
    lower = steeper_operator(m, ratio, degree)
    i, j = monomials(degree)
    parity, order = parity_of(degree), i + j
    edge = np.cos(t) ** i[:, None] * np.sin(t) ** j[:, None]
    for kind, (form, first) in enumerate(((0, 0), (1, 2), (0, 1), (1, 1))):
        rows = np.flatnonzero(parity == kind)
        number = np.arange(first, degree + 1, 2)
        modes = (np.cos if form == 0 else np.sin)(np.outer(t, number))
        null = np.swapaxes(lower[:, rows[:, None], rows], 1, 2)
        null = null / np.abs(null).max()
        values = np.broadcast_to(edge[rows].T, (ratio.size, t.size, rows.size))
        system = np.concatenate([null, values], axis=1)
        right = np.concatenate([np.zeros((rows.size, number.size)), modes])
        solution = np.linalg.pinv(system, rcond=1e-12) @ right
        slopes = [
            np.einsum("rt,brk->btk", edge[rows] * factor[rows, None], solution)
            for factor in (-order / 2, order * (order - 2) / 8)
        ]
        yield form, number, modes, slopes


def _stiffness_forms(m: float, ratio: Array, degree: int, moments: Array) -> Array:
    """Upper triangles of the second-order form S of the stiffness, per ratio.

    A contour displaced by the Fourier modes x_i changes the stiffness in second order by
    sum S_ij x_i x_j. `moments` are the means of ``gamma**(m-1) cos(k t)`` over the edges.
    """
    count = 2 * (moments.shape[1] - 1)
    weight, bent = (
        product_weights(part, count, 2 * np.pi)
        for part in (moments, -moments * np.arange(moments.shape[1]) ** 2)
    )
    out = []
    for _, number, modes, (slope, _) in _free_fields(
        m, ratio, degree, np.arange(count) * 2 * np.pi / count
    ):
        form = np.einsum("bt,ti,btj->bij", weight, modes, 0.5 * m * modes + (m - 1) * slope)
        form = form + 0.25 * np.einsum("bt,ti,tj->bij", bent, modes, modes)
        form = 0.5 * (form + np.swapaxes(form, 1, 2))
        for p in range(number.size):
            for q in range(p, number.size):
                out.append(form[:, p, q] * (1.0 if p == q else 2.0))
    return np.array(out).T


@lru_cache(maxsize=8)
def edge_slopes(m: float, degree: int) -> Array:
    """Operators R and R' of docs/development/laws.md in Fourier modes up to an even degree.

    A field ``P (1 - rho**2)**((m-3)/2)`` without displacement has the expansion P = P0 + P1 y + P2
    y^2 in ``y = 1 - rho**2`` at the edge. The matrices take the modes of P0 to those of P1 and of
    P2, for cosines and for sines; shape (ratios, 2, 2, degree + 1, degree + 1), with the index of
    the coefficient before that of cosine and sine. On the circle they are ``-k/2`` and
    ``k (k - 2)/8``.
    """
    ratio, count = np.exp(np.linspace(*LOG_RATIO)), 4 * (degree + 1)
    out = np.zeros((ratio.size, 2, 2, degree + 1, degree + 1))
    for form, number, modes, slopes in _free_fields(
        m, ratio, degree, np.arange(count) * 2 * np.pi / count
    ):
        norm = np.sum(modes * modes, axis=0)
        for which, inner in enumerate(slopes):
            out[:, which, form, number[:, None], number] = np.swapaxes(
                np.einsum("btk,tl->bkl", inner, modes) / norm, 1, 2
            )
    return out


@lru_cache(maxsize=8)
def ellipse_tables(m: float, degree: int = DEGREE) -> EllipseTables:
    """Tables of the elliptic contact for one grading exponent -1 < m < 1 and an even degree of the
    profile polynomials, at least 2; built once per process."""
    quarter = degree + 1
    nodes = np.linspace(0, np.pi / 2, quarter)
    ratio = np.exp(np.linspace(*LOG_RATIO))
    fine = np.arange(8192) * np.pi / 8192
    squared = np.cos(fine) ** 2 * ratio[:, None] + np.sin(fine) ** 2 / ratio[:, None]
    moments = np.zeros((ratio.size, 4 * (degree + 2) + 1))
    moments[:, ::2] = fourier_moments(squared ** ((m - 1) / 2), 2 * (degree + 2) + 1)
    around = 4 * degree
    on_quarter = product_weights(moments[:, : around // 2 + 1], around, 2 * np.pi)[:, :quarter]
    on_quarter = on_quarter * np.where((nodes == 0) | (nodes == nodes[-1]), 2.0, 4.0)
    stiffness = 2 / ((1 + m) * moments[:, :1])
    forms = _stiffness_forms(m, ratio, degree, moments)
    spare = ((0, 0), (0, max(LANES - quarter, 0)))
    edge = edge_operator(m, ratio, degree)
    edge = np.pad(edge, ((0, 0), *spare), mode="edge").reshape(ratio.size, -1)
    rows = np.concatenate([edge, np.pad(on_quarter, spare), stiffness, forms], axis=1)
    i, j = monomials(degree)
    return EllipseTables(np.ascontiguousarray(rows), punch_moments(degree, m), i + j)


def between(rows: Array, position: float) -> Array:
    """Row of a table at ln(b/a) = `position`, by cubic interpolation (Lagrange, four rows)."""
    first, last, count = LOG_RATIO
    place = min(max((position - first) / (last - first) * (count - 1), 0.0), count - 1.0)
    i = min(max(int(place), 1), count - 3)
    u = place - i
    share = np.array(
        [
            -u * (u - 1) * (u - 2) / 6,
            (u + 1) * (u - 1) * (u - 2) / 2,
            -(u + 1) * u * (u - 2) / 2,
            (u + 1) * u * (u - 1) / 6,
        ]
    )
    return np.asarray(share @ rows[i - 1 : i + 3])


@dataclass(frozen=True, eq=False)
class FitRules:
    """Least-squares matrices of the nested fits, for all summits.

    Parameters
    ----------
    radii
        Radii of the samples over the largest ellipse.
    rings
        Index in `radii` of the samples of each fit, shape (fits, rings).
    image
        Rays at (+,+), (-,+), (-,-), (+,-) of each ray in the first quadrant.
    skew
        Axis ratios of the fitted ellipse over that of the rays.
    matrices
        Matrices from the means of a parity class at the points (ray, ring) to the coefficients of
        its monomials, shape (skew, class, monomials of the class, points), padded.
    members, count
        Index, i and j of the monomials x^i y^j of each class, and their number.
    logs
        Logarithms of the sizes of the fits over the largest.
    """

    radii: Array
    rings: Index
    image: Index
    skew: Array
    matrices: Array
    members: Index
    count: Index
    logs: Array


@lru_cache(maxsize=4)
def fit_rules(rays: int) -> FitRules:
    """Rules for summits on `rays` rays, a multiple of four, the first along the long axis."""
    from ._fit_kernels import NESTED_FITS

    if rays % 4:
        raise InputError(f"the rays must be mirror images in four quadrants, got {rays} rays")
    rings = 2 * np.arange(NESTED_FITS)[:, None] + np.array(_RINGS)
    root = np.sqrt(SHRINK)
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
    return FitRules(
        radii=root ** used.astype(float),
        rings=rings,
        image=image,
        skew=_SKEW,
        matrices=matrices,
        members=members,
        count=count,
        logs=np.log(SHRINK) * np.arange(NESTED_FITS),
    )
