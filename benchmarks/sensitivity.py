r"""What a quarter more or less of each constant of the model changes in the judged errors.

    python benchmarks/sensitivity.py --references folder --out docs/development/sensitivity.csv
    python benchmarks/sensitivity.py --rows docs/development/sensitivity.csv \
        --csv docs/development/data/sensitivity.csv
    python benchmarks/sensitivity.py --hardness 0.2 0.5 --only tilted_basins

Every field of `asperity.parameters.Parameters` that is a number, or a tuple of numbers, is scaled
by 0.75 and 1.25 alone, but for the weights of the error estimate, which change no load and no area.
The maps are some of judged_maps.py, with the boundary elements that ablation.py kept. The table
holds the root-mean-square and the worst error of load and area over all points, with the constant
as it is (first row) and scaled, and the largest change of any of them. ``--csv`` writes the
constants that change a load or an area by a tenth of a percent and more.
"""

from __future__ import annotations

import argparse
import csv
import math
from collections.abc import Iterator
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from judged_maps import Scene, errors, reference, scenes
from numpy.typing import NDArray

import asperity
from asperity.parameters import DEFAULTS, Parameters
from asperity.results.storage import write_csv

FAMILIES = (
    "isotropic H 0.8 cut-off 8 px",
    "anisotropic 4:1 cut-off 8 px",
    "plateau-honed",
    "graded m = 0.3",
    "to the pixel, graded m = 0.3",
    "to the pixel H 0.8",
    "to the pixel H 0.5",
    "few summits (like measured)",
    "steps (like measured)",
    "cut off at 2 rms",
)
FACTORS = (0.75, 1.25)
MATTERS = 0.001
COLUMNS = {
    "load error: rms, %": "load_rms",
    "load error: worst, %": "load_worst",
    "load: largest change, %": "load_change",
    "area error: rms, %": "area_rms",
    "area error: worst, %": "area_worst",
    "area: largest change, %": "area_change",
}
"""Heading of the table of the pages, and column of the rows."""

PartMisfit = tuple[NDArray[np.float64], NDArray[np.float64]]


def scaled(value: Any, factor: float) -> Any:
    """A number or all numbers of a tuple times a factor; whole numbers stay whole."""
    if isinstance(value, tuple):
        return tuple(scaled(item, factor) for item in value)
    return round(value * factor) if isinstance(value, int) else value * factor


def variants() -> Iterator[tuple[str, float, Parameters]]:
    """Name of each constant, factor, and the parameters with it."""
    yield "", 1.0, DEFAULTS
    for group in fields(DEFAULTS):
        if group.name == "error_estimate":
            continue
        kept = getattr(DEFAULTS, group.name)
        for field in fields(kept):
            value = getattr(kept, field.name)
            if isinstance(value, bool):
                continue
            for factor in FACTORS:
                other = replace(kept, **{field.name: scaled(value, factor)})
                name = f"{group.name}.{field.name}"
                yield name, factor, replace(DEFAULTS, **{group.name: other})


def row(name: str, factor: float, found: PartMisfit, kept: PartMisfit) -> dict[str, Any]:
    """One row of the table: errors `found` beside those of the constants as they are."""
    made: dict[str, Any] = {"constant": name, "factor": factor}
    for kind, values, before in zip(("load", "area"), found, kept, strict=True):
        made[f"{kind}_rms"] = round(math.sqrt(np.nanmean(values**2)), 5)
        made[f"{kind}_worst"] = round(float(np.nanmax(np.abs(values))), 5)
        made[f"{kind}_change"] = round(float(np.nanmax(np.abs(values - before))), 5)
        made[f"{kind}_refused"] = int(np.count_nonzero(np.isnan(values)))
    return made


def summary(rows: list[dict[str, Any]]) -> list[dict[str, str]]:
    """The table of the pages: constants that change an answer, with both factors."""
    matters: dict[str, dict[float, dict[str, Any]]] = {}
    for one in rows[1:]:
        matters.setdefault(one["constant"], {})[float(one["factor"])] = one
    table = []
    for name, scaled_rows in {"": {factor: rows[0] for factor in FACTORS}, **matters}.items():
        both = [scaled_rows[factor] for factor in FACTORS]
        changes = [float(one[f"{kind}_change"]) for one in both for kind in ("load", "area")]
        if name and max(changes) < MATTERS:
            continue
        line = {"constant": name or "as they are"}
        for label, key in COLUMNS.items():
            low, high = (f"{100 * float(one[key]):.1f}" for one in both)
            line[label] = f"{low}, {high}" if name else low
        table.append(line)
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--references", type=Path, help="folder of boundary-element curves")
    parser.add_argument(
        "--hardness", type=float, nargs="+", default=[math.inf], help="over E* times rms slope"
    )
    parser.add_argument("--only", nargs="*", default=(), help="parts of names of constants")
    parser.add_argument("--out", type=Path, help="CSV that takes all rows")
    parser.add_argument("--rows", type=Path, help="CSV of all rows, made before: measure nothing")
    parser.add_argument("--csv", type=Path, help="CSV that takes the table of the pages")
    args = parser.parse_args()
    if args.rows:
        with args.rows.open() as file:
            table: list[dict[str, Any]] = list(csv.DictReader(file))
    else:
        table = measure(args)
    if args.out:
        write_csv(args.out, {key: [line[key] for line in table] for key in table[0]})
    if args.csv:
        shown = summary(table)
        write_csv(args.csv, {key: [line[key] for line in shown] for key in shown[0]})


def measure(args: argparse.Namespace) -> list[dict[str, Any]]:
    """Rows of the table: the constants as they are, and each of them scaled."""
    judged: list[tuple[Scene, asperity.ContactCurve]] = []
    for first in scenes(None):
        if first.family in FAMILIES and first.family not in {s.family for s, _ in judged}:
            for hardness in args.hardness:
                scene = first._replace(hardness=hardness)
                judged.append((scene, reference(scene, args.references)))
    table = []
    for name, factor, parameters in variants():
        if name and args.only and not any(part in name for part in args.only):
            continue
        runs = [errors(scene, exact, parameters) for scene, exact in judged]
        load, area = (np.concatenate([run[column] for run in runs]) for column in (0, 1))
        if not name:
            kept = load, area
        table.append(row(name, factor, (load, area), kept))
        print(*table[-1].values(), flush=True)
    return table


if __name__ == "__main__":
    main()
