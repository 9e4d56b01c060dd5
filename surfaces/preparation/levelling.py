"""Take tilt or form out of a height map, unmoved by spikes and missing points."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from surfaces.errors import SurfaceError
from surfaces.heightmap import HeightMap, require_map

__all__ = ["FORMS", "level"]

_ORDERS = ("mean", "plane", "quadratic", "cubic", "quartic", "quintic")
FORMS = (*_ORDERS, "cylinder")
_POWERS = [(order - k, k) for order in range(len(_ORDERS)) for k in range(order + 1)]
_TERMS = {form: (n + 1) * (n + 2) // 2 for n, form in enumerate(_ORDERS)} | {"cylinder": 6}
_FEWEST = _TERMS["quadratic"]  # terms of which lower forms leave some out
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
    SurfaceError
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
    if form not in FORMS:
        raise SurfaceError(f"level is {form!r}; it must be None or one of {', '.join(FORMS)}")
    if hm.periodic:
        form = "mean"
    terms = _TERMS[form]
    u, v = _axis(hm.shape[1]), _axis(hm.shape[0])
    present = np.isfinite(hm.heights)
    if np.count_nonzero(present) <= 2 * terms:
        raise SurfaceError(
            f"{np.count_nonzero(present)} points are present; too few to fit a {form}"
        )
    shift = float(np.median(_sample(hm.heights, present)))
    z = np.where(present, hm.heights - shift, 0.0)
    scale = float(max(z.max(), -z.min())) or 1.0
    z /= scale
    aspect = hm.size[0] / hm.size[1]
    coefficients = _solve(*_block_medians(z, present, v, u), form, aspect)
    kept = present
    for _ in range(_ROUNDS):
        inside = _inliers(z - _evaluate(coefficients, v, u), present)
        if np.count_nonzero(inside) <= 2 * terms:
            break
        coefficients = _fit(z, inside.astype(np.float64), v, u, form, aspect)
        if np.array_equal(inside, kept):
            break
        kept = inside
    levelled = (z - _evaluate(coefficients, v, u)) * scale
    levelled[~present] = np.nan
    if np.nanmax(np.abs(levelled)) <= _ROUNDING * max(abs(shift), scale):
        levelled[present] = 0.0
    step = {"step": "level", "form": form, "left_out": int(present.sum() - kept.sum())}
    step |= _described(coefficients * scale, shift, hm.size, form)
    return hm.replace(heights=levelled, step=step)


def _axis(count: int) -> NDArray[np.float64]:
    """Pixel centres scaled to the interval -1 to 1."""
    return (2.0 * np.arange(count) + 1.0 - count) / count


def _evaluate(
    coefficients: NDArray[np.float64], v: NDArray[np.float64], u: NDArray[np.float64]
) -> NDArray[np.float64]:
    c0, cu, cv, cuu, cuv, cvv = coefficients[:_FEWEST]
    along_x = cu * u + cuu * u * u
    along_y = c0 + cv * v + cvv * v * v
    form: NDArray[np.float64] = along_y[:, None] + along_x[None, :]
    if cuv:
        form += (cuv * v)[:, None] * u[None, :]
    for (a, b), c in zip(_POWERS[_FEWEST:], coefficients[_FEWEST:], strict=False):
        form += (c * v**b)[:, None] * u**a
    return form


def _inliers(residual: NDArray[np.float64], present: NDArray[np.bool_]) -> NDArray[np.bool_]:
    sample = _sample(residual, present)
    center = float(np.median(sample))
    sigma = _MAD_TO_SIGMA * float(np.median(np.abs(sample - center)))
    if sigma == 0.0:
        return present
    return present & (np.abs(residual - center) <= _REJECT * sigma)


def _sample(values: NDArray[np.float64], present: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Some hundred thousand of the values present, evenly spread; all of them on a small map."""
    step = max(1, math.isqrt(values.size // 200_000))
    sample = values[::step, ::step][present[::step, ::step]]
    return sample if sample.size else values[present]


def _fit(
    z: NDArray[np.float64],
    weight: NDArray[np.float64],
    v: NDArray[np.float64],
    u: NDArray[np.float64],
    form: str,
    aspect: float,
) -> NDArray[np.float64]:
    """Weighted least squares from the moments of the grid, one matrix product each."""
    powers = _POWERS[: max(_FEWEST, _TERMS[form])]
    most = max(powers[-1])
    powers_u, powers_v = (np.vander(w, 2 * most + 1, increasing=True) for w in (u, v))
    moments = powers_v.T @ (weight @ powers_u)
    right = powers_v[:, : most + 1].T @ ((weight * z) @ powers_u[:, : most + 1])
    matrix = np.array([[moments[b + d, a + c] for c, d in powers] for a, b in powers])
    return _constrained(matrix, np.array([right[b, a] for a, b in powers]), form, aspect)


def _solve(
    z: NDArray[np.float64],
    v: NDArray[np.float64],
    u: NDArray[np.float64],
    form: str,
    aspect: float,
) -> NDArray[np.float64]:
    """Least absolute deviations of scattered values, by reweighting."""
    powers = _POWERS[: max(_FEWEST, _TERMS[form])]
    columns = np.stack([u**a * v**b for a, b in powers], axis=1)
    weight = np.ones(z.size)
    for _ in range(_ROUNDS):
        weighted = columns * weight[:, None]
        coefficients = _constrained(columns.T @ weighted, weighted.T @ z, form, aspect)
        deviation = np.abs(z - columns @ coefficients)
        weight = 1.0 / np.maximum(deviation, 1e-6 + 0.1 * np.median(deviation))
    return coefficients


def _constrained(
    matrix: NDArray[np.float64], right: NDArray[np.float64], form: str, aspect: float
) -> NDArray[np.float64]:
    """Solve the normal equations in the space of the form, padded with zeros."""
    coefficients = np.zeros(len(right))
    if form != "cylinder":
        terms = _TERMS[form]
        coefficients[:terms] = np.linalg.lstsq(matrix[:terms, :terms], right[:terms], rcond=None)[0]
        return coefficients

    def basis(angle: float) -> NDArray[np.float64]:
        across_u, across_v = math.cos(angle), math.sin(angle) * aspect
        square = np.array([across_u**2, 2.0 * across_u * across_v, across_v**2])
        return np.hstack([np.eye(6, 3), np.r_[np.zeros(3), square][:, None]])

    def solution(angle: float) -> tuple[float, NDArray[np.float64]]:
        columns = basis(angle)
        inner = np.linalg.lstsq(columns.T @ matrix @ columns, columns.T @ right, rcond=None)[0]
        return -float(inner @ (columns.T @ right)), columns @ inner

    best, width = 0.0, math.pi / 2
    for _ in range(12):
        angles = best + np.linspace(-width, width, 25)
        best = min(angles, key=lambda angle: solution(angle)[0])
        width /= 8.0
    return solution(best)[1]


def _block_medians(
    z: NDArray[np.float64],
    present: NDArray[np.bool_],
    v: NDArray[np.float64],
    u: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Median height and mean place of the present points of a coarse grid of blocks."""
    rows = np.array_split(np.arange(len(v)), min(_BLOCKS, len(v)))
    columns = np.array_split(np.arange(len(u)), min(_BLOCKS, len(u)))
    found = []
    for row in rows:
        step_v = max(1, len(row) // 16)
        for column in columns:
            step_u = max(1, len(column) // 16)
            block = np.ix_(row[::step_v], column[::step_u])
            mask = present[block]
            if mask.any():
                inside_v, inside_u = np.nonzero(mask)
                found.append(
                    (
                        float(np.median(z[block][mask])),
                        float(v[row[::step_v]][inside_v].mean()),
                        float(u[column[::step_u]][inside_u].mean()),
                    )
                )
    medians, place_v, place_u = np.array(found).T
    return medians, place_v, place_u


def _described(
    coefficients: NDArray[np.float64], shift: float, size: tuple[float, float], form: str
) -> dict[str, object]:
    """Coefficients in physical terms about the middle of the map."""
    half_y, half_x = size[0] / 2.0, size[1] / 2.0
    c0, cu, cv, cuu, cuv, cvv = coefficients[:_FEWEST].tolist()
    found: dict[str, object] = {"offset": c0 + shift}
    if form != "mean":
        found["slope"] = [cv / half_y, cu / half_x]
    if form in ("quadratic", "cylinder"):
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
