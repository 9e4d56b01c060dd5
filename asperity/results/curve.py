"""The contact curve: load, separation and contact area at a sequence of load points."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity import __version__
from asperity.errors import InputError

__all__ = ["POINT_FIELDS", "ContactCurve", "CurvePoint", "require_curve"]

POINT_FIELDS = (
    "separation",
    "mean_pressure",
    "load",
    "area_fraction",
    "contact_area",
    "contacts",
    "stiffness",
    "converged",
    "residual",
    "error_estimate",
)


SLACK = 5e-3
"""Relative distance beyond the ends at which a curve can be evaluated: solved pressures differ from
those asked for by the tolerance of the solve, and the latter must be within the curve."""


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


@dataclass(frozen=True, eq=False)
class ContactCurve:
    """Load, separation and real contact area over a sequence of load points.

    Attributes
    ----------
    separation
        Distance of the rigid flat from the mean plane [m], shape (n,).
    mean_pressure
        Load over nominal area [Pa], shape (n,), compression positive.
    load
        Normal load [N], shape (n,).
    area_fraction
        Real contact area over nominal area [-], shape (n,).
    contact_area
        Real contact area [m^2], shape (n,).
    contacts
        Number of separate contact spots [-], shape (n,).
    stiffness
        Minus the slope of mean pressure over separation [Pa/m], shape (n,).
    converged
        Whether the point reached its tolerance, shape (n,).
    residual
        Relative residual of the solver at the point [-], shape (n,).
    error_estimate
        Expected relative error of the load at equal separation [-], shape (n,); NaN if unknown.
    model
        Name of the model.
    seconds
        Run time by stage [s].
    settings
        Everything needed to repeat the run, with the digest of the input map.
    extra
        Further arrays over the load points, by name.
    reasons
        One sentence for each load point that did not converge or was refused, else "".
    version
        Version of the package that made the curve.
    """

    separation: NDArray[np.float64]
    mean_pressure: NDArray[np.float64]
    load: NDArray[np.float64]
    area_fraction: NDArray[np.float64]
    contact_area: NDArray[np.float64]
    contacts: NDArray[np.int64]
    stiffness: NDArray[np.float64]
    converged: NDArray[np.bool_]
    residual: NDArray[np.float64]
    error_estimate: NDArray[np.float64]
    model: str
    seconds: Mapping[str, float] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)
    extra: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    reasons: tuple[str, ...] = ()
    version: str = __version__

    def __post_init__(self) -> None:
        n = np.size(self.separation)
        for name in POINT_FIELDS:
            array = np.atleast_1d(np.asarray(getattr(self, name)))
            if array.shape != (n,):
                raise InputError(f"{name} has shape {array.shape}; expected ({n},)")
            object.__setattr__(self, name, array)
        for name, values in self.extra.items():
            if np.shape(values)[:1] != (n,):
                raise InputError(
                    f"extra {name!r} has shape {np.shape(values)}; expected ({n}, ...)"
                )
        if not self.reasons:
            object.__setattr__(self, "reasons", ("",) * n)

    def __len__(self) -> int:
        return len(self.separation)

    def at(
        self, *, pressure: ArrayLike | None = None, separation: ArrayLike | None = None
    ) -> CurvePoint:
        """Evaluate the curve at a mean pressure or a separation.

        Parameters
        ----------
        pressure
            Mean pressure [Pa], scalar or array; within the range of the converged points.
        separation
            Separation [m], scalar or array; give this or `pressure`.

        Returns
        -------
        CurvePoint
            Values interpolated by monotone cubics in log pressure, scalar for a scalar question.
            Of points that came out in the wrong order, with a separation that does not fall, the
            heavier is left out.

        Raises
        ------
        InputError
            If neither or both are given, the question lies outside the curve, or fewer than two
            converged points with load exist.
        """
        from scipy.interpolate import PchipInterpolator

        if (pressure is None) == (separation is None):
            raise InputError("give either pressure or separation to read the curve off")
        usable = self.converged & (self.mean_pressure > 0) & np.isfinite(self.separation)
        order = np.flatnonzero(usable)[np.argsort(self.mean_pressure[usable])]
        order = order[np.diff(self.mean_pressure[order], prepend=-1.0) > 0]
        lowest = np.minimum.accumulate(np.append(np.inf, self.separation[order]))[:-1]
        order = order[self.separation[order] < lowest]
        if len(order) < 2:
            raise InputError("the curve has fewer than two converged points with load")
        log_p = np.log(self.mean_pressure[order])
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
            falling = self.separation[order][::-1]
            rim = 1e-9 * max(abs(falling[0]), abs(falling[-1]), falling[-1] - falling[0])
            _within(asked, falling[[0, -1]], asked, falling, rim, "separation", "m")
            key = PchipInterpolator(falling, log_p[::-1])(asked)

        def read(name: str, in_log: bool) -> Any:
            values = np.asarray(getattr(self, name), dtype=float)[order]
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

    def select(self, points: ArrayLike) -> ContactCurve:
        """The curve of some load points (indices or a mask), in that order.

        Raises
        ------
        InputError
            If one of them is no load point.
        """
        chosen = np.asarray(points)
        try:
            index = np.atleast_1d(np.arange(len(self))[chosen if chosen.size else []])
        except IndexError:
            raise InputError(
                f"points are {points!r}; the load points are numbered 0 to {len(self) - 1}"
            ) from None
        return dataclasses.replace(
            self,
            **{name: getattr(self, name)[index] for name in POINT_FIELDS},
            extra={name: np.asarray(values)[index] for name, values in self.extra.items()},
            reasons=tuple(self.reasons[i] for i in index),
        )

    def joined(self, later: ContactCurve) -> ContactCurve:
        """This curve followed by the points of a later run of the same model; times add up.

        Where tangents are known the stiffness is that of all points together. What one of the runs
        did not find out, such as the difference that interaction makes, is NaN at its points.
        """
        from .stiffness import curve_stiffness

        columns: dict[str, Any] = {
            name: np.concatenate([getattr(self, name), getattr(later, name)])
            for name in POINT_FIELDS
        }
        extra = {
            name: np.concatenate(
                [part.extra.get(name, np.full(len(part), np.nan)) for part in (self, later)]
            )
            for name in dict.fromkeys([*self.extra, *later.extra])
        }
        if "tangent_stiffness" in extra:
            columns["stiffness"] = curve_stiffness(
                columns["mean_pressure"],
                columns["separation"],
                extra["tangent_stiffness"],
                columns["converged"],
            )
        stages = dict.fromkeys([*self.seconds, *later.seconds])
        return dataclasses.replace(
            later,
            **columns,
            extra=extra,
            reasons=self.reasons + later.reasons,
            seconds={k: self.seconds.get(k, 0.0) + later.seconds.get(k, 0.0) for k in stages},
        )

    def to_hdf5(self, path: str | os.PathLike[str]) -> None:
        """Write the curve to a results file (schema "asperity/1"), replacing it at once."""
        from .storage import save_curves

        save_curves(path, {self.model: self})

    @classmethod
    def from_hdf5(cls, path: str | os.PathLike[str], model: str | None = None) -> ContactCurve:
        """Read a curve from a results file.

        Parameters
        ----------
        path
            Results file of schema "asperity/1".
        model
            Name of the curve; may be left out when the file holds one curve.

        Raises
        ------
        FileFormatError
            If the file is no results file or holds no such curve.
        """
        from .storage import load_curve

        return load_curve(path, model)

    def __str__(self) -> str:
        good = int(np.count_nonzero(self.converged))

        def span(values: NDArray[Any], unit: str) -> str:
            finite = np.asarray(values, dtype=float)[self.converged]
            finite = finite[np.isfinite(finite)]
            if not finite.size:
                return "unknown"
            return f"{finite.min():.3g} .. {finite.max():.3g}{unit}"

        stated = self.extra.get("area_error_estimate")
        area = "" if stated is None else f" in load, {span(stated, '')} in area"
        alone = self.extra.get("interaction_difference")
        lines = [
            f"contact curve   {self.model}, {len(self)} points, {good} converged",
            f"separation      {span(self.separation, ' m')}",
            f"mean pressure   {span(self.mean_pressure, ' Pa')}   load {span(self.load, ' N')}",
            f"area fraction   {span(self.area_fraction, '')}   contacts {span(self.contacts, '')}",
            f"error estimate  {span(self.error_estimate, '')}{area}",
            f"residual        {span(self.residual, '')}",
            f"seconds         {sum(self.seconds.values()):.3g} ("
            + ", ".join(f"{stage} {value:.2g}" for stage, value in self.seconds.items())
            + ")",
        ]
        if alone is not None:
            lines.append(f"interaction     left out: load {span(100 * alone, ' %')} off by that")
        lines += [f"warning         {why}" for why in self.settings.get("warnings", ())]
        lines += [f"point {i}: {why}" for i, why in enumerate(self.reasons) if why]
        return "\n".join(lines)

    __repr__ = __str__


def require_curve(curve: object) -> None:
    """Refuse what is no contact curve, such as the run that holds one.

    Raises
    ------
    InputError
        Saying what to give instead.
    """
    if not isinstance(curve, ContactCurve):
        raise InputError(
            f"a contact curve is needed, not {type(curve).__name__}: asperity.contact_curve(...), "
            "or run.curve of solve_contacts"
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
