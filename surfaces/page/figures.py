"""Interactive figures of a page (Bokeh), with the numbers that a reader can take along.

Colors of ink and grid come from the style sheet of the page, so that one figure serves light, dark
and paper.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from bokeh.models import InlineStyleSheet, NoOverlap
from bokeh.plotting import figure

__all__ = ["INK", "Figure", "bare_plot"]

TOOLS = "pan,box_zoom,wheel_zoom,reset,save"

INK = "#7d8791"
"""Color of text that no style sheet reaches, legible on white and on black."""

NO_PRINT = "@media print { :host { display: none; } }"


@dataclass(frozen=True)
class Figure:
    """A figure on a page.

    Attributes
    ----------
    plot
        The Bokeh model.
    title
        What it shows; also the name of its CSV file.
    note
        What to know when reading it.
    keys
        Colors and what they mean, where neither a legend nor a bar of colors says it.
    """

    plot: Any
    title: str
    note: str = ""
    keys: Sequence[tuple[str, str]] = ()


def bare_plot(**how: Any) -> Any:
    """An empty plot without background, whose tools do not catch a finger that scrolls the page."""
    plot: Any = figure(
        tools=TOOLS,
        active_drag=None,
        background_fill_color=None,
        border_fill_color=None,
        outline_line_color=None,
        min_border_right=12,
        **how,
    )
    plot.toolbar.logo = None
    plot.toolbar.autohide = True
    plot.toolbar.stylesheets = [InlineStyleSheet(css=NO_PRINT)]
    plot.axis.axis_label_text_font_style = "normal"
    plot.axis.minor_tick_line_color = None
    plot.axis.major_label_policy = NoOverlap(min_distance=8)
    return plot
