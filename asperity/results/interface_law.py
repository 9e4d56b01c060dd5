"""The contact curve as a law of an interface in finite and discrete elements."""

from __future__ import annotations

import itertools
import math
import os
import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from asperity.errors import FileFormatError, InputError, cautious, warn_once
from surfaces.arrays import Array
from surfaces.errors import as_choice, as_numbers, as_path
from surfaces.files.atomic import replacing

from .interpolation import knots_of, read_off
from .table import CurveTable, require_curve

__all__ = ["BANDS", "FORMATS", "UNITS", "InterfaceLaw", "warn_of_free_punch"]

FORMATS = ("abaqus", "calculix", "moose")
BANDS = ("pressure", "lower", "upper")

UNITS = {"SI": (1.0, 1.0, 1.0), "mm-N-MPa": (1e3, 1e-6, 1e-3)}
"""Length, pressure and thermal conductance per area of one m, Pa, W/(m^2 K) in each system."""

_ROWS = 200
"""Rows of a law. Equal steps of the cube root of a pressure that rises exponentially keep the work
best: straight lines between n rows are off by ``2.25 / n**2`` of it."""

_CALCULIX_ROWS = 90
"""Rows for CalculiX, whose node-to-surface contact follows so many."""

_LEAST_SHARE = 0.01
"""Share of the compliance of a free map that is not worth a warning."""

_CALCULIX_NOTE = (
    "for *CONTACT PAIR, TYPE=NODE TO SURFACE; surface-to-surface contact of CalculiX 2.20 does not "
    "follow tables"
)


@dataclass(frozen=True, eq=False)
class InterfaceLaw:
    """Mean pressure against overclosure, straight lines between the rows.

    Attributes
    ----------
    overclosure
        Approach from the reference plane [m], from 0 on, increasing, shape (n,).
    pressure
        Mean pressure [Pa], from 0 on, increasing, shape (n,).
    lower, upper
        Band of the pressure by the stated error of the load [Pa], shape (n,); NaN if unknown.
    stiffness
        Stiffness of the curve [Pa/m], shape (n,); NaN if unknown.
    conductance
        Thermal conductance per nominal area [W/(m^2 K)], shape (n,); NaN if unknown.
    reference
        Separation from the mean plane of the undeformed surface [m] at overclosure 0.
    hardness
        Hardness [Pa] of the curve, infinite without one: with one the law is of first loading.

    Examples
    --------
    >>> import tempfile
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3, hardness=2e9)
    >>> curve = asperity.contact_curve(hm, steel, pressures=[1e7, 3e7, 1e8])
    >>> law = curve.to_interface_law()
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     law.write(f"{folder}/law.inp", "abaqus", units="mm-N-MPa")
    ...     back = asperity.InterfaceLaw.read(f"{folder}/law.inp")
    >>> f"{back.work / law.work:.6f}"
    '1.000000'
    """

    overclosure: Array
    pressure: Array
    lower: Array
    upper: Array
    stiffness: Array
    conductance: Array
    reference: float
    hardness: float = math.inf

    @classmethod
    @cautious
    def of(cls, curve: CurveTable, *, conductance: ArrayLike | None = None) -> InterfaceLaw:
        """The law of a curve, see `ContactCurve.to_interface_law`.

        Parameters
        ----------
        curve
            The curve.
        conductance
            Thermal conductance at each load point [W/(m^2 K)], see `constriction_conductance`.
            Where it is infinite, in full contact, the law has none.

        Raises
        ------
        InputError
            If it is no curve, or has fewer than two converged points with load, or the conductance
            not one number for each of its points.

        Notes
        -----
        Rows lie on the monotone interpolation of the curve, in equal steps of the cube root. Below
        the lightest load the law runs to zero in a straight line with the stiffness there: where
        this line ends is overclosure 0. The separations of a free map hold the sinking of the
        half-space under the whole map, which a meshed body adds again: a warning says how much.
        """
        require_curve(curve)
        warn_of_free_punch(curve, curve.stiffness, "compliance")
        columns, loads = curve.columns(), curve.mean_pressure
        knots = knots_of(columns)
        usable = loads[knots]
        if usable.size < 2:
            raise InputError("the curve has fewer than two converged points with load")
        heat = np.full(loads.shape, np.nan)
        if conductance is not None:
            heat = as_numbers("conductance", conductance, finite=False)
            if heat.shape != loads.shape:
                raise InputError(
                    f"conductance has shape {heat.shape}; give one number for each of the "
                    f"{loads.size} load points"
                )
            under_load = heat[loads > 0.0]
            if not (np.isnan(under_load) | (under_load > 0.0)).all():
                raise InputError(
                    "a conductance under load is not positive; give none (NaN) where it is unknown"
                )
        low, high = usable.min(), usable.max()
        pressure = np.linspace(low ** (1 / 3), high ** (1 / 3), _ROWS - 1) ** 3
        columns = {name: part[knots] for name, part in columns.items()}
        point = read_off(columns, {"pressure": pressure})
        # the conductance is read off as the stiffness is, in its logarithm
        heat = read_off({**columns, "stiffness": heat[knots]}, {"pressure": pressure}).stiffness
        first = -np.diff(point.separation[:2])[0] / np.diff(pressure[:2])[0]
        run_in = low / point.stiffness[0] if np.isfinite(point.stiffness[0]) else low * first
        reference = float(point.separation[0] + run_in)
        hardness = float(curve.settings.get("hardness", math.inf))
        error = np.where(np.isfinite(point.error_estimate), point.error_estimate, np.nan)
        lower = pressure * np.maximum(1.0 - error, 0.0)
        upper = np.minimum(pressure * (1.0 + error), hardness)
        if not np.isnan(lower).all():  # the pressure rises: it lies between bounds stated elsewhere
            below, above = np.fmax.accumulate(lower), np.fmin.accumulate(upper[::-1])[::-1]
            lower = np.where(np.isnan(lower), np.fmax(below, 0.0), lower)
            upper = np.where(np.isnan(upper), above, upper)
        lower = np.minimum(_strictly_rising(lower, high), pressure)
        most = float(np.fmax.reduce(upper, initial=high))
        upper = np.maximum(_strictly_rising(np.maximum.accumulate(upper), most), pressure)
        return cls(
            overclosure=np.insert(reference - point.separation, 0, 0.0),
            pressure=np.insert(pressure, 0, 0.0),
            lower=np.insert(lower, 0, 0.0),
            upper=np.insert(upper, 0, 0.0),
            stiffness=np.insert(point.stiffness, 0, point.stiffness[0]),
            conductance=np.insert(heat, 0, np.nan if conductance is None else 0.0),
            reference=reference,
            hardness=hardness,
        )

    @property
    def work(self) -> float:
        """Work per nominal area from overclosure 0 up to the heaviest load [J/m^2]."""
        return float(np.trapezoid(self.pressure, self.overclosure))

    def write(
        self,
        path: str | os.PathLike[str],
        format: str = "abaqus",
        *,
        units: str = "SI",
        band: str = "pressure",
    ) -> None:
        """Write the law for another program.

        Parameters
        ----------
        path
            File to write; one that stands there is replaced.
        format
            ``abaqus`` or ``calculix``: keywords below a ``*SURFACE INTERACTION``; ``moose``: CSV.
        units
            ``SI`` or ``mm-N-MPa``.
        band
            ``pressure``, or the ``lower`` or ``upper`` end of its band.

        Raises
        ------
        InputError
            If a choice is unknown, the band is not known, or the file cannot be written.
        """
        as_choice("format", format, FORMATS)
        as_choice("units", units, UNITS)
        as_choice("band", band, BANDS)
        most = _CALCULIX_ROWS if format == "calculix" else _ROWS
        count = len(self.pressure)
        rows = np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))
        table = {name: getattr(self, name)[rows] * scale for name, scale in _scales(units).items()}
        table["pressure"] = table[band]
        if np.isnan(table[band]).any():
            raise InputError(f"the curve states no error: its law has no {band} band")
        mark = "# " if format == "moose" else "** "
        lines = [mark + text for text in self._heading(units, band, len(rows))]
        lines += [mark + _CALCULIX_NOTE] if format == "calculix" else []
        if format == "moose":
            lines.append(",".join(table))
            cells = zip(*table.values(), strict=True)
            lines += [",".join(f"{value:.10g}" for value in row) for row in cells]
        else:
            lines.append("*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR")
            lines += _pairs(table["pressure"], table["overclosure"])
            known = np.isfinite(table["conductance"])
            if known[1:].any():
                lines.append("*GAP CONDUCTANCE" + (", PRESSURE" if format == "abaqus" else ""))
                lines += _pairs(table["conductance"][known], table["pressure"][known])
        with replacing(path) as part:
            part.write_text("\n".join(lines) + "\n")

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> InterfaceLaw:
        """Read what `write` wrote; of keyword files what they do not hold is NaN.

        Raises
        ------
        FileFormatError
            If the file is no such law.
        """
        try:
            text = as_path(path).read_text(errors="replace")
        except OSError as error:
            raise FileFormatError(f"{path}: cannot be read ({error.strerror})") from error
        head = re.search(r"units (\S+), reference (\S+) m, hardness (\S+) Pa, rows (\d+)", text)
        lines = [line for line in text.splitlines() if not line.startswith(("**", "#"))]
        try:
            if head is None:
                raise ValueError("its first lines lack units, reference and the number of rows")
            scales = _scales(head[1])
            if lines[0].startswith("*"):
                ends = [i for i, line in enumerate(lines) if line.startswith("*")] + [len(lines)]
                parts = [
                    np.loadtxt(lines[i + 1 : j], delimiter=",") for i, j in itertools.pairwise(ends)
                ]
                nan = np.full(len(parts[0]), np.nan)
                heat = nan.copy()
                if len(parts) > 1:
                    heat[np.isin(parts[0][:, 0], parts[1][:, 1])] = parts[1][:, 0]
                found = [parts[0][:, 1], parts[0][:, 0], nan, nan, nan, heat]
            else:
                found = list(np.loadtxt(lines[1:], delimiter=",", unpack=True))
            rising = (np.diff(found[:2], axis=1) > 0.0).all()
            if len(found[0]) != int(head[4]) or not (text.endswith("\n") and rising):
                raise ValueError("rows are missing, cut off or do not rise")
            columns = {
                name: column / scales[name] for name, column in zip(scales, found, strict=True)
            }
            return cls(**columns, reference=float(head[2]), hardness=float(head[3]))
        except (ValueError, KeyError, IndexError) as error:
            raise FileFormatError(f"{path} is no interface law: {error}") from error

    def _heading(self, units: str, band: str, rows: int) -> list[str]:
        return [
            f"Interface law of asperity: mean pressure ({band}) against overclosure",
            f"units {units}, reference {self.reference:.10g} m, hardness {self.hardness:.10g} Pa, "
            f"rows {rows}",
            f"overclosure 0: the flat is {self.reference:.6g} m above the mean plane of the "
            "undeformed surface",
            f"the mean plane itself is at overclosure {self.reference:.6g} m",
            "first loading; unloading with a hardness follows another path"
            if self.hardness < math.inf
            else "elastic: loading and unloading alike",
        ]

    def __str__(self) -> str:
        return (
            f"interface law   {len(self.pressure)} rows to {self.pressure[-1]:.4g} Pa at "
            f"{self.overclosure[-1]:.4g} m, work {self.work:.4g} J/m^2\n"
            f"overclosure 0   {self.reference:.4g} m above the mean plane"
        )

    __repr__ = __str__


def warn_of_free_punch(curve: CurveTable, stiffness: Array, what: str) -> None:
    """Warn of what the half-space under the whole of a free map adds to that of the interface.

    The map sinks as a flat round punch of its area, by 2 E* a^(1+m) / (1+m) (`HalfSpace`).
    """
    known = curve.converged & (curve.mean_pressure > 0.0) & np.isfinite(stiffness)
    free = curve.settings.get("boundary") == "free" and "modulus" in curve.settings
    if not (free and known.any()):
        return
    heaviest = np.argmax(np.where(known, curve.mean_pressure, 0.0))
    area = curve.load[heaviest] / curve.mean_pressure[heaviest]
    order = 1.0 + curve.settings.get("m", 0.0)
    whole = 2.0 * curve.settings["modulus"] * (area / np.pi) ** (0.5 * order) / (order * area)
    share = min(stiffness[heaviest] / whole, 1.0)
    if share > _LEAST_SHARE:
        warn_once(
            [
                f"the map is a free punch: {100 * share:.0f}% of its {what} at the heaviest load "
                "is that of the half-space under the whole map, which a meshed body adds again; "
                "for the interface alone make the map periodic (prepare, --periodic)"
            ]
        )


def _scales(units: str) -> dict[str, float]:
    """The columns of a file in their order, and what one SI unit of each is in its units."""
    length, stress, thermal = UNITS[units]
    forces = dict.fromkeys(("pressure", "lower", "upper"), stress)
    return {"overclosure": length, **forces, "stiffness": stress / length, "conductance": thermal}


def _strictly_rising(pressure: Array, high: float) -> Array:
    """Pressures of which each exceeds the one before, as programs ask for, if by next to nothing
    of a pressure `high`, none below it, which ten digits show: a band may be zero, or stay at the
    hardness, over many rows."""
    steps = 1e-9 * high * np.arange(1, pressure.size + 1)
    low = np.minimum.accumulate(pressure[::-1])[::-1]
    return np.asarray(low * (1.0 - 1e-9 * (pressure.size + 1)) + steps)


def _pairs(first: Array, second: Array) -> list[str]:
    return [f"{a:.10g}, {b:.10g}" for a, b in zip(first, second, strict=True)]
