"""Roughness of a map on a page: table of parameters, spectrum, bearing curve, autocorrelation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from bokeh.palettes import Cividis256

from surfaces.drawing import color_range, prefixed_unit, with_unit
from surfaces.heightmap import HeightMap
from surfaces.statistics.bearing import BearingCurve
from surfaces.statistics.correlation import Autocorrelation
from surfaces.statistics.describe import Statistics
from surfaces.statistics.spectrum import Spectrum
from surfaces.statistics.spectrum_fit import SpectrumFit

from .fields import SHOWN, Layer, map_figure, reduced, reduction
from .figures import Figure
from .lines import Line, line_figure

__all__ = [
    "BLUE",
    "ORANGE",
    "SIGNED",
    "bearing_figure",
    "correlation_figure",
    "height_layer",
    "map_facts",
    "parameters",
    "spectrum_figure",
    "spectrum_lines",
    "surface_figure",
]

BLUE, ORANGE = "#2f7fc1", "#d9622b"
"""Colors that stand out on white and on black, and apart for a reader who confuses hues."""

SIGNED = [f"{BLUE if i < 0 else ORANGE}{round(255 * abs(i) / 127):02x}" for i in range(-127, 128)]
"""Palette of fields with a sign: the more transparent, the nearer to nothing."""


def map_facts(hm: HeightMap) -> dict[str, str]:
    """Points, pixel, size and period, in words."""
    (ny, nx), (dy, dx), (length_y, length_x) = hm.shape, hm.spacing, hm.size
    lacking = f", {hm.missing} missing" if hm.missing else ""
    return {
        "points": f"{ny} × {nx} (y, x){lacking}",
        "pixel": f"{with_unit(dy, 'm')} × {with_unit(dx, 'm')}",
        "size": f"{with_unit(length_y, 'm')} × {with_unit(length_x, 'm')}",
        "periodic": "yes" if hm.periodic else "no",
    }


def parameters(found: Statistics) -> dict[str, str]:
    """Roughness parameters by name, with their units; those that are not known are left out."""
    rows = {}
    for row in found.rows():
        if row["value"] is None:
            continue
        value = float(row["value"]) + 0.0  # zero without a sign
        unit, _, power = str(row["unit"]).partition("^")
        text = f"{value:.4g} {str(row['unit']).strip('-').replace('^2', '²')}".rstrip()
        if unit == "m":
            text = with_unit(value, unit, int(power or 1), digits=4)
        rows[f"{row['parameter']}, {row['meaning']}"] = text
    if found.moments is not None:
        rows["rms slope, spectral"] = f"{found.moments.rms_slope:.4g}"
        rows["rms curvature, spectral"] = f"{found.moments.rms_curvature:.4g} 1/m"
        rows["Nayak parameter"] = f"{found.moments.nayak:.4g}"
        rows["largest over smallest rms slope"] = f"{found.moments.slope_ratio:.3g}"
    if found.fit is not None:
        rows["Hurst exponent"] = f"{found.fit.hurst:.3g} ± {found.fit.hurst_error:.1g}"
        rows["Hurst exponent"] += ", doubtful" if found.fit.warnings else ""
        for name, length in (("roll-off", found.fit.rolloff), ("cut-off", found.fit.cutoff)):
            if math.isfinite(length):
                rows[f"{name} wavelength"] = with_unit(length, "m")
    return rows


def height_layer(hm: HeightMap, most: int = SHOWN) -> Layer:
    """Heights about their mean, in colors of `color_range`."""
    shown = hm.heights - np.nanmean(hm.heights)
    factor, unit = prefixed_unit(float(np.nanmax(np.abs(shown))), "m")
    shown = reduced(shown / factor, most)
    return Layer("height", unit, shown, Cividis256, *color_range(shown))


def surface_figure(
    hm: HeightMap,
    *over: Layer,
    title: str = "Height map",
    keys: Sequence[tuple[str, str]] = (),
    most: int = SHOWN,
) -> Figure:
    """The map, with at most `most` points along a side, and what lies over it."""
    plot = map_figure([height_layer(hm, most), *over], hm.size)
    return Figure(plot, title, reduction(hm.shape, most), keys)


def spectrum_lines(
    spectrum: Spectrum, fit: SpectrumFit | None, *, label: str = "map", color: str = BLUE
) -> list[Line]:
    """Density of the rings over the wave number, and the fitted model."""
    seen = spectrum.seen
    lines = [_density(label, spectrum.q[seen], spectrum.density[seen], color=color, dash="")]
    if fit is not None:
        name = f"{label}: fit, H = {fit.hurst:.2f}{' (doubtful)' if fit.warnings else ''}"
        lines.append(_density(name, fit.q, fit.density, color=ORANGE, marker=""))
    return lines


def spectrum_figure(lines: list[Line]) -> Figure:
    """Power spectral density over the wave number."""
    return Figure(line_figure(lines, *SPECTRUM_COLUMNS[:2]), "Power spectrum")


SPECTRUM_COLUMNS = "wave number 2π/λ [rad/µm]", "power spectral density [m⁴]", "wavelength λ [µm]"


def _density(label: str, q: Any, density: Any, **looks: Any) -> Line:
    columns = dict(zip(SPECTRUM_COLUMNS, (1e-6 * q, density, 2e6 * np.pi / q), strict=True))
    return Line(label, columns, **looks)


def bearing_figure(curve: BearingCurve) -> Figure:
    """Height over material ratio, with the borders of the core."""
    factor, unit = prefixed_unit(float(np.abs(curve.height).max()), "m")
    thin = max(1, len(curve.height) // 500)
    x, y = "material ratio [%]", f"height [{unit}]"
    columns = {x: 100.0 * curve.ratio[::thin], y: curve.height[::thin] / factor}
    lines = [Line("bearing curve", columns, BLUE, marker="")]
    for name in ("Smr1", "Smr2"):
        ratio = curve.core()[name]
        core = {x: [100.0 * ratio], y: [curve.height_at(ratio) / factor]}
        lines.append(Line(name, core, ORANGE, dash=""))
    return Figure(line_figure(lines, x, y, linear="xy"), "Bearing curve")


def correlation_figure(correlation: Autocorrelation) -> Figure:
    """Correlation over shifts along y and x."""
    size = correlation.size
    layer = Layer("correlation", "", correlation.value[:], SIGNED, -1.0, 1.0)
    plot = map_figure([layer], size, origin=(-size[0] / 2, -size[1] / 2))
    plot.xaxis.axis_label = plot.xaxis.axis_label.replace("x", "shift along x")
    plot.yaxis.axis_label = plot.yaxis.axis_label.replace("y", "shift along y")
    return Figure(plot, "Autocorrelation", reduction(correlation.value.shape))
