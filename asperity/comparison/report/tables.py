"""Tables and sentences of a report; what a file does not hold is left out."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asperity.comparison.record import ComparisonRecord
from asperity.errors import AsperityError
from asperity.results.curve import ContactCurve
from surfaces.arrays import Array
from surfaces.drawing import prefixed_unit, with_unit

from .curves import stated_area_error, typical
from .sample import Sample

__all__ = [
    "Table",
    "at_common_loads",
    "error_table",
    "facts",
    "judged",
    "load_of_maps",
    "pareto_table",
    "resolution_table",
    "size_of",
    "together",
]

Table = tuple[list[str], list[list[str]]]
"""Names of the columns, and the rows, as text."""

MISSING = "–"

ABSENT = (KeyError, TypeError, ValueError, AttributeError, IndexError, AsperityError)
"""What a fact raises that a file does not hold."""

COMPARED = 3
"""Loads at which samples are compared."""


def facts(sample: Sample) -> dict[str, str]:
    """Map, material, model and run of a sample, by name."""
    about, curve, settings = sample.about, sample.curve, sample.curve.settings
    pairs: list[tuple[str, Callable[[], str]]] = [
        ("points", lambda: " × ".join(str(int(n)) for n in about["shape"]) + " (y, x)"),
        ("pixel", lambda: " × ".join(with_unit(float(d), "m") for d in about["spacing"])),
        ("size", lambda: " × ".join(with_unit(length, "m") for length in size_of(about))),
        ("rms height", lambda: with_unit(float(about["rms_height"]), "m")),
        ("rms slope", lambda: f"{float(about['rms_slope']):.4g}"),
        ("modulus E*", lambda: _modulus(float(about["modulus"]), float(about.get("m", 0)))),
        ("hardness", lambda: _hardness(about.get("hardness", settings.get("hardness")))),
        ("boundary", lambda: str(settings["boundary"])),
        ("law", lambda: str(settings["law"])),
        ("interaction", lambda: "on" if settings["interaction"] else "off"),
        ("peaks", lambda: str(settings["peaks"])),
        ("engine", lambda: _verified(curve)),
        ("load points", lambda: f"{len(curve)}, {int(curve.converged.sum())} converged"),
        ("run time", lambda: _run_time(sample)),
        ("made", lambda: str(about["made"]["date"])),
        ("command", lambda: str(about["made"]["command"])),
        ("versions", lambda: str(about["made"]["versions"])),
        ("digest of the map", lambda: str(about["input"])[:16]),
    ]
    found = {}
    for name, text in pairs:
        try:
            found[name] = text()
        except ABSENT:
            continue
    return found


def together(columns: Sequence[dict[str, str]], names: Sequence[str]) -> Table:
    """Facts of several samples, a column each."""
    rows = list(dict.fromkeys(name for column in columns for name in column))
    return ["", *names], [[row, *(column.get(row, MISSING) for column in columns)] for row in rows]


def at_common_loads(samples: Sequence[Sample]) -> list[dict[str, str]]:
    """Contact area and separation of each sample at loads that all their curves reach."""
    ends = []
    for one in samples:
        loads = one.curve.mean_pressure[one.curve.converged & (one.curve.mean_pressure > 0)]
        ends.append((loads.min(), loads.max()) if len(loads) > 1 else (math.inf, 0.0))
    low, high = max(a for a, _ in ends), min(b for _, b in ends)
    if not low < high:
        return [{} for _ in samples]
    found = [{"curve": next(iter(one.curves))} for one in samples]
    for pressure in np.geomspace(low, high, COMPARED):
        for rows, one in zip(found, samples, strict=True):
            try:
                point = one.curve.at(pressure=float(np.clip(pressure, low, high)))
            except AsperityError:
                continue
            load = with_unit(float(pressure), "Pa")
            rows[f"contact area at {load}"] = f"{100 * float(point.area_fraction):.3g} %"
            rows[f"separation at {load}"] = with_unit(float(point.separation), "m")
    return found


def judged(comparison: ComparisonRecord) -> list[tuple[bool, str]]:
    """Whether boundary elements lie within the stated bands, one sentence each."""
    found = []
    for what, column, stated in _stated(comparison):
        error = np.abs(comparison.table[column])
        known = np.isfinite(error) & np.isfinite(stated)
        inside, of = int(np.count_nonzero(error[known] <= stated[known])), int(known.sum())
        if of:
            text = f"{what}: boundary elements lie within the stated band at {inside} of {of} loads"
            found.append((inside == of, f"{text}."))
    return found


def error_table(comparison: ComparisonRecord) -> Table:
    """Both models at every load, their differences, and the errors that the model states."""
    table, (load, area) = comparison.table, _stated(comparison)
    stress, stress_unit = prefixed_unit(typical(table["mean_pressure"]), "Pa")
    length, length_unit = prefixed_unit(typical(table["separation_bem"]), "m")
    return _of_columns(
        (f"mean pressure [{stress_unit}]", _texts(table["mean_pressure"] / stress, ".4g")),
        ("area, boundary elements [%]", _texts(100 * table["area_bem"], ".3g")),
        ("area, model [%]", _texts(100 * table["area_model"], ".3g")),
        ("area error [%]", _texts(100 * table["area_error"], "+.2f")),
        ("stated [%]", list(map(_stated_text, table["area_error"], area[2]))),
        ("load error [%]", _texts(100 * table["load_error"], "+.2f")),
        ("stated [%]", list(map(_stated_text, table["load_error"], load[2]))),
        (f"separation [{length_unit}]", _texts(table["separation_bem"] / length, ".4g")),
        ("separation error [rms heights]", _texts(table["separation_error"], "+.4f")),
        ("contacts, boundary elements", _texts(table["contacts_bem"], ".0f")),
        ("contacts, model", _texts(table["contacts_model"], ".0f")),
    )


def pareto_table(pareto: NDArray[np.void]) -> Table:
    """Every run, its time and its errors; the second one is the reference."""
    own = np.arange(len(pareto)) == 1
    load, area, apart = (
        np.where(own, np.nan, pareto[name])
        for name in ("load_error", "area_error", "separation_error")
    )
    loads = zip(own, _texts(100 * load, ".2f"), strict=True)
    return _of_columns(
        (
            "run",
            [
                "microcontacts" if one == "asperity" else "boundary elements"
                for one in pareto["model"]
            ],
        ),
        ("grid", [f"{ny} × {nx}" for ny, nx in pareto[["ny", "nx"]].tolist()]),
        ("tolerance", _texts(pareto["tolerance"], ".0e")),
        ("run time [s]", _texts(pareto["seconds"], ".3g")),
        ("load error, rms [%]", ["reference" if mine else text for mine, text in loads]),
        ("area error, rms [%]", _texts(100 * area, ".2f")),
        ("separation error, rms [rms heights]", _texts(apart, ".4f")),
    )


def resolution_table(comparison: ComparisonRecord) -> Table | None:
    """Error of the reference's own grid at its ends, beside that of the model."""
    held, table = comparison.resolution, comparison.table
    if held is None or not len(held):
        return None
    loads = held["mean_pressure"]
    near = table[[np.argmin(np.abs(table["mean_pressure"] - load)) for load in loads]]
    both = {name: (1 + held[name]) * (1 + near[name]) - 1 for name in ("load_error", "area_error")}
    return _of_columns(
        ("mean pressure", [with_unit(float(load), "Pa") for load in loads]),
        ("reference against its refined grid: load [%]", _texts(100 * held["load_error"], "+.2f")),
        ("area [%]", _texts(100 * held["area_error"], "+.2f")),
        ("model against the reference: load [%]", _texts(100 * near["load_error"], "+.2f")),
        ("area [%]", _texts(100 * near["area_error"], "+.2f")),
        ("model against the refined grid: load [%]", _texts(100 * both["load_error"], "+.2f")),
        ("area [%]", _texts(100 * both["area_error"], "+.2f")),
    )


def _of_columns(*columns: tuple[str, list[str]]) -> Table:
    """The table of columns of equal length, each with its name."""
    rows = zip(*(cells for _, cells in columns), strict=True)
    return [name for name, _ in columns], [list(row) for row in rows]


def _stated(comparison: ComparisonRecord) -> list[tuple[str, str, Array]]:
    model = comparison.model
    return [
        ("Load at equal separation", "load_error", model.error_estimate),
        ("Area at equal load", "area_error", stated_area_error(model)),
    ]


def _stated_text(error: float, stated: float) -> str:
    if not math.isfinite(stated):
        return MISSING
    mark = "" if not math.isfinite(error) else " ✓" if abs(error) <= stated else " ✗"
    return f"± {100 * stated:.1f}{mark}"


def _texts(values: NDArray[Any], form: str) -> list[str]:
    """Numbers in a form; a dash for what is not known."""
    return [format(float(one), form) if math.isfinite(one) else MISSING for one in values]


def size_of(about: Any) -> tuple[float, float]:
    """Lengths (Ly, Lx) [m] of the map."""
    (ny, nx), (dy, dx) = about["shape"], about["spacing"]
    return ny * dy, nx * dx


def _modulus(value: float, m: float) -> str:
    return f"{value:.4g} Pa m^{-m:g}, grading m = {m:g}" if m else with_unit(value, "Pa", digits=4)


def _hardness(value: Any) -> str:
    return with_unit(float(value), "Pa") if math.isfinite(float(value)) else "none"


def _verified(curve: ContactCurve) -> str:
    held = curve.verification
    if held is None:
        raise KeyError("verification")
    return f"{curve.settings.get('engine', curve.model)}: {held['reason']}"


def _run_time(sample: Sample) -> str:
    seconds = {name: sum(curve.seconds.values()) for name, curve in sample.curves.items()}
    return ", ".join(f"{name} {value:.2g} s" for name, value in seconds.items())


def load_of_maps(comparison: ComparisonRecord) -> str:
    """Mean pressure at which the maps are."""
    return with_unit(float(comparison.table[comparison.map_point]["mean_pressure"]), "Pa")
