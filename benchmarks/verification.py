"""Whether the bounds of `asperity.solve` hold, and what they cost.

    python benchmarks/verification.py --points 512 --seeds 1 2 --out rows.csv
    python benchmarks/verification.py --points 1024 2048 --families "random waves" --engines auto
    python benchmarks/verification.py --drawn --seeds 201 --out rows.csv
    python benchmarks/verification.py --made --seeds 3 --engines auto anchored --out rows.csv
    python benchmarks/verification.py --made --seeds 3 --hardness 0.2
    python benchmarks/verification.py --maps MEASURED

The maps are the textures of textures.py with all --points; or families drawn at random (--drawn),
the further textures of made_surfaces.py (--made), measured maps (--maps).

Every map is solved by boundary elements to a bound of 0.1 % in load, and by `solve` at the
accuracies named. A row is one load point: error and bound of load at equal separation and of area
at equal load, and the seconds of `solve` and of boundary elements at the same accuracy, in turns.
With ``--table`` rows of earlier runs are summed up, one line for each file.
"""

from __future__ import annotations

import argparse
import csv
import time
from pathlib import Path

import numpy as np
from common import scenes
from made_surfaces import made_surfaces
from textures import textures

import asperity
from asperity.halfspace.scene import default_pressures

TRUTH = 0.003
"""Accuracy in area of the reference: its load is known to a third of that."""


def rows_of(name, seed, hm, m, boundary, args) -> list[dict]:
    """Rows of one map."""
    body = asperity.HalfSpace.from_modulus(1.0, m, hardness=args.hardness * hm.roughness.rms_slope)
    loads = default_pressures(hm, body, args.loads)
    truth = asperity.bem_curve(hm, body, pressures=loads, accuracy=TRUTH, boundary=boundary)
    work = truth.extra["elastic_energy"] + truth.extra.get("plastic_work", 0.0)
    rate = truth.load / work
    found = []
    for engine in args.engines:
        for accuracy in args.accuracies:
            begun = time.perf_counter()
            alone = asperity.bem_curve(
                hm, body, pressures=loads, accuracy=2 * accuracy, boundary=boundary
            )
            middle = time.perf_counter()
            # another object: nothing that a map keeps of itself may help
            fresh = hm.replace()
            curve = asperity.solve(
                fresh, body, pressures=loads, accuracy=accuracy, engine=engine, boundary=boundary
            )
            seconds = time.perf_counter() - middle - curve.seconds["resolution"]
            told = curve.verification
            load = rate * (curve.separation - truth.separation)
            with np.errstate(divide="ignore", invalid="ignore"):
                area = np.log(curve.contact_area / truth.contact_area)
                alone_area = np.log(alone.contact_area / truth.contact_area)
            for i in range(len(curve)):
                found.append(
                    {
                        "family": name,
                        "seed": seed,
                        "asked": engine,
                        "accuracy": accuracy,
                        "engine": curve.settings["engine"],
                        "anchors": len(told["anchors"]),
                        "anchor": i in told["anchors"],
                        "met": told["met"],
                        "area_fraction": truth.area_fraction[i],
                        "load_error": load[i],
                        "load_bound": curve.error_estimate[i],
                        "area_error": area[i],
                        "area_bound": curve.extra["area_error_estimate"][i],
                        "bem_load_error": (rate * (alone.separation - truth.separation))[i],
                        "bem_area_error": alone_area[i],
                        "converged": curve.converged[i] and truth.converged[i],
                        "seconds": seconds,
                        "bem_seconds": middle - begun,
                        "resolution_load": told["resolution_uncertainty"][0],
                    }
                )
    return found


def summary(rows: list[dict]) -> None:
    """One line per map and accuracy."""
    for key in dict.fromkeys((r["family"], r["seed"], r["asked"], r["accuracy"]) for r in rows):
        own = [r for r in rows if (r["family"], r["seed"], r["asked"], r["accuracy"]) == key]
        first, text = own[0], f"{key[0]:28s} {key[1]:4d} {key[2]:8s} {key[3]:.2f}"
        text += f" {first['engine']:8s} {first['anchors']:2d} anchors, met {first['met']!s:5s}"
        for k in ("load", "area"):
            error, bound = (max(abs(r[f"{k}_{what}"]) for r in own) for what in ("error", "bound"))
            outside = any(abs(r[f"{k}_error"]) > r[f"{k}_bound"] for r in own)
            text += f"  {k} {100 * error:5.2f} of {100 * bound:4.1f} %{' OUTSIDE' * outside}"
        seconds, alone = first["seconds"], first["bem_seconds"]
        print(f"{text}  {seconds:.2f} / {alone:.2f} s = {seconds / alone:.2f}")


def table(rows: list[dict], name: str) -> list[dict]:
    """Shares of points inside their bounds and within the accuracy, one row per accuracy."""
    lines = []
    for asked, accuracy in dict.fromkeys((r["asked"], r["accuracy"]) for r in rows):
        own = [r for r in rows if (r["asked"], r["accuracy"]) == (asked, accuracy)]
        own = [r for r in own if r["converged"]]
        line = {"maps": name, "engine": asked, "accuracy": f"{accuracy:.0%} / {2 * accuracy:.0%}"}
        line["points"] = str(len(own))
        for k, allowed in (("load", accuracy), ("area", 2 * accuracy)):
            error = np.array([abs(r[f"{k}_error"]) for r in own])
            ratio = error / np.array([r[f"{k}_bound"] for r in own])
            line[f"{k} inside its bound, %"] = f"{100 * np.mean(ratio <= 1):.1f}"
            line[f"{k} beyond twice"] = str(np.sum(ratio > 2))
            line[f"{k} within the accuracy, %"] = f"{100 * np.mean(error <= allowed):.1f}"
        lines.append(line)
    return lines


def read(path: Path) -> list[dict]:
    """Rows of an earlier run."""
    with path.open(newline="") as file:
        found = list(csv.DictReader(file))
    text = "family", "asked", "engine"
    return [
        {
            k: v if k in text else v == "True" if v in ("True", "False") else float(v)
            for k, v in r.items()
        }
        for r in found
    ]


def write(path: Path, rows: list[dict]) -> None:
    """Write rows as CSV."""
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def main() -> None:
    """Run as asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--points", type=int, nargs="+", default=[512])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--loads", type=int, default=10)
    parser.add_argument("--families", nargs="+", default=[])
    parser.add_argument("--engines", nargs="+", default=["anchored"])
    parser.add_argument("--hardness", type=float, default=np.inf, help="over E* times rms slope")
    parser.add_argument("--accuracies", type=float, nargs="+", default=[0.05, 0.02])
    source = parser.add_mutually_exclusive_group()
    source.add_argument("--drawn", action="store_true", help="maps drawn at random")
    source.add_argument("--made", action="store_true", help="made_surfaces.py, on its own grids")
    source.add_argument("--maps", type=Path, help="folder of measured maps")
    parser.add_argument("--table", type=Path, nargs="+", help="files of rows to sum up")
    parser.add_argument("--out", type=Path)
    args = parser.parse_args()
    if args.table:
        write(args.out, [line for path in args.table for line in table(read(path), path.stem)])
        return
    maps = scenes(args, made_surfaces if args.made else lambda seed: textures(seed, args.points))
    rows = [row for scene in maps for row in rows_of(*scene, args)]
    summary(rows)
    for line in table(rows, "all"):
        print(line)
    if args.out:
        write(args.out, rows)


if __name__ == "__main__":
    main()
