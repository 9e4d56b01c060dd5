"""Fill the report's template with the results of both models."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from typing import Any

import jinja2
import numpy as np
from numpy.typing import NDArray

from asperity import __version__
from asperity.errors import InputError
from asperity.results.curve import ContactCurve
from surfaces.files.atomic import replacing

from . import figures

__all__ = ["write_report"]


def _number(value: float, form: str) -> str:
    """A number as text, a dash where there is none."""
    return format(value, form) if math.isfinite(value) else "–"


def write_report(
    path: str | os.PathLike[str],
    *,
    model: ContactCurve,
    reference: ContactCurve,
    table: NDArray[np.void],
    pareto: NDArray[np.void],
    maps: Mapping[str, NDArray[np.bool_]],
    map_point: int,
    overlap: float,
    plan: Sequence[str],
    about: Mapping[str, Any],
    verdict: str,
    elastic: ContactCurve | None = None,
) -> None:
    """Write the report as one HTML file that needs nothing else.

    Parameters
    ----------
    path
        File to write; replaced at once when it is complete.
    model, reference, table, pareto, maps, map_point, overlap, plan, about, elastic
        As in `Comparison`.
    verdict
        Sentences that come first.

    Raises
    ------
    InputError
        If a fact that the report shows is missing, or the file cannot be written.
    """
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
    unknown = np.full(len(model), np.nan)
    try:
        text = environment.get_template("template.html.j2").render(
            model=model,
            reference=reference,
            table=table,
            pareto=pareto,
            map_point=map_point,
            overlap=overlap,
            plan=plan,
            about=about,
            verdict=verdict,
            version=__version__,
            converged=bool(model.converged.all() and reference.converged.all()),
            stated_area_error=model.extra.get("area_error_estimate", unknown),
            separation_figure=figures.separation_figure(model, reference, elastic),
            area_figure=figures.area_figure(model, reference, elastic),
            map_figure=figures.map_figure(maps["bem"], maps["asperity"], about["spacing"]),
            pareto_figure=figures.pareto_figure(pareto),
        )
    except (jinja2.UndefinedError, KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"the results lack what the report shows ({error}); run asperity compare again"
        ) from error
    with replacing(path) as partial:
        partial.write_text(text, encoding="utf-8", errors="replace")
