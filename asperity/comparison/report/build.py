"""The report of one or several samples: what the page tells, and the page."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from asperity import __version__
from asperity.comparison.record import ComparisonRecord
from surfaces.errors import SurfaceError
from surfaces.history import in_words, preparation_warnings
from surfaces.page.fields import SHOWN
from surfaces.page.figures import Figure
from surfaces.page.lines import Line
from surfaces.page.render import write_html
from surfaces.page.roughness import parameters, spectrum_figure, spectrum_lines
from surfaces.statistics.describe import described

from . import tables
from .contacts import contact_figures, height_figure, size_figure
from .curves import BEM, MODEL, curve_figures, pareto_figure, sample_colors
from .sample import Sample, named_apart

__all__ = ["write_report"]


@dataclass
class Part:
    """What the page tells of one sample alone."""

    name: str
    verdict: str
    warnings: list[str]
    reasons: list[str]
    facts: dict[str, str]
    history: list[str]
    plan: tuple[str, ...] = ()
    roughness: dict[str, str] = field(default_factory=dict)
    spectrum: list[Line] = field(default_factory=list)
    surface: Figure | None = None
    contacts: list[Figure] = field(default_factory=list)
    pareto: Figure | None = None
    judged: list[tuple[bool, str]] = field(default_factory=list)
    errors: tables.Table | None = None
    runs: tables.Table | None = None
    resolution: tables.Table | None = None
    load: str = ""


def write_report(path: str | os.PathLike[str], samples: Sequence[Sample]) -> None:
    """Write the report as one HTML file that needs nothing else, replaced at once when it is
    complete; several samples are overlaid, with a table of a column each."""
    samples = named_apart(samples)
    several = len(samples) > 1
    colors = sample_colors(len(samples))
    parts = [
        _part(one, color if several else BEM, len(samples))
        for one, color in zip(samples, colors, strict=True)
    ]
    curves = curve_figures(samples)
    lines = [line for part in parts for line in part.spectrum]
    spectrum = spectrum_figure(lines) if lines else None
    sizes = size_figure(list(_contact_maps(samples, colors)))
    shown = [*curves, spectrum, sizes]
    for part in parts:
        shown += [part.surface, part.pareto, *part.contacts]
    names = [part.name for part in parts]
    compared = tables.at_common_loads(samples) if several else [{}]
    columns = [more | part.facts for more, part in zip(compared, parts, strict=True)]
    write_html(
        path,
        "report.html.j2",
        [figure for figure in shown if figure is not None],
        packages=["asperity.comparison.report"],
        parts=parts,
        curves=curves,
        spectrum=spectrum,
        sizes=sizes,
        facts=tables.together(columns, names),
        roughness=tables.together([part.roughness for part in parts], names),
        version=__version__,
    )


def _part(sample: Sample, color: str, count: int) -> Part:
    """What one of `count` samples tells; for their size, maps are the smaller the more there are,
    and pressures are of a sample that is alone."""
    history = sample.about.get("history", [])
    warnings = [
        *preparation_warnings(history),
        *(text for curve in sample.curves.values() for text in curve.settings.get("warnings", ())),
    ]
    reasons = [
        f"{name}, load point {i + 1}: {why}"
        for name, curve in sample.curves.items()
        for i, why in enumerate(curve.reasons)
        if why
    ]
    part = Part(
        name=sample.name,
        verdict=sample.verdict(),
        warnings=list(dict.fromkeys(warnings)),
        reasons=reasons,
        facts=tables.facts(sample),
        history=in_words(history),
    )
    if sample.comparison is not None:
        _add_comparison(part, sample.comparison, color, count)
    return part


def _add_comparison(part: Part, comparison: ComparisonRecord, color: str, count: int) -> None:
    alone = count == 1
    part.plan = comparison.plan
    part.judged = tables.judged(comparison)
    part.errors = tables.error_table(comparison)
    part.runs = tables.pareto_table(comparison.pareto)
    part.pareto = pareto_figure(comparison.pareto)
    part.resolution = tables.resolution_table(comparison)
    part.load = tables.load_of_maps(comparison)
    if alone:
        part.contacts = contact_figures(comparison)
    surface = comparison.surface
    if surface is None:
        return
    part.surface = height_figure(surface, comparison, int(SHOWN / math.sqrt(count)))
    try:
        found, curves = described(surface)
    except SurfaceError:
        return
    part.roughness = parameters(found)
    part.warnings = list(dict.fromkeys([*part.warnings, *found.warnings]))
    label = "map" if alone else part.name
    fit = found.fit if alone else None
    if curves.spectrum is not None:
        part.spectrum = spectrum_lines(curves.spectrum, fit, label=label, color=color)


def _contact_maps(samples: Sequence[Sample], colors: Sequence[str]) -> Iterator[Any]:
    """Contact maps with their names and colors: of one sample those of both models."""
    for one, color in zip(samples, colors, strict=True):
        if one.comparison is None:
            continue
        if len(samples) > 1:
            yield one.name, color, one.comparison.maps["bem"], one.comparison
        else:
            yield "boundary elements", BEM, one.comparison.maps["bem"], one.comparison
            yield "microcontacts", MODEL, one.comparison.maps["asperity"], one.comparison
