"""The two curves of a report, with the stated band, and error against run time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asperity.results.curve import ContactCurve
from surfaces.arrays import Array
from surfaces.drawing import prefixed_unit
from surfaces.page.figures import Figure
from surfaces.page.lines import Line, line_figure
from surfaces.page.roughness import BLUE, ORANGE

from .sample import Sample

__all__ = [
    "BEM",
    "MODEL",
    "curve_figures",
    "pareto_figure",
    "sample_colors",
    "stated_area_error",
    "typical",
]

MODEL, BEM, OTHER = ORANGE, BLUE, "#8a939c"
"""Colors of the microcontact model, of boundary elements and of what is neither."""

SAMPLES = (
    *(MODEL, BEM, "#2a9d6f", "#b565a7", "#c8960c"),
    *("#7d8791", "#40b5c4", "#8c564b", "#e377c2", "#5f7f2f"),
)
"""Colors of samples side by side."""

ALL_CURVES = 3
"""Samples up to which all curves of each are drawn; of more the first one."""

AREA = "real contact area [%]"

BAND_FLOOR = 1e-3
"""Lower end of a band, over the value, where the stated error is more than all of it."""


def sample_colors(count: int) -> list[str]:
    """Colors that tell samples apart."""
    return [SAMPLES[i % len(SAMPLES)] for i in range(count)]


def curve_figures(samples: Sequence[Sample]) -> list[Figure]:
    """Mean pressure over separation and contact area over mean pressure, of all samples."""
    drawn = _drawn(samples)
    apart = np.concatenate([curve.separation for curve, _ in drawn])
    loads = np.concatenate([curve.mean_pressure for curve, _ in drawn])
    length, length_unit = prefixed_unit(typical(apart), "m")
    stress, stress_unit = prefixed_unit(typical(loads), "Pa")
    separation, pressure = f"separation [{length_unit}]", f"mean pressure [{stress_unit}]"
    scales = {separation: length, pressure: stress}
    note = "The shaded band is the error that the curve states of itself."
    if len(samples) > ALL_CURVES:
        note += " Of each sample the first curve is drawn."
    found = []
    for what, title, axes, linear in (
        ("load", "Load against separation", (separation, pressure), "x"),
        ("area", "Real contact area against load", (pressure, AREA), ""),
    ):
        lines = [_curve_line(curve, looks, scales, what) for curve, looks in drawn]
        banded = any(line.band for line in lines)
        plot = line_figure(lines, *axes, linear=linear)
        found.append(Figure(plot, title, note if banded else ""))
    return found


def stated_area_error(curve: ContactCurve) -> Array:
    """Error of the area that a curve states, NaN where it states none."""
    stated = curve.extra.get("area_error_estimate", np.full(len(curve), np.nan))
    return np.asarray(stated, dtype=np.float64)


def pareto_figure(pareto: NDArray[np.void]) -> Figure:
    """Error of every run against its run time."""
    seconds, error = "run time [s]", "rms error [%]"
    lines = []
    for model, name, color in (
        ("asperity", "microcontacts", MODEL),
        ("bem", "boundary elements", BEM),
    ):
        for column, what, marker in (
            ("load_error", "load", "circle"),
            ("area_error", "area", "diamond"),
        ):
            rows = pareto[(pareto["model"] == model) & (pareto[column] > 0)]
            columns = {
                seconds: rows["seconds"],
                error: 100 * rows[column],
                "points along y": rows["ny"],
                "points along x": rows["nx"],
                "tolerance": rows["tolerance"],
            }
            lines.append(Line(f"{name}, {what}", columns, color, marker=marker, dash=""))
    return Figure(
        line_figure(lines, seconds, error),
        "Error against run time",
        "Load at equal separation and area at equal load, over all load points, against boundary "
        "elements on the map's own grid at a tight tolerance. Run times include set-up and all "
        "load points; compilation is done before.",
    )


def _curve_line(
    curve: ContactCurve, looks: Mapping[str, Any], scales: Mapping[str, float], what: str
) -> Line:
    """A curve as a line of the figure of its "load" or of its "area", with the band of it."""
    names = ("separation", "mean_pressure")
    columns: dict[str, Any] = {
        axis: getattr(curve, name) / scale
        for name, (axis, scale) in zip(names, scales.items(), strict=True)
    }
    columns[AREA] = 100 * curve.area_fraction
    columns["contacts"] = curve.contacts
    values, stated = columns[list(scales)[1]], curve.error_estimate
    if what == "area":
        values, stated = columns[AREA], stated_area_error(curve)
    known = np.isfinite(stated)
    if not known.any() or looks["dash"] != "solid":
        return Line(columns=columns, **looks)
    share = np.where(known, stated, 0.0)
    band = f"stated {what}, low", f"stated {what}, high"
    columns[band[0]] = values * np.maximum(1.0 - share, BAND_FLOOR)
    columns[band[1]] = values * (1.0 + share)
    return Line(columns=columns, band=band, **looks)


def _drawn(samples: Sequence[Sample]) -> list[tuple[ContactCurve, dict[str, Any]]]:
    """The curves that are drawn, with label, color, marker and dash: of one sample the colors tell
    the models apart, of several the samples."""
    found, alone = [], len(samples) == 1
    most = None if len(samples) <= ALL_CURVES else 1
    for one, color in zip(samples, sample_colors(len(samples)), strict=True):
        for i, (name, curve) in enumerate([*one.curves.items()][:most]):
            own = BEM if "boundary" in name else MODEL if i == 0 else OTHER
            looks = {
                "label": name if alone else f"{one.name}: {name}",
                "color": own if alone else color,
                "marker": "circle" if i == 0 else "diamond" if "boundary" in name else "dot",
                "dash": "solid" if i == 0 else "dashed",
            }
            found.append((curve, looks))
    return found


def typical(values: Array) -> float:
    """Geometric mean of the magnitudes, by which a unit is chosen."""
    sizes = np.abs(values[np.isfinite(values) & (values != 0.0)])
    return float(np.exp(np.mean(np.log(sizes)))) if sizes.size else 1.0
