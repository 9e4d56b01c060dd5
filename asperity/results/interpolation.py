"""Values and slopes of a contact curve from its load points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.errors import InputError

__all__ = ["READ_FIELDS", "SLACK", "CurvePoint", "curve_stiffness", "read_off"]


READ_FIELDS = (
    "separation",
    "mean_pressure",
    "load",
    "area_fraction",
    "contact_area",
    "contacts",
    "stiffness",
)
"""Columns of a curve that can be read off between its points."""

SLACK = 5e-3
"""Relative distance beyond the ends at which a curve can be evaluated: solved pressures differ from
those asked for by the tolerance of the solve, and the latter must be within the curve."""


LEAST_SPAN = 0.25
"""Least distance in the logarithm of pressure of the points whose slope is taken."""

LARGEST_GAP = 2.5
"""Largest distance in the logarithm of pressure over which the tangents are integrated."""


@dataclass(frozen=True)
class CurvePoint:
    """A contact curve evaluated at one or several places; arrays have the shape of the argument.

    Attributes
    ----------
    separation, mean_pressure, load, area_fraction, contact_area, contacts, stiffness
        As in `ContactCurve`, interpolated between the converged load points.
    """

    separation: Any
    mean_pressure: Any
    load: Any
    area_fraction: Any
    contact_area: Any
    contacts: Any
    stiffness: Any


def read_off(
    columns: Mapping[str, NDArray[Any]],
    converged: NDArray[np.bool_],
    *,
    pressure: ArrayLike | None = None,
    separation: ArrayLike | None = None,
) -> CurvePoint:
    """Interpolate a curve, see `ContactCurve.at`.

    Parameters
    ----------
    columns
        The columns `READ_FIELDS` of the curve, shape (n,) each.
    converged
        Points that count, shape (n,).
    pressure, separation
        Where the curve is read: one of them [Pa], [m].
    """
    from scipy.interpolate import PchipInterpolator

    if (pressure is None) == (separation is None):
        raise InputError("give either pressure or separation to read the curve off")
    pressures, separations = columns["mean_pressure"], columns["separation"]
    usable = converged & (pressures > 0) & np.isfinite(separations)
    order = np.flatnonzero(usable)[np.argsort(pressures[usable])]
    order = order[np.diff(pressures[order], prepend=-1.0) > 0]
    lowest = np.minimum.accumulate(np.append(np.inf, separations[order]))[:-1]
    order = order[separations[order] < lowest]
    if len(order) < 2:
        raise InputError("the curve has fewer than two converged points with load")
    log_p = np.log(pressures[order])
    try:
        given: Any = separation if pressure is None else pressure
        asked: NDArray[np.float64] = np.ma.filled(np.ma.asarray(given, dtype=float), np.nan)
    except (TypeError, ValueError):
        raise InputError("the curve is read off at a number or an array of numbers") from None
    if pressure is not None:
        with np.errstate(divide="ignore", invalid="ignore"):
            key = np.log(asked)
        _within(asked, np.exp(log_p[[0, -1]]), key, log_p, SLACK, "pressure", "Pa")
    else:
        falling = separations[order][::-1]
        rim = 1e-9 * max(abs(falling[0]), abs(falling[-1]), falling[-1] - falling[0])
        _within(asked, falling[[0, -1]], asked, falling, rim, "separation", "m")
        key = PchipInterpolator(falling, log_p[::-1])(asked)

    def read(name: str, in_log: bool) -> Any:
        values = np.asarray(columns[name], dtype=float)[order]
        finite = np.isfinite(values) & ((values > 0) | (not in_log))
        if np.count_nonzero(finite) < 2:
            return np.full(np.shape(asked), np.nan)[()]
        knots = np.log(values[finite]) if in_log else values[finite]
        places = log_p[finite]
        found = PchipInterpolator(places, knots)(key)
        known = (key >= places[0] - SLACK) & (key <= places[-1] + SLACK)
        found = np.where(known, found, np.nan)
        return (np.exp(found) if in_log else found)[()]

    return CurvePoint(
        separation=read("separation", False) if separation is None else asked[()],
        mean_pressure=np.exp(key)[()],
        load=read("load", True),
        area_fraction=read("area_fraction", True),
        contact_area=read("contact_area", True),
        contacts=read("contacts", True),
        stiffness=read("stiffness", True),
    )


def _within(
    asked: NDArray[np.float64],
    ends: NDArray[np.float64],
    key: NDArray[np.float64],
    knots: NDArray[np.float64],
    slack: float,
    name: str,
    unit: str,
) -> None:
    outside = ~((key >= knots[0] - slack) & (key <= knots[-1] + slack))
    if np.any(outside):
        worst = float(np.atleast_1d(asked)[np.atleast_1d(outside)][0])
        raise InputError(
            f"{name} {worst:.4g} {unit} lies outside the converged curve, "
            f"{ends[0]:.4g} to {ends[1]:.4g} {unit}; add load points there"
        )


def curve_stiffness(
    pressure: NDArray[np.float64],
    separation: NDArray[np.float64],
    tangent: NDArray[np.float64],
    usable: NDArray[np.bool_],
) -> NDArray[np.float64]:
    """Minus the slope of pressure over separation at the points of a curve [Pa/m], shape (n,).

    Parameters
    ----------
    pressure, separation
        Points [Pa], [m], shape (n,), in any order.
    tangent
        Stiffness of each point at contacts that stay where they are and keep their shapes [Pa/m].
    usable
        Points that may be used (converged).

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
