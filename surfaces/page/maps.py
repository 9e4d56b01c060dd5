"""The page about height maps: numbers, figures, what was done to them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from surfaces.heightmap import HeightMap
from surfaces.history import in_words, preparation_warnings
from surfaces.statistics.describe import Statistics, described

from .figures import Figure
from .render import write_html
from .roughness import (
    bearing_figure,
    correlation_figure,
    map_facts,
    parameters,
    spectrum_figure,
    spectrum_lines,
    surface_figure,
)

__all__ = ["Section", "section", "write_page"]


@dataclass(frozen=True)
class Section:
    """What the page tells of one map, and the numbers from which it does."""

    found: Statistics
    name: str
    facts: dict[str, str]
    warnings: list[str]
    figures: list[Figure]
    parameters: dict[str, str]
    history: list[str]


def section(hm: HeightMap) -> Section:
    """Numbers, figures and history of one map."""
    found, curves = described(hm)
    figures = [
        surface_figure(hm),
        correlation_figure(curves.correlation),
        bearing_figure(curves.bearing),
    ]
    if curves.spectrum is not None:
        figures.append(spectrum_figure(spectrum_lines(curves.spectrum, found.fit)))
    return Section(
        found=found,
        name=hm.name or "height map",
        facts=map_facts(hm),
        warnings=[*found.warnings, *preparation_warnings(hm.history)],
        figures=figures,
        parameters=parameters(found),
        history=in_words(hm.history),
    )


def write_page(sections: Iterable[Section], path: Path) -> None:
    """Write sections as one page that needs no other file and no network."""
    shown = list(sections)
    figures = [figure for one in shown for figure in one.figures]
    write_html(path, "maps.html.j2", figures, sections=shown)
