"""Where the bodies touch: pressures, contacts and their sizes in both models."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from bokeh.palettes import Plasma256
from numpy.typing import NDArray

from asperity.comparison.record import ComparisonRecord
from surfaces.arrays import Mask
from surfaces.drawing import prefixed_unit
from surfaces.heightmap import HeightMap
from surfaces.page.fields import Layer, map_figure, reduced, reduction, touched
from surfaces.page.figures import Figure
from surfaces.page.lines import Line, line_figure
from surfaces.page.roughness import SIGNED, surface_figure
from surfaces.patches import label_patches

from .curves import BEM, MODEL
from .tables import load_of_maps, size_of

__all__ = ["contact_figures", "height_figure", "size_figure"]

BOTH, MARK = "#7d8790", "#ff2d6f"
"""Colors of contact in both models, and of contact on the heights."""

COLORED_SHARE = 0.99
"""Share of the pixels in contact whose pressures the colors tell apart."""

DRAWN = 400
"""Points of a line of contact sizes."""


def height_figure(surface: HeightMap, comparison: ComparisonRecord, most: int) -> Figure:
    """The map with the contacts of boundary elements, at most `most` points along a side."""
    mask = touched(comparison.maps["bem"], most)
    over = Layer("contact", "", mask, [MARK], 0.5, 1.5, explained=False)
    title = f"Height map, contacts at {load_of_maps(comparison)}"
    return surface_figure(
        surface,
        over,
        title=title,
        keys=[(MARK, "in contact (boundary elements)")],
        most=most,
    )


def contact_figures(comparison: ComparisonRecord) -> list[Figure]:
    """Pressures of both models, their difference and the contacts, zoomed together."""
    size = size_of(comparison.about)
    maps, note = comparison.maps, reduction(comparison.maps["bem"].shape)
    pressures = [maps[name] for name in ("pressure_bem", "pressure_asperity") if name in maps]
    if len(pressures) < 2:
        return [contacts_figure(comparison, size, note)]
    top = _upper(pressures[0])
    factor, unit = prefixed_unit(top, "Pa")
    shown = [reduced(one / np.float32(factor)) for one in pressures]
    bem, model = (np.where(one > 0, one, np.nan) for one in shown)
    apart = np.where(shown[0] + shown[1] > 0, shown[1] - shown[0], np.nan)
    high, off = top / factor, _upper(np.abs(apart))
    layers = {
        "Pressure, boundary elements": Layer("pressure", unit, bem, Plasma256, 0.0, high),
        "Pressure, microcontacts": Layer("pressure", unit, model, Plasma256, 0.0, high),
        "Pressure, microcontacts less boundary elements": Layer(
            "difference", unit, apart, SIGNED, -off, off
        ),
    }
    found: list[Figure] = []
    for title, layer in layers.items():
        plot = map_figure([layer], size, along=found[0].plot if found else None)
        ends = f"Colors end at {layer.high:.3g} {unit}."
        found.append(Figure(plot, title, " ".join(filter(None, (ends, note)))))
    return [*found, contacts_figure(comparison, size, note, along=found[0].plot)]


def _upper(values: NDArray[Any]) -> float:
    """Value below which the colors tell those of `COLORED_SHARE` of the pixels in contact apart."""
    seen = values[values > 0]
    return float(np.quantile(seen, COLORED_SHARE)) if seen.size else 1.0


def contacts_figure(
    comparison: ComparisonRecord, size: tuple[float, float], note: str, along: Any = None
) -> Figure:
    """Contact in either model and in both."""
    bem, model = (touched(comparison.maps[name]) for name in ("bem", "asperity"))
    layer = Layer("contact", "", bem + 2 * model, [BEM, MODEL, BOTH], 0.5, 3.5, explained=False)
    told_overlap = (
        f"They share {100 * comparison.overlap:.3g} % of what either touches."
        if np.isfinite(comparison.overlap)
        else "The microcontact model did not converge at this load."
    )
    keys = [(BOTH, "both"), (BEM, "boundary elements only"), (MODEL, "microcontacts only")]
    note = " ".join(filter(None, (told_overlap, note)))
    return Figure(map_figure([layer], size, along=along), "Contact", note, keys)


def size_figure(named: Sequence[tuple[str, str, Mask, ComparisonRecord]]) -> Figure | None:
    """Contacts at least as large as an area, of contact maps with their names and colors."""
    found = []
    for name, color, mask, comparison in named:
        periodic = bool(comparison.about.get("periodic"))
        pixels = np.bincount(label_patches(mask, periodic=periodic)[0].ravel())[1:]
        dy, dx = comparison.about["spacing"]
        if pixels.size:
            found.append((name, color, np.sort(pixels)[::-1] * dy * dx))
    if not found:
        return None
    factor, unit = prefixed_unit(max(float(areas[0]) for *_, areas in found), "m", 2)
    area, count, share = f"contact area [{unit}]", "contacts at least as large", "their share [%]"
    lines = []
    for name, color, areas in found:
        # the last contact of each size counts all that are as large
        last = np.flatnonzero(np.diff(areas, append=0.0))
        if len(last) > DRAWN:
            last = last[np.unique(np.geomspace(1, len(last), DRAWN).astype(int) - 1)]
        columns = {
            area: areas[last] / factor,
            count: last + 1,
            share: 100 * np.cumsum(areas)[last] / areas.sum(),
        }
        lines.append(Line(f"{name} ({len(areas)})", columns, color, marker=""))
    note = "Contacts are patches of the contact maps; in brackets their number."
    return Figure(line_figure(lines, area, count), "Contact sizes", note)
