"""The figures of the report, as inline SVG."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from typing import Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter, NullFormatter
from numpy.typing import NDArray

from asperity.results.curve import ContactCurve

__all__ = ["area_figure", "map_figure", "pareto_figure", "separation_figure"]

BEM_COLOR, MODEL_COLOR, BOTH_COLOR = "#1b4f72", "#c0562b", "#3c3c3c"
ELASTIC_COLOR = "#8a8a8a"
LABELS = {
    "separation": "separation [m]",
    "mean_pressure": "mean pressure [Pa]",
    "area_fraction": "real contact area fraction",
}
STYLE: Any = {
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "legend.frameon": False,
}
CURVE_SIZE = (5.4, 3.9)
"""Width and height of a curve [inches]."""

MAP_POINTS = 1000
"""Contact maps are thinned to at most about this many points along an axis."""


def separation_figure(
    model: ContactCurve, reference: ContactCurve, elastic: ContactCurve | None
) -> str:
    """Mean pressure over separation, both models, and without hardness."""

    def draw(figure: Figure) -> None:
        _curves(figure, (reference, model, elastic), "separation", "mean_pressure", "y")

    return _svg(draw, CURVE_SIZE)


def area_figure(model: ContactCurve, reference: ContactCurve, elastic: ContactCurve | None) -> str:
    """Real contact area fraction over mean pressure, both models, and without hardness."""

    def draw(figure: Figure) -> None:
        _curves(figure, (reference, model, elastic), "mean_pressure", "area_fraction", "x", "y")

    return _svg(draw, CURVE_SIZE)


def map_figure(
    bem: NDArray[np.bool_], model: NDArray[np.bool_], spacing: tuple[float, float]
) -> str:
    """Contact maps (ny, nx) of both models at one load, one over the other; `spacing` [m]."""
    colors = np.array([[255, 255, 255], [27, 79, 114], [192, 86, 43], [60, 60, 60]], np.uint8)
    step = max(1, -(-max(bem.shape) // MAP_POINTS))
    picture = colors[bem.astype(np.int8) + 2 * model.astype(np.int8)][::step, ::step]
    height, width = (n * d for n, d in zip(bem.shape, spacing, strict=True))

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        extent = (0.0, width, height, 0.0)
        axes.imshow(picture, extent=extent, interpolation="nearest")
        axes.grid(False)
        for axis, name in ((axes.xaxis, "x"), (axes.yaxis, "y")):
            axis.set_major_formatter(EngFormatter(unit="m"))
            axis.set_label_text(name)
        for color, label in (
            (BEM_COLOR, "boundary elements only"),
            (MODEL_COLOR, "microcontacts only"),
            (BOTH_COLOR, "both"),
        ):
            axes.plot([], [], "s", color=color, label=label)
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, fontsize=9)

    return _svg(draw, (6.4, 6.4 * float(np.clip(height / width, 0.3, 1.6)) + 0.6))


def pareto_figure(pareto: NDArray[np.void]) -> str:
    """Error against run time of every run, the rows of `pareto`."""

    def draw(figure: Figure) -> None:
        panels = figure.subplots(1, 2, sharex=True)
        for axes, name, title in (
            (panels[0], "load_error", "load at equal separation"),
            (panels[1], "area_error", "area at equal load"),
        ):
            _scatter(axes, pareto, name)
            axes.set(xlabel="run time [s]", title=title, **_logarithmic(axes, "x", "y"))
            axes.margins(0.18)
            axes.xaxis.set_minor_formatter(NullFormatter())
            axes.yaxis.set_minor_formatter(NullFormatter())
        panels[0].set_ylabel("rms error [%]")
        panels[0].legend()

    return _svg(draw, (9.0, 3.8))


def _scatter(axes: Any, pareto: NDArray[np.void], name: str) -> None:
    for kind, color, marker, label in (
        ("bem", BEM_COLOR, "o", "boundary elements"),
        ("asperity", MODEL_COLOR, "D", "microcontacts"),
    ):
        rows = pareto[pareto["model"] == kind]
        rows = rows[np.isfinite(rows[name]) & (rows[name] > 0)]
        axes.plot(rows["seconds"], 100 * rows[name], marker, color=color, label=label)
        for row in rows:
            axes.annotate(
                f"{row['ny']}×{row['nx']}",
                (row["seconds"], 100 * row[name]),
                xytext=(5, 4),
                textcoords="offset points",
                fontsize=8,
                color=color,
            )


def _curves(
    figure: Figure, curves: tuple[ContactCurve | None, ...], x: str, y: str, *logarithmic: str
) -> None:
    """Curves of boundary elements, of microcontacts and of these without hardness, if any."""
    axes = figure.add_subplot()
    looks = (
        (BEM_COLOR, "o", "boundary elements"),
        (MODEL_COLOR, "D", "microcontacts"),
        (ELASTIC_COLOR, ".", "microcontacts without hardness"),
    )
    for curve, look in zip(curves, looks, strict=True):
        if curve is not None:
            _points(axes, curve, getattr(curve, x), getattr(curve, y), *look)
    axes.set(xlabel=LABELS[x], ylabel=LABELS[y], **_logarithmic(axes, *logarithmic))
    axes.legend()


def _logarithmic(axes: Any, *names: str) -> dict[str, str]:
    """Scales for `Axes.set`; none where nothing was drawn, which no logarithm can show."""
    drawn = any(len(line.get_xdata()) for line in axes.lines)
    return {f"{name}scale": "log" for name in names} if drawn else {}


def _points(
    axes: Any,
    curve: ContactCurve,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    color: str,
    marker: str,
    label: str,
) -> None:
    """A line through the converged points; points that did not converge are drawn hollow."""
    shown = np.isfinite(x) & np.isfinite(y) & (y > 0)
    good, bad = shown & curve.converged, shown & ~curve.converged
    order = np.flatnonzero(good)[np.argsort(x[good])]
    axes.plot(x[order], y[order], marker=marker, ms=5, lw=1.3, color=color, label=label)
    if bad.any():
        axes.plot(x[bad], y[bad], marker, mfc="none", color=color, label=f"{label}: not converged")


def _svg(draw: Callable[[Figure], None], size: tuple[float, float]) -> str:
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=size, layout="constrained")
        draw(figure)
        buffer = io.StringIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    text = buffer.getvalue()
    drawing = text[text.index("<svg") :]
    return re.sub(r'(<svg [^>]*?)width="[^"]*" height="[^"]*"', r"\1", drawing, count=1)
