"""Errors of a default run on measured maps, tapered and free, against two references.

    python benchmarks/default_run.py MEASURED --out rows.csv --csv TABLE
    python benchmarks/default_run.py --rows rows.csv --csv docs/development/data/default_run.csv

Every map of the folder is prepared as in the README (level, outliers, fill), tapered or left free,
and solved at the ten default loads by `solve` at its default accuracy and by the microcontact model
alone. The references are boundary elements with a load within 0.1 %, on the grid of the map and on
the map refined twice. --out keeps one row per load point, --csv the table of the pages: errors to
8 % of contact, in per cent, "median / 90 % of the points / worst". Printed beside it: how often the
bounds of `solve` held, on the refined grid together with what it says that the pixels leave open.
"""

from __future__ import annotations

import argparse
import csv
import time
from pathlib import Path

import numpy as np

import asperity
import surfaces
from asperity.results.storage import write_csv

TRUTH = 0.003
"""Accuracy in area of the references: their loads are known to a third of that."""
LIGHT = 0.08
"""Area fraction up to which errors are stated."""
PREPARED = {"tapered": "taper", "free": None}
ENGINES = {"solve": asperity.solve, "model alone": asperity.contact_curve}


def rows_of(path: Path, prepared: str) -> list[dict[str, object]]:
    """Errors of one map in one preparation: a row per engine, reference and load point."""
    hm = surfaces.prepare(
        surfaces.read(path), level="plane", outliers=8, fill="harmonic", periodic=PREPARED[prepared]
    )
    body = asperity.HalfSpace(210e9, 0.3)
    answers = {name: solve(hm, body) for name, solve in ENGINES.items()}
    pressures = answers["solve"].mean_pressure
    left = answers["solve"].verification["resolution_uncertainty"]
    rows: list[dict[str, object]] = []
    for grid in ("own", "refined"):
        part = hm if grid == "own" else surfaces.resample(hm, np.asarray(hm.spacing) / 2)
        start = time.perf_counter()
        truth = asperity.bem_curve(part, body, pressures=pressures, accuracy=TRUTH)
        seconds = time.perf_counter() - start
        slope = np.gradient(np.log(truth.mean_pressure), truth.separation)
        for name, answer in answers.items():
            load = np.expm1(-(answer.separation - truth.separation) * slope)
            area = answer.contact_area / truth.contact_area - 1.0
            rows += [
                {
                    "map": path.stem,
                    "prepared": prepared,
                    "engine": name,
                    "grid": grid,
                    "area_fraction": truth.area_fraction[i],
                    "load_error": load[i],
                    "area_error": area[i],
                    "load_bound": answer.error_estimate[i],
                    "area_bound": answer.extra["area_error_estimate"][i],
                    "load_left": left[0],
                    "area_left": left[1],
                    "reference_seconds": seconds,
                }
                for i in range(len(truth))
            ]
    return rows


def summed_up(rows: list[dict[str, str]]) -> dict[str, list[str]]:
    """Table of the pages: one line per preparation and engine."""
    table: dict[str, list[str]] = {"prepared": [], "answer of": []}
    for prepared in PREPARED:
        for engine in ENGINES:
            table["prepared"].append(prepared)
            table["answer of"].append(f"`{engine}`" if engine == "solve" else engine)
            for grid in ("own", "refined"):
                chosen = [
                    row
                    for row in rows
                    if (row["prepared"], row["engine"], row["grid"]) == (prepared, engine, grid)
                    and float(row["area_fraction"]) < LIGHT
                ]
                for quantity in ("load", "area"):
                    errors = [100 * abs(float(row[f"{quantity}_error"])) for row in chosen]
                    text = " / ".join(f"{e:.1f}" for e in np.quantile(errors, [0.5, 0.9, 1.0]))
                    table.setdefault(f"{quantity} error, {grid} grid", []).append(text)
    return table


def bounds_told(rows: list[dict[str, str]]) -> str:
    """How often the bounds of `solve` held, and what it says that the pixels leave open."""
    text = []
    for quantity in ("load", "area"):
        for grid, open_ in (("own", 0.0), ("refined", 1.0)):
            held = [
                abs(float(row[f"{quantity}_error"]))
                <= float(row[f"{quantity}_bound"]) + open_ * float(row[f"{quantity}_left"])
                for row in rows
                if (row["engine"], row["grid"]) == ("solve", grid)
                and float(row["area_fraction"]) < LIGHT
            ]
            text.append(f"{quantity}, {grid} grid: {sum(held)} of {len(held)} within the bound")
        largest = max(float(row[f"{quantity}_left"]) for row in rows)
        text.append(f"{quantity}: the pixels leave open up to {100 * largest:.0f} %")
    return "\n".join(text)


def main() -> None:
    """Measure, or sum up rows of an earlier run."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("maps", type=Path, nargs="?", help="folder of measured maps")
    parser.add_argument("--rows", type=Path, help="rows of an earlier run, in place of a folder")
    parser.add_argument("--out", type=Path, help="one row per load point")
    parser.add_argument("--csv", type=Path, help="the table of the pages")
    args = parser.parse_args()
    rows: list[dict[str, object]] = []
    for path in sorted(args.maps.glob("*.h5")) if args.maps else []:
        for prepared in PREPARED:
            rows += rows_of(path, prepared)
            print(path.stem, prepared, f"{rows[-1]['reference_seconds']:.0f} s", flush=True)
            if args.out:
                write_csv(args.out, {name: [row[name] for row in rows] for name in rows[0]})
    if args.rows:
        with args.rows.open(newline="") as file:
            rows = list(csv.DictReader(file))
    table = summed_up(rows)
    for line in zip(*table.values(), strict=True):
        print(*line, sep="  ")
    print(bounds_told(rows))
    if args.csv:
        write_csv(args.csv, table)


if __name__ == "__main__":
    main()
