"""Tables of docs/development/stress.md: how every stress case ends, and what conditioning costs.

python benchmarks/stress.py            # writes docs/development/data/stress*.csv
"""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path

from asperity.stress.conditioning import WORKS
from asperity.stress.table import cases, run, summary

DATA = Path(__file__).resolve().parents[1] / "docs" / "development" / "data"


def write(name: str, rows: Iterable[Iterable[object]]) -> None:
    """Write one table."""
    with (DATA / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)


def conditioning() -> Iterable[tuple[object, ...]]:
    """Heading and rows: iterations / transform pairs over grading and size, by load."""
    loads = sorted({work.load for work in WORKS})
    yield "points", "m", *(f"load of {load:g}" for load in loads)
    rows: dict[tuple[int, float], list[str]] = {}
    for work in WORKS:
        area, iterations, pairs = work.spent()
        rows.setdefault((work.size, work.m), []).append(
            f"{iterations} / {pairs} ({100 * area:.2g} %)"
        )
    for (size, m), cells in rows.items():
        yield f"{size} x {size}", m, *cells


if __name__ == "__main__":
    write("stress", summary(run(cases())))
    write("stress_conditioning", conditioning())
