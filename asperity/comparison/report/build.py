"""Fill the report's template with a comparison."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING

import jinja2

from asperity import __version__
from surfaces.files.atomic import replacing

from . import figures

if TYPE_CHECKING:
    from asperity.comparison.result import Comparison

__all__ = ["write_report"]


def _number(value: float, form: str) -> str:
    """A number as text, a dash where there is none."""
    return format(value, form) if math.isfinite(value) else "–"


def write_report(comparison: Comparison, path: str | os.PathLike[str]) -> None:
    """Write the report of a comparison as one HTML file that needs nothing else."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("asperity.comparison", "report"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["short"] = lambda value: _number(value, ".4g")
    environment.filters["number"] = _number
    environment.filters["percent"] = lambda value, form="+.2f": _number(100 * value, form)
    text = environment.get_template("template.html.j2").render(
        comparison=comparison,
        about=comparison.about,
        verdict=comparison.verdict(),
        version=__version__,
        separation=figures.separation_figure(comparison),
        area=figures.area_figure(comparison),
        maps=figures.map_figure(comparison),
        pareto=figures.pareto_figure(comparison),
    )
    with replacing(path) as partial:
        partial.write_text(text, encoding="utf-8", errors="replace")
