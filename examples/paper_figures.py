"""Regenerate the figures of Popov, Li and Willert, Friction (2023), as tables and pictures.

    python examples/paper_figures.py --out figures            # all of them, grid 192
    python examples/paper_figures.py --out figures --only 1,2 --grid 256
    python examples/paper_figures.py --out figures --quick    # coarse and few, for a first look

Each figure leaves figNN.png and figNN.csv: e_F, e_a, e_A of every law against boundary elements,
run time of the law and of the boundary elements, and what halving their grid changes.
"""

from __future__ import annotations

import argparse
import csv
import functools
import itertools
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from asperity import HalfSpace, indent, indent_bem
from asperity.cli import bodies
from asperity.comparison.one_contact import LawComparison, compare_laws
from surfaces import PowerSumProfile, shapes

TURN = np.linspace(0.0, 2 * np.pi, 361)


@dataclass(frozen=True)
class Settings:
    """Where to write, how fine the boundary elements are, how many irregular sections."""

    out: Path
    grid: int
    sections: int
    laws: tuple[str, ...]


class Bench:
    """Runs cases once and writes the tables and pictures."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.case = functools.lru_cache(maxsize=None)(self._case)

    def _case(self, name: str, k: float, m: float, depth: float, grid: int) -> LawComparison:
        material = HalfSpace.from_modulus(1.0, m)
        return compare_laws(body(name, k), material, depth, laws=self.settings.laws, grid=grid)

    def rows(self, name: str, k: float = 1.0, m: float = 0.0, depth: float = 1.0) -> list[dict]:
        """One table row per law, with the change of the reference from the coarser grid."""
        fine = self.case(name, k, m, depth, self.settings.grid)
        coarse = self.case(name, k, m, depth, self.settings.grid // 2)
        assert fine.reference is not None and coarse.reference is not None
        change = float(coarse.reference.force / fine.reference.force - 1)
        return [
            {
                "shape": name, "k": k, "m": m, "d": depth, "law": row.law,
                "e_F_percent": 100 * row.force_error,
                "e_a_percent": 100 * row.contour_error,
                "e_A_percent": 100 * row.area_error,
                "estimate_percent": 100 * float(row.solution.error_estimate),
                "flags": row.solution.flag_names(),
                "law_ms": 1e3 * row.seconds,
                "bem_s": fine.reference_seconds,
                "bem_half_grid_percent": 100 * change,
                "bem_converged": bool(fine.reference.converged),
            }
            for row in fine.rows
            if row.solution is not None
        ]  # fmt: skip

    def write(self, number: int, rows: list[dict], figure: Figure) -> None:
        """Save table and picture of one figure."""
        stem = self.settings.out / f"fig{number:02d}"
        with open(stem.with_suffix(".csv"), "w", newline="") as file:
            table = csv.DictWriter(file, list(rows[0]))
            table.writeheader()
            table.writerows(rows)
        figure.savefig(stem.with_suffix(".png"), dpi=110)
        worst = {law: max((abs(r["e_F_percent"]) for r in rows if r["law"] == law), default=0.0)
                 for law in self.settings.laws}  # fmt: skip
        change = max(abs(r["bem_half_grid_percent"]) for r in rows)
        print(f"figure {number:2d}: {len(rows)} rows, largest |e_F| in %: "
              + ", ".join(f"{law} {value:.3g}" for law, value in worst.items())
              + f"; half the grid changes F by at most {change:.2g} %", flush=True)  # fmt: skip

    def contours(self, number: int, cases: Iterable[tuple[str, float, float, float]]) -> None:
        """Contours of the laws over the contact of the boundary elements."""
        cases = list(cases)
        columns = min(3, len(cases))
        figure = Figure(figsize=(3.4 * columns, 3.6 * -(-len(cases) // columns)))
        rows: list[dict] = []
        for i, (name, k, m, depth) in enumerate(cases):
            axes = figure.add_subplot(-(-len(cases) // columns), columns, i + 1, aspect="equal")
            rows += self.rows(name, k, m, depth)
            self._draw(axes, self.case(name, k, m, depth, self.settings.grid))
            axes.set_title(f"{name}, k = {k:g}, m = {m:g}", fontsize=8)
        figure.tight_layout()
        self.write(number, rows, figure)

    def _draw(self, axes: Any, case: LawComparison) -> None:
        reference = case.reference
        assert reference is not None
        scale = float(next(row.solution for row in case.rows if row.solution).radius)
        for outline in reference.solutions[-1].outlines():
            axes.fill(*((outline - reference.summit[-1]) / scale).T, color="0.82", lw=0)
        for row in case.rows:
            if row.solution is not None:
                edge = row.solution.contour(TURN) / scale
                axes.plot(edge * np.cos(TURN), edge * np.sin(TURN), lw=1, label=row.law)
        axes.legend(fontsize=6)

    def pressures(
        self, number: int, name: str, k: float, m: float, rays: tuple[float, ...]
    ) -> None:
        """Pressure along rays for several grids, and maps of the reference and of the laws."""
        columns = 2 + len([law for law in self.settings.laws if law != "ritz"])
        figure = Figure(figsize=(3.8 * columns, 3.8))
        axes = figure.add_subplot(1, columns, 1)
        grids = [self.settings.grid // 4, self.settings.grid // 2, self.settings.grid]
        fine = self.case(name, k, m, 1.0, grids[-1])
        solved = [row.solution for row in fine.rows if row.solution is not None]
        laws = [one for one in solved if one.law != "ritz"]  # it has no pressure of its own
        a = float(laws[0].radius)
        mean = float(laws[0].force) / (np.pi * a**2)
        r = np.linspace(0.02, 1.6, 80) * a
        for color, degrees in enumerate(rays):
            x, y = r * np.cos(np.radians(degrees)), r * np.sin(np.radians(degrees))
            for one, style in zip(laws, itertools.cycle(("--", "-", ":"))):
                label = f"{one.law}, {degrees:g} deg"
                axes.plot(r / a, one.pressure(x, y) / mean, style, color=f"C{color}", label=label)
            for marker, grid in zip(".x+", grids, strict=True):
                dots = self.case(name, k, m, 1.0, grid).reference.pressure(x, y) / mean
                axes.plot(r[::2] / a, dots[::2], marker, color=f"C{color}", ms=3)
        axes.set(xlabel="r/a", ylabel="p / mean", ylim=(0, 5), title=f"{name}, k={k:g}, m={m:g}")
        axes.legend(fontsize=6)
        reference = fine.reference
        maps = {"boundary elements": reference.pressure_map}
        maps |= {one.law: one.pressure(reference.x, reference.y[:, None]) for one in laws}
        top = float(np.percentile(reference.pressure_map[reference.pressure_map > 0], 99.5))
        for i, (label, field) in enumerate(maps.items()):
            axes = figure.add_subplot(1, columns, 2 + i, aspect="equal")
            levels = np.linspace(0.02, 1, 12) * top
            axes.contourf(reference.x, reference.y, np.minimum(field, top), levels)
            axes.set_title(label, fontsize=8)
        figure.tight_layout()
        self.write(number, self.rows(name, k, m), figure)


def body(name: str, k: float) -> PowerSumProfile:
    """Test body as `asperity indent --shape` names it; ``random:SEED`` of growing deviation."""
    if name.startswith("random"):
        seed = int(name.split(":")[1])
        name = f"random:{0.02 + 0.2 * (seed % 40) / 40}:{seed}"
    return bodies.body(name, None if name == "bent" else k, None)


def errors_over_sides(bench: Bench, number: int) -> None:
    """Figure 2: e_F and e_a against the number of sides, k = 1 and 2."""
    rows = [r for k in (1.0, 2.0) for n in range(3, 9) for r in bench.rows(f"polygon:{n}", k)]
    rows += [r for n in (3, 4, 6) for r in bench.rows(f"cosine:{n}", 2.0)]
    figure = Figure(figsize=(9, 3.6))
    for i, key in enumerate(("e_F_percent", "e_a_percent", "e_A_percent")):
        axes = figure.add_subplot(1, 3, i + 1, xlabel="sides", ylabel=key.replace("_", " "))
        for law in bench.settings.laws:
            for k in (1.0, 2.0):
                some = [r for r in rows if (r["law"], r["k"]) == (law, k) and "poly" in r["shape"]]
                sides = [int(r["shape"].split(":")[1]) for r in some]
                label = f"{law}, k = {k:g}"
                axes.plot(sides, [r[key] for r in some], "o-", ms=3, label=label)
        axes.axhline(0, color="0.7", lw=0.6)
        axes.legend(fontsize=6)
    figure.tight_layout()
    bench.write(number, rows, figure)


def irregular_sections(bench: Bench, number: int) -> None:
    """Figure 8: e_F and e_a of random sections against their deviation, k = 1 and 2."""
    rows = []
    for k in (1.0, 2.0):
        for seed in range(bench.settings.sections):
            name = f"random:{seed}"
            deviation = shapes.deviation(body(name, k))
            rows += [{**r, "deviation": deviation} for r in bench.rows(name, k)]
    figure = Figure(figsize=(9, 3.6))
    for i, key in enumerate(("e_F_percent", "e_a_percent")):
        axes = figure.add_subplot(1, 2, i + 1, xlabel="std psi / mean", ylabel=key)
        for law in bench.settings.laws:
            for k, marker in ((1.0, "o"), (2.0, "x")):
                some = [r for r in rows if (r["law"], r["k"]) == (law, k)]
                axes.plot([r["deviation"] for r in some], [r[key] for r in some], marker, ms=3,
                          label=f"{law}, k = {k:g}")  # fmt: skip
        axes.legend(fontsize=6)
    figure.tight_layout()
    bench.write(number, rows, figure)


def general_body(bench: Bench, number: int) -> None:
    """Figures 10 and 11: F(d), A(d), contact shapes and pressure maps of a bent body."""
    depths = (0.05, 0.3, 1.0)
    material = HalfSpace.from_modulus(1.0)
    if number == 11:
        rows = [r for d in depths for r in bench.rows("bent", 2.0, 0.0, d)]
        figure = Figure(figsize=(6.5, 9))
        for i, d in enumerate(depths):
            case = bench.case("bent", 2.0, 0.0, d, bench.settings.grid)
            one, reference = case.row("harmonic").solution, case.reference
            assert one is not None and reference is not None
            whole = one.pressure(reference.x, reference.y[:, None])
            top = reference.pressure_map.max()
            for j, field in enumerate((reference.pressure_map, whole)):
                axes = figure.add_subplot(3, 2, 2 * i + j + 1, aspect="equal")
                axes.contourf(reference.x, reference.y, field, np.linspace(0.02, 1.02, 12) * top)
                axes.set_title(f"{('boundary elements', 'harmonic')[j]}, d = {d:g}", fontsize=8)
        figure.tight_layout()
        bench.write(number, rows, figure)
        return
    ladder = np.geomspace(0.02, 1.5, 8)
    rows = [r for d in (*depths, *ladder) for r in bench.rows("bent", 2.0, 0.0, float(d))]
    figure = Figure(figsize=(11, 3.6))
    fine = np.geomspace(0.015, 1.6, 60)
    reference = indent_bem(shapes.bent_body(), material, ladder, grid=bench.settings.grid)
    for i, (key, label) in enumerate((("force", "F"), ("contact_area", "A"))):
        axes = figure.add_subplot(1, 3, i + 1, xlabel="d", ylabel=label)
        for law in bench.settings.laws:
            axes.plot(fine, getattr(indent(shapes.bent_body(), material, fine, law=law), key),
                      label=law)  # fmt: skip
        axes.plot(ladder, getattr(reference, key), "ko", ms=3, label="boundary elements")
        axes.legend(fontsize=7)
    axes = figure.add_subplot(1, 3, 3, aspect="equal")
    for d in depths:
        bench._draw(axes, bench.case("bent", 2.0, 0.0, d, bench.settings.grid))
    figure.tight_layout()
    bench.write(number, rows, figure)


def figures(bench: Bench) -> dict[int, Callable[[], None]]:
    """Number of each figure -> what regenerates it."""
    sides = (3, 4, 5, 6)
    some = [1, 9, 17, 25, 33, 39][: max(1, min(6, bench.settings.sections))]
    return {
        1: lambda: bench.contours(1, [(f"polygon:{n}", 1.0, 0.0, 1.0) for n in sides]),
        2: lambda: errors_over_sides(bench, 2),
        3: lambda: bench.pressures(3, "polygon:4", 1.0, 0.0, (0, 30, 40, 45)),
        4: lambda: bench.pressures(4, "polygon:4", 2.0, 0.0, (0, 30, 40, 45)),
        5: lambda: bench.contours(
            5, [(f"rounded:{n}:{c}", 1.0, 0.0, 1.0) for c in (0.1, 0.3, 0.5) for n in sides]
        ),
        6: lambda: bench.pressures(6, "rounded:4:0.3", 1.0, 0.0, (0, 30, 45)),
        7: lambda: bench.pressures(7, "rounded:4:0.3", 2.0, 0.0, (0, 30, 45)),
        8: lambda: irregular_sections(bench, 8),
        9: lambda: bench.contours(9, [(f"random:{s}", 1.0, 0.0, 1.0) for s in some]),
        10: lambda: general_body(bench, 10),
        11: lambda: general_body(bench, 11),
        12: lambda: bench.contours(
            12, [(f"rounded:{n}:0.3", 1.0, m, 1.0) for m in (0.5, -0.3) for n in (3, 4, 6)]
        ),
        13: lambda: bench.pressures(13, "rounded:4:0.3", 1.0, 0.5, (0, 30, 45)),
    }


def main(argv: list[str] | None = None) -> int:
    """Read the options and regenerate the figures asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("figures"))
    parser.add_argument("--only", help="numbers of figures, comma-separated")
    parser.add_argument("--grid", type=int, default=192, help="points per axis (default 192)")
    parser.add_argument("--sections", type=int, default=160, help="sections of figure 8")
    laws = "paper,harmonic,ellipse,ritz"
    parser.add_argument("--laws", default=laws, help=f"default {laws}")
    parser.add_argument("--quick", action="store_true", help="grid 64 and 4 sections")
    args = parser.parse_args(argv)
    args.out.mkdir(parents=True, exist_ok=True)
    grid, sections = (64, 4) if args.quick else (args.grid, args.sections)
    all_figures = figures(Bench(Settings(args.out, grid, sections, tuple(args.laws.split(",")))))
    wanted = [int(n) for n in args.only.split(",")] if args.only else list(all_figures)
    for number in wanted:
        all_figures[number]()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
