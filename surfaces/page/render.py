"""One HTML page that needs no other file and no network: template, style, figures, library."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any

import jinja2
from bokeh.document import Document
from bokeh.resources import Resources

from surfaces.files.atomic import replacing

from .figures import Figure

__all__ = ["write_html"]


def write_html(
    path: str | os.PathLike[str],
    template: str,
    figures: Sequence[Figure],
    *,
    packages: Sequence[str] = (),
    **content: Any,
) -> None:
    """Fill a template and write it; the file is replaced at once when it is complete.

    Parameters
    ----------
    template
        Its name; it extends ``page.html.j2``.
    figures
        All figures that the template places.
    packages
        Packages besides this one that hold templates.
    content
        Names that the template knows; all text is escaped.

    Notes
    -----
    Bokeh compresses the arrays of the figures, so that maps fit.
    """
    environment = jinja2.Environment(
        loader=jinja2.ChoiceLoader(
            [jinja2.PackageLoader(package, ".") for package in (__package__, *packages)]
        ),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    text = environment.get_template(template).render(
        library=Resources(mode="inline", components=["bokeh"]).render_js(),
        numbers=_numbers(figures),
        **content,
    )
    with replacing(path) as part:
        part.write_text(text, encoding="utf-8", errors="replace")


def _numbers(figures: Sequence[Figure]) -> str:
    """The document of all figures and the places on the page that they go to, as JSON that no text
    of a file can end."""
    document = Document()
    with document.models.freeze():
        for figure in figures:
            document.add_root(figure.plot)
    roots = {figure.plot.id: f"plot-{figure.plot.id}" for figure in figures}
    page = {
        "documents": {"page": document.to_json(deferred=False)},
        "places": [{"docid": "page", "roots": roots, "root_ids": list(roots)}],
    }
    return json.dumps(page).replace("<", "\\u003c")
