"""Values and slopes of a contact curve from its load points, and its misfit between anchors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.errors import InputError
from surfaces.arrays import Array, Index, Mask
from surfaces.errors import as_numbers

__all__ = [
    "END_SLACK",
    "POINT_FIELDS",
    "CurvePoint",
    "contact_pressure",
    "curve_stiffness",
    "halved_intervals",
    "interpolated_misfit",
    "knots_of",
    "log_ratio",
    "read_off",
]


END_SLACK = 5e-3
"""Relative distance beyond its ends at which a curve can be evaluated. Pressures asked for must be
within the curve, and solved ones differ from them by the tolerance of the solve."""


QUESTIONS = {
    "pressure": ("mean_pressure", " Pa"),
    "load": ("load", " N"),
    "separation": ("separation", " m"),
    "area_fraction": ("area_fraction", ""),
}
"""Arguments of `ContactCurve.at`: the column of each, and its unit."""


LEAST_SPAN = 0.25
"""Least difference in the logarithm of pressure of two points whose secant is used."""

LARGEST_GAP = 2.5
"""Largest difference in the logarithm of pressure over which the tangents are integrated."""


LEAST_STEP = 1e-3
"""Difference in the logarithm of pressure below which the slope between two points is noise."""

_HALVINGS = 60
"""Steps of bisection, to the last digit."""


@dataclass(frozen=True)
class CurvePoint:
    """A contact curve evaluated at one or several places; arrays have the shape of the argument.

    Attributes
    ----------
    separation, mean_pressure, load, area_fraction, contact_area, contacts, stiffness
        As in `ContactCurve`, interpolated between the converged load points.
    error_estimate, area_error_estimate
        Stated relative errors of load and area of the load points beside it, likewise; what the
        interpolation misses is not in them. NaN where none is stated.
    """

    separation: Any
    mean_pressure: Any
    load: Any
    area_fraction: Any
    contact_area: Any
    contacts: Any
    stiffness: Any
    error_estimate: Any = np.nan
    area_error_estimate: Any = np.nan

    @property
    def mean_contact_pressure(self) -> Any:
        """Load over contact area [Pa]; NaN where nothing touches."""
        return contact_pressure(self.load, self.contact_area)[()]


STATED = ("error_estimate", "area_error_estimate")

READ_FIELDS = tuple(field.name for field in fields(CurvePoint) if field.name not in STATED)
"""Columns of a curve that can be read off between its points."""

POINT_FIELDS = (*READ_FIELDS, "converged", "residual", "error_estimate")
"""Columns that every curve has."""


def contact_pressure(load: ArrayLike, area: ArrayLike) -> Array:
    """Mean pressure [Pa] of contact areas [m^2] under loads [N]; NaN where nothing touches."""
    area = np.asarray(area, float)
    touching = np.where(area > 0.0, area, np.nan)
    return np.asarray(load, float) / touching


def read_off(
    columns: Mapping[str, NDArray[Any]], questions: Mapping[str, ArrayLike | None]
) -> CurvePoint:
    """Interpolate a curve, see `ContactCurve.at`.

    Of its columns (`CurveTable.columns`) `READ_FIELDS` are read between the points that converged,
    and the errors `STATED` if they are there, where `questions` says by the names of `QUESTIONS`;
    all but one of these are None.
    """
    from scipy.interpolate import PchipInterpolator

    given = [name for name, values in questions.items() if values is not None]
    if len(given) != 1:
        raise InputError(
            "give one of pressure, load, separation or area_fraction to read the curve off"
        )
    name, (column, unit) = given[0], QUESTIONS[given[0]]
    order = knots_of(columns, closed=True)
    if column == "area_fraction":
        # boundary elements count pixels: areas of light loads may be equal
        areas = columns[column][order]
        order = order[areas >= np.maximum.accumulate(areas)]
    if len(order) < 2:
        raise InputError("the curve has fewer than two converged points with load")
    log_p = np.log(columns["mean_pressure"][order])
    asked = as_numbers(name, questions[name])
    knots = columns[column][order]
    low, high = knots.min(), knots.max()
    if column == "separation":  # less of it is more load
        slack = 1e-9 * max(abs(low), abs(high), high - low)
        rising, place = -knots, -asked
    else:
        slack = END_SLACK
        with np.errstate(divide="ignore", invalid="ignore"):
            rising, place = np.log(knots), np.log(asked)
    inside = (place >= rising[0] - slack) & (place <= rising[-1] + slack)
    if not np.all(inside):
        raise InputError(
            f"{name} {asked[~inside].flat[0]:.4g}{unit} lies outside the converged curve, "
            f"{low:.4g} to {high:.4g}{unit}; add load points there"
        )
    key = place if column == "mean_pressure" else _inverse(log_p, rising, place)

    def read(name: str, in_log: bool) -> Any:
        values = np.asarray(columns[name], dtype=float)[order]
        finite = np.isfinite(values) & ((values > 0) | (not in_log))
        if np.count_nonzero(finite) < 2:
            return np.full(np.shape(asked), np.nan)[()]
        knots = np.log(values[finite]) if in_log else values[finite]
        places = log_p[finite]
        found = PchipInterpolator(places, knots)(key)
        known = (key >= places[0] - END_SLACK) & (key <= places[-1] + END_SLACK)
        found = np.where(known, found, np.nan)
        return (np.exp(found) if in_log else found)[()]

    found = {part: read(part, part != "separation") for part in READ_FIELDS}
    found["mean_pressure"] = np.exp(key)[()]
    if column != "mean_pressure":  # what was asked for comes back
        found[column] = asked[()]
    for name in STATED:
        if name in columns:
            found[name] = np.interp(key, log_p, columns[name][order])[()]
    return CurvePoint(**found)


def _inverse(places: Array, values: Array, wanted: Array) -> Array:
    """Places at which the monotone cubics through ascending values have the values `wanted`.

    Beyond the ends the place goes on with slope one. It is found by bisection to the last digit, so
    that a value that was interpolated at a place gives back this place.
    """
    from scipy.interpolate import PchipInterpolator

    read = PchipInterpolator(places, values)
    inside = np.clip(wanted, values[0], values[-1])
    low, high = np.full(wanted.shape, places[0]), np.full(wanted.shape, places[-1])
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        below = read(middle) < inside
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.asarray(0.5 * (low + high) + (wanted - inside))


def knots_of(columns: Mapping[str, NDArray[Any]], *, closed: bool = False) -> Index:
    """Indices of the points between which a curve is interpolated, in the order of the load.

    They are the points under load whose separation is smaller than that of all lighter ones; in
    full contact, where the separation stays, only the lightest, or all if `closed`. Of points of
    one load, as where all has yielded, the one of largest separation counts. Of points of nearly
    one load, whose difference is that of two solutions more than of two loads, one is kept.
    """
    pressures, separations = columns["mean_pressure"], columns["separation"]
    usable = columns["converged"] & (pressures > 0) & np.isfinite(separations)
    order = np.flatnonzero(usable)[np.lexsort((-separations[usable], pressures[usable]))]
    order = order[_rising(pressures[order])]
    scale = np.abs(separations[order]).max(initial=0.0) or 1.0
    # rounding is no smaller gap
    lift = np.round(-separations[order] / scale, 12)
    falls = _rising(lift)
    if closed and falls.any():
        last = np.flatnonzero(falls)[-1]
        falls[last:] = lift[last:] == lift[last]
    order = order[falls]
    return order[_apart(np.log(pressures[order]))]


def _apart(logs: Array) -> list[int]:
    """Indices of ascending values that are `LEAST_STEP` apart, from the first to the last."""
    kept: list[int] = []
    for i, value in enumerate(logs.tolist()):
        if not kept or value - logs[kept[-1]] > LEAST_STEP:
            kept.append(i)
    last = len(logs) - 1
    if kept and kept[-1] < last and logs[last] > logs[kept[-1]]:
        # the end of the curve stays, in place of the last point kept if that is not the first
        kept[max(len(kept) - 1, 1) :] = [last]
    return kept


def _rising(values: Array) -> Mask:
    """Values above all before them."""
    return np.asarray(values > np.maximum.accumulate(np.append(-np.inf, values))[:-1])


def curve_stiffness(pressure: Array, separation: Array, tangent: Array, usable: Mask) -> Array:
    """Minus the slope of pressure over separation at the points of a curve [Pa/m], shape (n,).

    The points are at mean pressures [Pa] and separations [m], shape (n,), in any order; `tangent`
    is the stiffness of each at contacts that stay where they are and keep their shapes [Pa/m], and
    `usable` those that converged.

    Notes
    -----
    The tangent neglects that contacts shift and elongate with load: it is too low by 2 % at light
    load and 14 % at 15 % of contact (boundary elements). This ratio varies slowly along the curve
    and follows from two points: -ds = dp/k, integrated between the points as a power law of p
    through the tangents, over the difference of their separations. A point without another within
    a factor of ten of its pressure keeps its tangent.
    """
    found = np.array(tangent, dtype=float)
    usable = usable & (pressure > 0) & (found > 0) & np.isfinite(separation)
    order = np.flatnonzero(usable)[np.argsort(pressure[usable], kind="stable")]
    x, fall = np.log(pressure[order]), -separation[order]
    rate = pressure[order] / found[order]
    gap, growth = np.diff(x), np.diff(np.log(rate))
    # (b - a) / ln(b / a), and a where they are equal
    bent = np.where(np.abs(growth) > 1e-6, np.expm1(growth) / np.where(growth, growth, 1.0), 1.0)
    told = np.append(0.0, np.cumsum(gap * rate[:-1] * bent))
    for i in range(len(order)):
        low = high = i
        while low > 0 and x[i] - x[low] < LEAST_SPAN and gap[low - 1] < LARGEST_GAP:
            low -= 1
        while high < len(x) - 1 and x[high] - x[i] < LEAST_SPAN and gap[high] < LARGEST_GAP:
            high += 1
        if x[high] - x[low] >= LEAST_SPAN and fall[high] > fall[low]:
            found[order[i]] *= (told[high] - told[low]) / (fall[high] - fall[low])
    return found


def log_ratio(one: Array, other: Array) -> Array:
    """Logarithm of a ratio; zero where one of the numbers is zero, infinite or NaN."""
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.log(one / other)
    return np.where(np.isfinite(found), found, 0.0)


def interpolated_misfit(
    position: Array, anchors: Index, misfit: Array, floor: Array
) -> tuple[Array, Array]:
    """Misfit at all load points, interpolated between anchors, and a bound on its error, (n,) each.

    `position` holds the ascending logarithms of the loads, shape (n,). `anchors` (k,) are ascending
    indices of load points, the first and the last included, and `misfit` (k,) is the logarithm of
    model over boundary elements there. The bound is zero at anchors; elsewhere it is the largest of

    - half the difference of the misfits at the two anchors beside the point,
    - the error of the interpolation at either of these anchors if it is left out,
    - `floor` (n,).
    """
    missed = np.zeros(len(anchors))
    for j in range(1, len(anchors) - 1):
        beside = anchors[[j - 1, j + 1]]
        told = np.interp(position[anchors[j]], position[beside], misfit[[j - 1, j + 1]])
        missed[j] = abs(misfit[j] - told)
    right = np.clip(np.searchsorted(anchors, np.arange(len(position))), 1, len(anchors) - 1)
    bound = np.maximum(missed[right - 1], missed[right])
    bound = np.maximum(np.maximum(bound, 0.5 * np.abs(np.diff(misfit))[right - 1]), floor)
    bound[anchors] = 0.0
    return np.interp(position, position[anchors], misfit), bound


def halved_intervals(anchors: Index, need: Array) -> Index:
    """The anchors and one more, in the middle of the interval of the load point of largest `need`.

    `anchors` are ascending indices of load points, the first and the last included; `need`, shape
    (n,), is zero at anchors.
    """
    right = int(np.searchsorted(anchors, int(np.argmax(need))))
    return np.union1d(anchors, (anchors[right - 1] + anchors[right]) // 2)
