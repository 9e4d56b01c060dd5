"""The contact curve: load, separation and contact area at a sequence of load points."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.errors import FileFormatError, InputError

from . import storage
from .interface_law import InterfaceLaw
from .interpolation import POINT_FIELDS, CurvePoint, curve_stiffness, read_off
from .storage import ResultFile, write_results
from .table import CurveTable, require_curve

__all__ = ["ContactCurve", "at_heaviest", "read_results"]

HEADLINE = (
    "mean_pressure",
    "load",
    "area_fraction",
    "separation",
    "mean_contact_pressure",
    "contacts",
    "error_estimate",
    "stiffness",
)
"""Columns of a curve whose values at the heaviest point that converged are told."""

OF_ONE_RUN = ("model", "law", "input", "boundary", "modulus", "m", "hardness")
"""Facts in which two runs must agree for one to continue the other."""


@dataclass(frozen=True, eq=False, repr=False)
class ContactCurve(CurveTable):
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
        Number of separate contact spots [-], shape (n,); pixels join by edges and corners.
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
        Everything needed to repeat the run, with digest and facts of the input map.
    extra
        Further arrays over the load points, by name.
    reasons
        One sentence for each load point that did not converge or was refused, else "". Its answers
        are NaN, in this object as in every output.
    version
        Version of the package that made the curve.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> curve = asperity.contact_curve(hm, steel, pressures=[1e8, 3e8, 1e9])
    >>> between = curve.at(pressure=5e8)
    >>> bool(curve.separation[1] > between.separation > curve.separation[2])
    True
    """

    def at(
        self,
        *,
        pressure: ArrayLike | None = None,
        load: ArrayLike | None = None,
        separation: ArrayLike | None = None,
        area_fraction: ArrayLike | None = None,
    ) -> CurvePoint:
        """Evaluate the curve at a mean pressure, a load, a separation or an area fraction.

        Parameters
        ----------
        pressure, load, separation, area_fraction
            One of them [Pa], [N], [m], [-], scalar or array, within the range of the converged
            points.

        Returns
        -------
        CurvePoint
            Values interpolated by monotone cubics in log pressure, scalar for a scalar question.
            Of points that came out in the wrong order, with a separation that does not fall, the
            heavier is left out, but in full contact; with a given area also if it does not rise.

        Raises
        ------
        InputError
            If not exactly one is given, the question lies outside the curve, or fewer than two
            converged points with load exist.
        """
        asked = {
            "pressure": pressure,
            "load": load,
            "separation": separation,
            "area_fraction": area_fraction,
        }
        return read_off(self.columns(), asked)

    def select(self, points: ArrayLike) -> ContactCurve:
        """The curve of some load points (indices or a mask), in that order; a verification counts
        those alone.

        Raises
        ------
        InputError
            If one of them is no load point.
        """
        try:
            chosen = np.asarray(points)
            index = np.atleast_1d(np.arange(len(self))[chosen if chosen.size else []])
            if index.ndim > 1:
                raise IndexError
        except (IndexError, ValueError):  # numbers of unequal rows make no array
            raise InputError(
                f"points are {points!r}; the load points are numbered 0 to {len(self) - 1}"
            ) from None
        found = dataclasses.replace(
            self,
            **{name: getattr(self, name)[index] for name in POINT_FIELDS},
            extra={name: np.asarray(values)[index] for name, values in self.extra.items()},
            reasons=tuple(self.reasons[i] for i in index),
        )
        told = self.settings.get("verification")
        if told is None:
            return found
        told = {**told, **verified_facts(found, *told["accuracy"])}
        return dataclasses.replace(found, settings={**self.settings, "verification": told})

    def joined(self, later: ContactCurve) -> ContactCurve:
        """This curve followed by the points of a later run of the same model; times add up.

        Where tangents are known, the stiffness is computed anew from all points. Columns that one
        run lacks, such as `interaction_difference`, are NaN at its points. Warnings of both runs
        are kept; a verification, which holds for the points of one run only, is dropped.

        Raises
        ------
        InputError
            If they are of two models, maps or bodies.
        """
        require_curve(later)
        own = {**self.settings, "model": self.model}
        require_facts(later, {name: own.get(name) for name in OF_ONE_RUN})
        columns: dict[str, Any] = {
            name: np.concatenate([getattr(self, name), getattr(later, name)])
            for name in POINT_FIELDS
        }
        both = self.extra, later.extra
        extra = {
            name: np.concatenate([_column(part, name, both) for part in (self, later)])
            for name in {**self.extra, **later.extra}
        }
        if "tangent_stiffness" in extra:
            columns["stiffness"] = curve_stiffness(
                columns["mean_pressure"],
                columns["separation"],
                extra["tangent_stiffness"],
                columns["converged"],
            )
        told = [part.settings.get("warnings", ()) for part in (self, later)]
        settings = {**later.settings, "warnings": list(dict.fromkeys([*told[0], *told[1]]))}
        settings.pop("verification", None)
        stages = dict.fromkeys([*self.seconds, *later.seconds])
        return dataclasses.replace(
            later,
            **columns,
            settings=settings,
            extra=extra,
            reasons=self.reasons + later.reasons,
            seconds={k: self.seconds.get(k, 0.0) + later.seconds.get(k, 0.0) for k in stages},
        )

    def to_hdf5(self, path: str | os.PathLike[str]) -> None:
        """Write the curve to a results file (schema "asperity/1"), replacing it at once."""
        write_results(path, ResultFile(curves={self.model: self}))

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
        held = storage.read_results(path, cls).curves
        if model is None and len(held) == 1:
            return next(iter(held.values()))
        if not isinstance(model, str) or model not in held:
            names = ", ".join(held) or "no curve"
            missing = "; name one (model=)" if model is None else f", and no curve {model!r}"
            raise FileFormatError(f"{path} holds {names}{missing if held else ''}")
        return held[model]

    def to_interface_law(self, **choices: Any) -> InterfaceLaw:
        """The law for finite elements, see `InterfaceLaw.of`, which takes the `conductance` too."""
        return InterfaceLaw.of(self, **choices)

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
        yielded = [self.extra[name] for name in ("plastic_share",) if name in self.extra]
        stages = ", ".join(f"{stage} {value:.2g}" for stage, value in self.seconds.items())
        lines = [
            f"contact curve   {self.model}, {len(self)} points, {good} converged",
            f"separation      {span(self.separation, ' m')}",
            f"mean pressure   {span(self.mean_pressure, ' Pa')}   load {span(self.load, ' N')}",
            f"area fraction   {span(self.area_fraction, '')}   contacts {span(self.contacts, '')}",
            f"contact mean    {span(self.mean_contact_pressure, ' Pa')}",
            *(f"plastic share   {span(share, '')} of the contact area" for share in yielded),
            f"error estimate  {span(self.error_estimate, '')}{area}",
            f"residual        {span(self.residual, '')}",
            f"seconds         {sum(self.seconds.values()):.3g} ({stages})",
        ]
        if self.verification is not None:
            lines += _verification_lines(self.settings.get("engine", self.model), self.verification)
        if alone is not None:
            lines.append(f"interaction     left out: load {span(100 * alone, ' %')} off by that")
        lines += [f"warning         {why}" for why in self.settings.get("warnings", ())]
        lines += [f"point {i}: {why}" for i, why in enumerate(self.reasons) if why]
        return "\n".join(lines)

    __repr__ = __str__


def require_facts(curve: ContactCurve, facts: Mapping[str, Any]) -> None:
    """Refuse a curve of another model, map or body than these facts tell."""
    told = {**curve.settings, "model": curve.model}
    for name, wanted in facts.items():
        if told.get(name) != wanted:
            raise InputError(
                f"a curve of {name} {told.get(name)!r} does not belong to one of {name} "
                f"{wanted!r}; give one of the same model, map and body"
            )


def verified_facts(curve: ContactCurve, load: float, area: float) -> dict[str, Any]:
    """Load points that boundary elements solved, and whether all converged with bounds within the
    accuracy asked for in load and area."""
    inside = (curve.error_estimate <= load) & (curve.extra["area_error_estimate"] <= area)
    anchors = np.flatnonzero(curve.extra["anchor"]).tolist()
    return {"met": bool(np.all(inside & curve.converged)), "anchors": anchors}


def _column(
    part: ContactCurve, name: str, both: Sequence[Mapping[str, NDArray[Any]]]
) -> NDArray[Any]:
    """A column of a part of a curve; empty texts or NaN, of the shape of the other part, if it has
    none."""
    if name in part.extra:
        return np.asarray(part.extra[name])
    like = next(np.asarray(extra[name]) for extra in both if name in extra)
    empty = "" if like.dtype.kind in "US" else np.nan
    return np.full((len(part), *like.shape[1:]), empty)


def _verification_lines(engine: str, verification: Mapping[str, Any]) -> list[str]:
    """Lines about engine, accuracy and resolution."""
    load, area = (f"{share:.2g}" for share in verification["accuracy"])
    met = "met" if verification["met"] else "NOT MET"
    left = verification["resolution_uncertainty"]
    open_ = (f"{100 * x:.2g} %" if x <= 1 else "all" if x > 1 else "unknown" for x in left)
    return [
        f"engine          {engine} ({verification['reason']})",
        f"accuracy        {load} in load, {area} in area: {met} on the "
        f"{verification['reference']}; points by boundary elements: {len(verification['anchors'])}",
        f"pixels leave    {' in load, '.join(open_)} in area open ({verification['resolution']})",
    ]


def read_results(path: str | os.PathLike[str]) -> ResultFile[ContactCurve]:
    """Read a results file: all its curves, tables and maps.

    Raises
    ------
    FileFormatError
        If it is absent, damaged, or of another schema.

    Examples
    --------
    >>> import tempfile
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> curve = asperity.contact_curve(hm, asperity.HalfSpace(210e9, 0.3), pressures=[1e8, 1e9])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     curve.to_hdf5(f"{folder}/results.h5")
    ...     list(asperity.read_results(f"{folder}/results.h5").curves)
    ['asperity']
    """
    return storage.read_results(path, ContactCurve)


def at_heaviest(curve: ContactCurve) -> dict[str, Any]:
    """Values at the heaviest load point that converged, whether all converged, and the reason of
    the first that did not."""
    heaviest = np.argmax(np.where(curve.converged, curve.mean_pressure, -np.inf))
    columns = curve.columns()
    return {
        **{name: columns[name][heaviest] for name in HEADLINE},
        "converged": bool(curve.converged.all()),
        "points": len(curve),
        "reason": next(filter(None, curve.reasons), ""),
    }
