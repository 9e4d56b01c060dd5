"""Take tilt or form out of a height map, unmoved by spikes and missing points."""

from __future__ import annotations

import math

import numpy as np

from surfaces.arrays import Array
from surfaces.errors import SurfaceError, as_choice
from surfaces.heightmap import HeightMap, require_map
from surfaces.numerics.stored_array import Source, each_block, windows

__all__ = ["FORMS", "level"]

_ORDERS = ("mean", "plane", "quadratic", "cubic", "quartic", "quintic")
FORMS = (*_ORDERS, "cylinder")
_POWERS = [(order - k, k) for order in range(len(_ORDERS)) for k in range(order + 1)]
_TERMS = {form: (n + 1) * (n + 2) // 2 for n, form in enumerate(_ORDERS)} | {"cylinder": 6}
_REJECT = 6.0
"""Robust standard deviations beyond which a point is left out."""

_MAD_TO_SIGMA = 1.4826
"""Standard deviation over median absolute deviation of a normal variable."""

_BLOCKS = 24
"""Blocks along each side whose medians the first fit takes."""

_ROUNDS = 20
"""Fits at most."""

_ROUNDING = 1e-13
"""Heights left over those given, below which only rounding is left."""


def level(hm: HeightMap, form: str = "plane") -> HeightMap:
    """Subtract the least-squares form: the F operation, by polynomials or a cylinder.

    Parameters
    ----------
    hm
        The map; missing points stay missing.
    form
        ``mean``, ``plane``, ``quadratic``, ``cubic``, ``quartic``, ``quintic``: all terms of a
        polynomial of total order 0 to 5. ``cylinder``: a plane and a parabolic cylinder of any
        direction (sag much smaller than the radius).

    Returns
    -------
    HeightMap
        The levelled map; history step ``level`` with the coefficients and the count of points
        that the fit left out.

    Raises
    ------
    InputError
        If the form is unknown, or too few points are present to fit it.

    Notes
    -----
    A form is fitted to block medians first; then points further than 6 robust standard deviations
    (1.4826 times the median absolute deviation) are left out and the rest is fitted by least
    squares, until the selection no longer changes. Without spikes this is the plain least-squares
    form. A periodic map has no tilt or form: only its mean is taken out. Where nothing but rounding
    is left, the heights are zero.

    References
    ----------
    ISO 25178-2:2021, 3.1 (F-operation).

    Examples
    --------
    >>> import numpy as np
    >>> import surfaces
    >>> y, x = np.mgrid[:32, :48]
    >>> hm = surfaces.HeightMap(1e-6 + 1e-8 * x - 2e-8 * y, 1e-6)
    >>> bool(surfaces.level(hm, "plane").rms_height < 1e-20)
    True
    """
    require_map(hm)
    as_choice("level", form, FORMS)
    if hm.periodic:
        form = "mean"
    terms = _TERMS[form]
    u, v = _axis(hm.shape[1]), _axis(hm.shape[0])
    present = hm.source.size - hm.missing
    if present <= 2 * terms:
        raise SurfaceError(f"{present} points are present; too few to fit a {form}")
    stride, sample = _sample(hm.source)
    shift = float(np.median(sample[~np.isnan(sample)]))
    scale = max(hm.roughness.highest - shift, shift - hm.roughness.lowest) or 1.0
    z, sample = each_block(hm.source, lambda h: (h - shift) / scale), (sample - shift) / scale
    aspect = hm.size[0] / hm.size[1]
    coefficients = _solve(*_block_medians(z, v, u), form, aspect)
    left_out, kept = 0, None
    for _ in range(_ROUNDS):
        limits = _limits(sample - _evaluate(coefficients, v[::stride], u[::stride]))
        moments, right = _sums(z, coefficients, limits, v, u, form)
        inside = round(moments[0, 0])
        if inside <= 2 * terms:
            break
        coefficients = _fit(moments, right, form, aspect)
        same = inside == present if kept is None else np.array_equal(moments, kept)
        left_out, kept = present - inside, moments
        if same:  # other points would have other moments
            break
    levelled = hm.with_rows(
        (begin, (rows - _evaluate(coefficients, v[begin:end], u)) * scale)
        for begin, end, rows in windows(z)
    )
    if levelled.roughness.largest <= _ROUNDING * max(abs(shift), scale):
        levelled = levelled.replace(
            heights=each_block(levelled.source, lambda h: np.where(np.isnan(h), h, 0.0))
        )
    step = {"step": "level", "form": form, "left_out": left_out}
    step |= _described(coefficients * scale, shift, hm.size, form)
    return levelled.replace(step=step)


def _axis(count: int) -> Array:
    """Pixel centres scaled to the interval -1 to 1."""
    return (2.0 * np.arange(count) + 1.0 - count) / count


def _evaluate(coefficients: Array, v: Array, u: Array) -> Array:
    terms = [(a, b, c) for (a, b), c in zip(_POWERS, coefficients, strict=False) if c]
    along_y = sum((c * v**b for a, b, c in terms if a == 0), np.zeros(v.size))
    along_x = sum((c * u**a for a, b, c in terms if a and b == 0), np.zeros(u.size))
    form: Array = along_y[:, None] + along_x
    for a, b, c in terms:
        if a and b:
            form += (c * v**b)[:, None] * u**a
    return form


def _sample(heights: Source) -> tuple[int, Array]:
    """Stride and heights of some hundred thousand points, evenly spread, some of them present."""
    stride = max(1, math.isqrt(heights.size // 200_000))
    while np.isnan(sample := heights[::stride, ::stride]).all():
        stride = max(1, stride // 2)
    return stride, sample


def _limits(residual: Array) -> tuple[float, float]:
    """Centre of the residuals of a sample, and how far from it points are kept."""
    sample = residual[~np.isnan(residual)]
    center = float(np.median(sample))
    sigma = _MAD_TO_SIGMA * float(np.median(np.abs(sample - center)))
    return center, _REJECT * sigma or math.inf


def _sums(
    z: Source, coefficients: Array, limits: tuple[float, float], v: Array, u: Array, form: str
) -> tuple[Array, Array]:
    """Moments of the places, and of the heights, within limits about a form: one matrix product
    each."""
    center, limit = limits
    most = max(1, *_powers(form)[-1])  # so that other points have other moments
    powers_u, powers_v = (np.vander(w, 2 * most + 1, increasing=True) for w in (u, v))
    moments, right = np.zeros((2 * most + 1,) * 2), np.zeros((most + 1,) * 2)
    for begin, end, rows in windows(z):
        inside = np.abs(rows - _evaluate(coefficients, v[begin:end], u) - center) <= limit
        along = powers_v[begin:end].T
        moments += along @ (inside.astype(np.float64) @ powers_u)
        right += along[: most + 1] @ (np.where(inside, rows, 0.0) @ powers_u[:, : most + 1])
    return moments, right


def _powers(form: str) -> list[tuple[int, int]]:
    return _POWERS[: _TERMS[form]]


def _fit(moments: Array, right: Array, form: str, aspect: float) -> Array:
    """Least squares from the moments of the grid."""
    powers = _powers(form)
    matrix = np.array([[moments[b + d, a + c] for c, d in powers] for a, b in powers])
    return _constrained(matrix, np.array([right[b, a] for a, b in powers]), form, aspect)


def _solve(z: Array, v: Array, u: Array, form: str, aspect: float) -> Array:
    """Least absolute deviations of scattered values, by reweighting."""
    columns = np.stack([u**a * v**b for a, b in _powers(form)], axis=1)
    weight = np.ones(z.size)
    for _ in range(_ROUNDS):
        weighted = columns * weight[:, None]
        coefficients = _constrained(columns.T @ weighted, weighted.T @ z, form, aspect)
        deviation = np.abs(z - columns @ coefficients)
        weight = 1.0 / np.maximum(deviation, 1e-6 + 0.1 * np.median(deviation))
    return coefficients


def _constrained(matrix: Array, right: Array, form: str, aspect: float) -> Array:
    """Solve the normal equations in the space of the form."""
    if form != "cylinder":
        return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0])

    def basis(angle: float) -> Array:
        across_u, across_v = math.cos(angle), math.sin(angle) * aspect
        square = np.array([across_u**2, 2.0 * across_u * across_v, across_v**2])
        return np.hstack([np.eye(6, 3), np.r_[np.zeros(3), square][:, None]])

    def solution(angle: float) -> tuple[float, Array]:
        columns = basis(angle)
        inner = np.linalg.lstsq(columns.T @ matrix @ columns, columns.T @ right, rcond=None)[0]
        return -float(inner @ (columns.T @ right)), columns @ inner

    best, width = 0.0, math.pi / 2
    for _ in range(12):
        angles = best + np.linspace(-width, width, 25)
        best = min(angles, key=lambda angle: solution(angle)[0])
        width /= 8.0
    return solution(best)[1]


def _block_medians(z: Source, v: Array, u: Array) -> tuple[Array, Array, Array]:
    """Median height and mean place of the present points of a coarse grid of blocks."""
    columns = np.array_split(np.arange(len(u)), min(_BLOCKS, len(u)))
    found = []
    for row in np.array_split(np.arange(len(v)), min(_BLOCKS, len(v))):
        row = row[:: max(1, len(row) // 16)]
        lines = z[row]
        for column in columns:
            column = column[:: max(1, len(column) // 16)]
            block = lines[:, column]
            mask = ~np.isnan(block)
            if mask.any():
                inside_v, inside_u = np.nonzero(mask)
                place = v[row][inside_v].mean(), u[column][inside_u].mean()
                found.append((np.median(block[mask]), *place))
    medians, place_v, place_u = np.array(found).T
    return medians, place_v, place_u


def _described(
    coefficients: Array, shift: float, size: tuple[float, float], form: str
) -> dict[str, object]:
    """Coefficients in physical terms about the middle of the map."""
    half_y, half_x = size[0] / 2.0, size[1] / 2.0
    found: dict[str, object] = {"offset": float(coefficients[0]) + shift}
    if form != "mean":
        cu, cv = coefficients[1:3].tolist()
        found["slope"] = [cv / half_y, cu / half_x]
    if form in ("quadratic", "cylinder"):
        cuu, cuv, cvv = coefficients[3:].tolist()
        hessian = np.array(
            [
                [2.0 * cuu / half_x**2, cuv / (half_x * half_y)],
                [cuv / (half_x * half_y), 2.0 * cvv / half_y**2],
            ]
        )
        curvature, direction = np.linalg.eigh(hessian)
        order = np.argsort(-np.abs(curvature))
        found["curvature"] = curvature[order].tolist()
        across = direction[:, order[0]]
        found["angle"] = float(np.arctan2(across[1], across[0]) % np.pi)
    return found
