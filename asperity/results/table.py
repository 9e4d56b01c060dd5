"""The table of a contact curve: its columns, as text, data frame, CSV, figure and notebook page."""

from __future__ import annotations

import html
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from asperity import __version__
from asperity.errors import InputError
from surfaces.arrays import Array, Mask
from surfaces.drawing import image, logarithmic
from surfaces.errors import as_choice, as_numbers, as_truth, shown

from .interpolation import POINT_FIELDS, contact_pressure
from .storage import flat_columns, write_csv

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

__all__ = ["CurveTable", "axis", "require_curve"]

HOW_SOLVED = (
    "asked_pressure",
    "asked_separation",
    "residual",
    "load_error",
    "complementarity",
    "penetration",
    "lift",
    "iterations",
    "fft_pairs",
    "seconds",
)
"""Columns that tell what was asked and how it was solved: a point that did not converge keeps them,
while its answers are NaN."""

AXES = {
    "separation": ("separation [µm]", 1e-6),
    "mean_pressure": ("mean pressure [MPa]", 1e6),
    "load": ("load [N]", 1.0),
    "area_fraction": ("real contact area [%]", 1e-2),
    "contact_area": ("real contact area [µm²]", 1e-12),
    "mean_contact_pressure": ("mean contact pressure [MPa]", 1e6),
    "contacts": ("contact spots", 1.0),
    "stiffness": ("stiffness [MPa/µm]", 1e12),
    "tangent_stiffness": ("tangent stiffness [MPa/µm]", 1e12),
    "unloading_stiffness": ("stiffness of unloading [MPa/µm]", 1e12),
    "asked_pressure": ("pressure asked for [MPa]", 1e6),
    "asked_separation": ("separation asked for [µm]", 1e-6),
    "error_estimate": ("error estimate of the load [%]", 1e-2),
    "area_error_estimate": ("error estimate of the area [%]", 1e-2),
}
"""Text of an axis, and its unit in SI units, by column."""

LOADS, AREAS = ("mean_pressure", "load"), ("area_fraction", "contact_area")

BANDS = {
    **{(name, "separation"): "error_estimate" for name in LOADS},
    **{(area, load): "area_error_estimate" for area in AREAS for load in LOADS},
}
"""Which error is stated of a column where another is given: that of the load at equal separation,
and that of the area at equal load."""

ROWS = 12
"""Rows of the table in a notebook."""


@dataclass(frozen=True, eq=False)
class CurveTable:
    """Columns over the load points of a contact curve; the attributes are those of
    `asperity.ContactCurve`."""

    separation: Array
    mean_pressure: Array
    load: Array
    area_fraction: Array
    contact_area: Array
    contacts: Array
    stiffness: Array
    converged: Mask
    residual: Array
    error_estimate: Array
    model: str
    seconds: Mapping[str, float] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)
    extra: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    reasons: tuple[str, ...] = ()
    version: str = __version__

    def __post_init__(self) -> None:
        n = np.size(self.separation)
        object.__setattr__(self, "reasons", tuple(self.reasons) or ("",) * n)
        if len(self.reasons) != n:
            raise InputError(f"reasons has shape ({len(self.reasons)},); expected ({n}, ...)")
        columns: dict[str, NDArray[Any]] = {"converged": np.array(self.converged, bool, ndmin=1)}
        for name in POINT_FIELDS:
            if name not in columns:
                column = as_numbers(name, getattr(self, name), finite=False)
                columns[name] = np.atleast_1d(column)
            if columns[name].shape != (n,):
                raise InputError(f"{name} has shape {columns[name].shape}; expected ({n},)")
        object.__setattr__(self, "converged", columns["converged"])
        for name, values in columns.items():
            object.__setattr__(self, name, self._held(name, values))
        extra = {name: np.array(values) for name, values in self.extra.items()}
        for name, values in extra.items():
            if values.shape[:1] != (n,):
                raise InputError(f"{name} has shape {values.shape}; expected ({n}, ...)")
            text = "" if name in AXES or name in HOW_SOLVED else " or texts"
            if values.dtype.kind not in ("biufcSU" if text else "biuf"):
                raise InputError(f"{name} is {shown(values)}; it must hold numbers{text}")
            extra[name] = self._held(name, values)
        object.__setattr__(self, "extra", extra)

    def __len__(self) -> int:
        return len(self.separation)

    def _held(self, name: str, values: NDArray[Any]) -> NDArray[Any]:
        """A column, read-only, with NaN for the answers of points that did not converge."""
        if not (name in HOW_SOLVED or values.dtype.kind not in "iuf" or self.converged.all()):
            lost = ~self.converged.reshape(-1, *(1,) * (values.ndim - 1))
            values = np.where(lost, np.nan, values)
        values.setflags(write=False)
        return values

    @property
    def mean_contact_pressure(self) -> Array:
        """Load over contact area [Pa], shape (n,); NaN where nothing touches."""
        return contact_pressure(self.load, self.contact_area)

    @property
    def asked(self) -> dict[str, Array]:
        """The load points as they were asked for, by name: "asked_pressure" [Pa] or
        "asked_separation" [m]; empty in curves of earlier versions."""
        return {name: part for name, part in self.extra.items() if name.startswith("asked_")}

    @property
    def verification(self) -> Mapping[str, Any] | None:
        """What `asperity.solve` tells of its answer: engine and reason, accuracy and whether it is
        met, anchors (load points that boundary elements solved), and the uncertainty of load and
        area that the pixels of the map leave; None of other curves."""
        return self.settings.get("verification")

    def columns(self, *, dimensionless: bool = False) -> dict[str, NDArray[Any]]:
        """Everything over the load points, in SI units, by name: the table of the curve.

        Parameters
        ----------
        dimensionless
            Also give separation over rms height, pressures over E* h', and stiffness times rms
            height over E* h', as columns with the ending ``_dimensionless`` (h' is the rms slope;
            of a graded half-space E* is that at the length over which the slope turns).

        Returns
        -------
        dict
            What was asked for, the fixed columns, `mean_contact_pressure`, `reason`, and what
            `extra` holds; arrays of shape (n,).

        Raises
        ------
        InputError
            If the curve does not know its map, as one of a file of an earlier version.
        """
        found: dict[str, Any] = {
            **self.asked,
            **{name: getattr(self, name) for name in POINT_FIELDS},
            "mean_contact_pressure": self.mean_contact_pressure,
            "reason": np.array(self.reasons, dtype=object),
        }
        found |= {name: part for name, part in self.extra.items() if name not in found}
        if as_truth("dimensionless", dimensionless):
            for name, scale in self._scales().items():
                found[f"{name}_dimensionless"] = found[name] / scale
        return dict(flat_columns(found))

    def _scales(self) -> dict[str, float]:
        """What makes columns dimensionless, by name."""
        try:
            height = self.settings["map"]["rms_height"]
            pressure = self.settings["pressure_scale"]
        except KeyError:
            raise InputError(
                "the curve does not hold the rms height and slope of its map, which dimensionless "
                "columns need; make it again with this version"
            ) from None
        return {
            "separation": height,
            "mean_pressure": pressure,
            "mean_contact_pressure": pressure,
            "stiffness": pressure / height,
        }

    def to_dataframe(self, *, dimensionless: bool = False) -> pandas.DataFrame:
        """The table of the curve as a pandas frame, a row per load point, see `columns`.

        Its ``attrs`` hold model, version and settings.

        Examples
        --------
        >>> import asperity, surfaces
        >>> hm = surfaces.self_affine(
        ...     (32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6
        ... )
        >>> steel = asperity.HalfSpace(210e9, 0.3)
        >>> frame = asperity.contact_curve(hm, steel, pressures=[1e8, 1e9]).to_dataframe()
        >>> bool((frame.mean_contact_pressure > frame.mean_pressure).all())
        True
        """
        import pandas

        frame = pandas.DataFrame(self.columns(dimensionless=dimensionless))
        frame.attrs = {name: getattr(self, name) for name in ("model", "version", "settings")}
        return frame

    def to_csv(self, path: str | os.PathLike[str], *, dimensionless: bool = False) -> None:
        """Write the table of the curve with a header line, see `columns`; NaN is left empty."""
        write_csv(path, self.columns(dimensionless=dimensionless))

    def plot(
        self,
        x: str = "mean_pressure",
        y: str = "area_fraction",
        ax: Axes | None = None,
        *,
        band: bool = True,
        **style: Any,
    ) -> Axes:
        """Draw one column over another.

        Parameters
        ----------
        x, y
            Names of columns, see `columns`. Lengths are drawn in µm, pressures in MPa; an axis that
            spans more than a decade is logarithmic.
        ax
            Axes to draw on; new ones if None.
        band
            Draw the stated error: of the load over the separation, of the area over the load.
        style
            Further arguments of `matplotlib.axes.Axes.plot`.

        Returns
        -------
        Axes
            Points that did not converge are left out, with a gap in the line.

        Raises
        ------
        InputError
            If there is no such column of numbers.

        Examples
        --------
        >>> import asperity, surfaces
        >>> hm = surfaces.self_affine(
        ...     (32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6
        ... )
        >>> steel = asperity.HalfSpace(210e9, 0.3)
        >>> curve = asperity.contact_curve(hm, steel, pressures=[1e8, 3e8, 1e9])
        >>> curve.plot("separation", "mean_pressure").get_xlabel()
        'separation [µm]'
        """
        held = self.columns()
        numbers = [name for name, part in held.items() if part.dtype.kind in "biuf"]
        as_choice("x", x, numbers)
        as_choice("y", y, numbers)
        as_truth("band", band)
        if ax is None:
            from matplotlib import pyplot

            ax = pyplot.subplots(layout="constrained")[1]
        order = np.argsort(self._light_to_heavy(), kind="stable")
        across, up = (held[name].astype(float)[order] / axis(name)[1] for name in (x, y))
        look: dict[str, Any] = {"marker": "o", "markersize": 4, "label": self.model} | style
        (line,) = ax.plot(across, up, **look)
        for at, (low, high), least in (
            ("x", ax.dataLim.intervalx, ax.dataLim.minposx),
            ("y", ax.dataLim.intervaly, ax.dataLim.minposy),
        ):  # of all that the axes hold
            if logarithmic(np.array([low, least, high])):
                ax.set(**{f"{at}scale": "log"})
            elif low < 0.0:
                ax.set(**{f"{at}scale": "linear"})
        shade: dict[str, Any] = {"color": line.get_color(), "alpha": 0.2, "linewidth": 0}
        for draw, given, told in ((ax.fill_between, x, y), (ax.fill_betweenx, y, x)):
            if band and (stated := BANDS.get((told, given))) in held:
                off = np.where(np.isfinite(held[stated]), held[stated], np.nan)[order]
                place, value = (across, up) if told == y else (up, across)
                draw(place, value * np.maximum(1 - off, 0), value * (1 + off), **shade)
        ax.set(xlabel=axis(x)[0], ylabel=axis(y)[0])
        return ax

    def _light_to_heavy(self) -> Array:
        """What orders the load points from light to heavy: what was asked for, if it is of one
        kind."""
        if len(self.asked) != 1:
            return self.mean_pressure
        ((name, values),) = self.asked.items()
        return -values if name == "asked_separation" else values

    def _repr_html_(self) -> str:
        """Table and figure for a notebook."""
        from matplotlib.figure import Figure

        held = self.columns()
        names = [name for name in AXES if name in held and name != "contact_area"]
        shown = np.unique(np.linspace(0, len(self) - 1, min(len(self), ROWS)).astype(int))
        head = "".join(f"<th>{AXES[name][0]}</th>" for name in names)
        rows = ""
        for i in shown:
            cells = "".join(f"<td>{held[name][i] / AXES[name][1]:.4g}</td>" for name in names)
            rows += f"<tr>{cells}<td>{html.escape(self.reasons[i])}</td></tr>"
        good, part = np.count_nonzero(self.converged), f", {len(shown)} shown"
        part = part if len(shown) < len(self) else ""
        told = f"contact curve <b>{html.escape(self.model)}</b>, {len(self)} points{part}"
        notes = "".join(f"<br>{html.escape(why)}" for why in self.settings.get("warnings", ()))
        picture = ""
        if good:
            figure = Figure(figsize=(8.4, 3.2), layout="constrained")
            left, right = figure.subplots(1, 2)
            self.plot("separation", "mean_pressure", left)
            self.plot(ax=right)
            picture = image(figure)
        return (
            f"<div><p>{told}, {good} converged{notes}</p><table><thead><tr>{head}<th></th></tr>"
            f"</thead><tbody>{rows}</tbody></table>{picture}</div>"
        )


def axis(name: str) -> tuple[str, float]:
    """Text and unit of the axis of a column."""
    return AXES.get(name, (name.replace("_", " "), 1.0))


def require_curve(curve: object) -> None:
    """Refuse what is no contact curve, such as the run that holds one, and say what to give
    instead."""
    if not isinstance(curve, CurveTable):
        raise InputError(
            f"a contact curve is needed, not {type(curve).__name__}: asperity.contact_curve(...), "
            "or run.curve of solve_contacts"
        )
