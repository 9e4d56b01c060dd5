"""One self-contained HTML page about height maps: numbers, pictures, history."""

from __future__ import annotations

import html
from collections.abc import Iterable
from pathlib import Path

from surfaces.files.atomic import replacing
from surfaces.statistics.bearing import bearing_curve
from surfaces.statistics.correlation import autocorrelation
from surfaces.statistics.describe import Statistics, describe
from surfaces.statistics.parameters import PARAMETERS
from surfaces.statistics.spectrum import power_spectrum

from .drawing import image
from .heightmap import HeightMap
from .plot import plot_autocorrelation, plot_bearing, plot_map, plot_spectrum

__all__ = ["section", "write_page"]

_STYLE = """
body{font:15px/1.5 system-ui,sans-serif;color:#1f2a33;max-width:70rem}
body{margin:2rem auto;padding:0 1rem}
h1{font-size:1.5rem} h2{font-size:1.2rem;border-top:1px solid #d5dbe0;padding-top:1.2rem}
.figures,.numbers{display:flex;flex-wrap:wrap;gap:1rem;align-items:flex-start}
img{max-width:100%;height:auto} .figures img{max-width:calc(50% - .5rem)}
table{border-collapse:collapse;margin:.8rem 0}
td,th{vertical-align:top;padding:.15rem .9rem .15rem 0;text-align:left}
th{font-weight:600;white-space:nowrap} td{font-variant-numeric:tabular-nums}
.warning{background:#fdf3e1;border-left:4px solid #e0a030;padding:.4rem .8rem;margin:.4rem 0}
@media(max-width:50rem){.figures img{max-width:100%}}
"""


def section(hm: HeightMap) -> str:
    """One map as an HTML section with embedded pictures."""
    found = describe(hm)
    figures = [
        plot_map(hm),
        plot_autocorrelation(autocorrelation(hm)),
        plot_bearing(bearing_curve(hm)),
    ]
    if found.moments is not None:
        figures.append(plot_spectrum(power_spectrum(hm), found.fit))
    (ny, nx), (dy, dx) = hm.shape, hm.spacing
    facts = {
        "points": f"{ny} &times; {nx} (y, x), {hm.missing} missing",
        "pixel": f"{dy:.6g} &times; {dx:.6g} m",
        "size": f"{hm.size[0]:.6g} &times; {hm.size[1]:.6g} m",
        "periodic": "yes" if hm.periodic else "no",
    }
    warnings = "".join(f'<p class="warning">{html.escape(text)}</p>' for text in found.warnings)
    return (
        f"<section><h2>{html.escape(hm.name or 'height map')}</h2>{_table(facts)}{warnings}"
        f'<div class="figures">{"".join(image(figure) for figure in figures)}</div>'
        f'<div class="numbers">{"".join(_table(rows) for rows in _numbers(found))}</div>'
        f"{_history(hm)}</section>"
    )


def write_page(sections: Iterable[str], path: Path) -> None:
    """Write sections as one page that needs no other file and no network."""
    text = (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width,initial-scale=1">'
        f"<title>Height maps</title><style>{_STYLE}</style></head>"
        f"<body><h1>Height maps</h1>{''.join(sections)}</body></html>"
    )
    with replacing(path) as part:
        part.write_text(text, encoding="utf-8", errors="replace")


def _numbers(found: Statistics) -> list[dict[str, str]]:
    """Rows of the tables: heights and slopes, bearing curve, features, spectrum and texture."""
    spatial = _named(found.spatial)
    if found.moments is not None:
        spatial["rms slope, spectral [-]"] = f"{found.moments.rms_slope:.5g}"
        spatial["rms curvature, spectral [1/m]"] = f"{found.moments.rms_curvature:.5g}"
        spatial["Nayak parameter [-]"] = f"{found.moments.nayak:.4g}"
        spatial["largest over smallest rms slope [-]"] = f"{found.moments.slope_ratio:.3g}"
    if found.fit is not None:
        spatial["self-affine fit"] = html.escape(str(found.fit)).replace(", ", "<br>")
    groups = (found.heights | found.hybrid, found.functional, found.features)
    return [*map(_named, groups), spatial]


def _named(values: dict[str, float]) -> dict[str, str]:
    return {
        f"{name}, {meaning} [{unit}]": f"{values[name]:.5g}"
        for name, (unit, meaning) in PARAMETERS.items()
        if name in values
    }


def _history(hm: HeightMap) -> str:
    rows = {}
    for number, step in enumerate(hm.history, start=1):
        details = ", ".join(f"{key} {value}" for key, value in step.items() if key != "step")
        rows[f"{number}. {html.escape(str(step.get('step', '')))}"] = html.escape(details)
    return f"<h3>History</h3>{_table(rows)}" if rows else ""


def _table(rows: dict[str, str]) -> str:
    body = "".join(f"<tr><th>{name}</th><td>{value}</td></tr>" for name, value in rows.items())
    return f"<table>{body}</table>"
