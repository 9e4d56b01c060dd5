"""Boundary elements under a hardness: transform pairs against the elastic solve at the same area.

    python benchmarks/hardness.py --size 512 1024
    python benchmarks/hardness.py --model --size 512 1024   # time of the model over the elastic one
    python benchmarks/hardness.py --maps MEASURED --border smooth --csv FILE
    python benchmarks/hardness.py --peers /path/to/peers/bin/python --size 256

x is the hardness over E* times the rms slope. With --peers (an environment with Tamaas) both are
timed, and both pressures are certified anew here, in numpy, with the exact least energy of the
bounds. With --maps the largest errors [%] of the model in load at equal separation and in area at
equal load, against boundary elements on the map refined twice, at 0.5 to 10 % of contact.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
from common import errors, measured, pressures_at

import asperity
import surfaces
from asperity.halfspace.scene import pressure_scale
from asperity.results.storage import write_csv

MODULUS, SLOPE, PIXEL = 1e11, 0.1, 1e-6
SHARES = 0.02, 0.05, 0.1, 0.2, 0.5, 1.0
AREAS = 0.005, 0.02, 0.08, 0.2
TO_TENTH = 0.005, 0.01, 0.02, 0.03, 0.05, 0.07, 0.08, 0.09, 0.1
ROUNDS = 15
"""Curves of the model of which the quickest counts; those of all x alternate."""

TAMAAS = """
import sys, time, numpy as np, tamaas as tm
task = np.load(sys.argv[1])
heights, n = task["heights"], task["heights"].shape[0]
begun = time.perf_counter()
model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [1.0, 1.0], [n, n])
model.E, model.nu = 1.0, 0.0
solver = tm.KatoSaturated(model, heights, float(task["tolerance"]), float(task["hardness"]))
solver.max_iter = int(task["most"])
solver.solve(float(task["pressure"]))
np.savez(sys.argv[2], pressure=model.traction, seconds=time.perf_counter() - begun)
"""


def rough(n, seed):
    """Hurst exponent 0.8, roll-off at a quarter of the side, cut-off at 8 pixels."""
    return surfaces.self_affine(
        (n, n),
        (n * PIXEL, n * PIXEL),
        hurst=0.8,
        rms_slope=SLOPE,
        rolloff=0.25 * n * PIXEL,
        cutoff=8 * PIXEL,
        seed=seed,
    )


def certificate(pressure, heights, hardness):
    """Duality gap of 0 <= p <= H over load and rms height, of p over E* on the unit square."""
    n = len(pressure)
    q = 2 * np.pi * np.hypot(np.fft.fftfreq(n, 1 / n)[:, None], np.fft.rfftfreq(n, 1 / n))
    q[0, 0] = np.inf
    gap = (np.fft.irfft2(np.fft.rfft2(pressure) * 2 / q) - heights).ravel()
    p = np.clip(pressure, 0.0, hardness).ravel()
    whole = min(int(p.sum() / hardness), p.size - 1)
    lowest = np.sort(gap)
    best = hardness * lowest[:whole].sum() + (p.sum() - whole * hardness) * lowest[whole]
    return ((gap * p).sum() - best) / (p.sum() * heights.std())


def solved(hm, share, pressure):
    """Solution and seconds at a hardness share and mean pressure, both over E* h'."""
    scale = MODULUS * SLOPE
    mat = asperity.HalfSpace.from_modulus(MODULUS, hardness=share * scale)
    begun = time.perf_counter()
    found = asperity.bem_solve(hm, mat, pressure=pressure * scale)
    return found, time.perf_counter() - begun


def at_area(hm, share, area):
    """Solution and seconds at a contact area, to 5 %."""
    low, high = 0.0, min(1.0, share)
    load = min(area / 2, 0.9 * area * share)
    for _ in range(20):
        found, seconds = solved(hm, share, load)
        if abs(found.area_fraction / area - 1) < 0.05:
            break
        low, high = (load, high) if found.area_fraction < area else (low, load)
        load *= area / found.area_fraction
        if not low < load < high:
            load = 0.5 * (low + high)
    return found, seconds, load


def pairs(sizes, seeds):
    """Table of transform pairs and seconds at equal areas."""
    print("   n seed  area     x  pairs elastic ratio  seconds elastic  A H/P  plastic    worst")
    for n in sizes:
        for seed in seeds:
            hm = rough(n, seed)
            for area in AREAS:
                base, quickest, _ = at_area(hm, np.inf, area)
                for share in SHARES:
                    found, seconds, load = at_area(hm, share, area)
                    ratio = found.fft_pairs / base.fft_pairs
                    print(
                        f"{n:4} {seed:4} {found.area_fraction:5.3f} {share:5.2f}  "
                        f"{found.fft_pairs:5} {base.fft_pairs:7} {ratio:5.2f}  {seconds:7.3f} "
                        f"{quickest:7.3f} {found.area_fraction * share / load:6.3f} "
                        f"{found.plastic_share:8.3f} {found.certificate.worst:8.1e}"
                        f"{'' if found.converged else '  NOT CONVERGED'}",
                        flush=True,
                    )


def against_tamaas(python, sizes, most):
    """Times of both, with the certificates that they reached."""
    print("   n     x  area   seconds  certificate   Tamaas  certificate  ratio")
    for n in sizes:
        hm = rough(n, 1)
        heights = hm.about_mean.heights / (n * PIXEL)
        for share in (0.05, 0.2, 0.5):
            found, seconds, load = at_area(hm, share, 0.08)
            hardness = share * SLOPE
            own = certificate(found.pressure / MODULUS, heights, hardness)
            with tempfile.TemporaryDirectory() as folder:
                task, result = Path(folder, "task.npz"), Path(folder, "result.npz")
                np.savez(
                    task,
                    heights=heights,
                    tolerance=1e-12,
                    hardness=hardness,
                    pressure=load * SLOPE,
                    most=most,
                )
                subprocess.run(
                    [python, "-c", TAMAAS, task, result], check=True, capture_output=True
                )
                peer = np.load(result)
                theirs = certificate(peer["pressure"], heights, hardness)
                print(
                    f"{n:4} {share:5.2f} {found.area_fraction:5.3f} {seconds:9.3f} {own:12.1e} "
                    f"{float(peer['seconds']):8.2f} {theirs:12.1e} "
                    f"{float(peer['seconds']) / seconds:6.0f}",
                    flush=True,
                )


def model_times(sizes, seeds):
    """Table of the time of the model over the elastic one, ten loads of the same areas each."""
    scale, wanted = MODULUS * SLOPE, np.geomspace(0.005, 0.1, 10)
    print("   n seed  elastic [ms]  " + "".join(f"x {share:<5}" for share in SHARES))
    for n in sizes:
        for seed in seeds:
            hm, tasks = rough(n, seed), []
            for share in (np.inf, *SHARES):
                mat = asperity.HalfSpace.from_modulus(MODULUS, hardness=share * scale)
                most = min(0.12, 0.5 * share) * scale
                curve = asperity.contact_curve(hm, mat, pressures=np.geomspace(0.01, 1, 14) * most)
                tasks.append((mat, pressures_at(curve, wanted)))
            seconds = np.empty((ROUNDS, len(tasks)))
            for turn in range(ROUNDS):
                for k, (mat, loads) in enumerate(tasks):
                    begun = time.perf_counter()
                    asperity.contact_curve(hm, mat, pressures=loads)
                    seconds[turn, k] = time.perf_counter() - begun
            best = seconds.min(axis=0)
            ratios = "".join(f"{ratio:5.2f}  " for ratio in best[1:] / best[0])
            print(f"{n:4} {seed:4} {1e3 * best[0]:13.0f}  {ratios}", flush=True)


def measured_maps(folder, border):
    """Errors of the model on measured maps, made periodic by their `border` or free, as a table."""
    soft = asperity.HalfSpace.from_modulus(1.0)
    table = {"map": []} | {f"H/(E* h') = {share:g}": [] for share in SHARES}
    for path in sorted(folder.glob("*.h5")):
        hm = measured(path, border)
        fine = surfaces.resample(hm, np.asarray(hm.spacing) / 2)
        told = [path.stem]
        for share in SHARES:
            hard = asperity.HalfSpace.from_modulus(1.0, hardness=share * pressure_scale(hm, soft))
            loads = pressures_at(asperity.contact_curve(hm, hard), TO_TENTH)
            exact = asperity.bem_curve(fine, hard, pressures=loads, accuracy=0.005)
            counted = exact.area_fraction <= 1.005 * TO_TENTH[-1]
            off = np.nanmax(np.abs(errors(hm, hard, exact)[0][:, counted]), axis=1)
            told.append(" / ".join(f"{100 * worst:.1f}" for worst in off))
        for column, text in zip(table.values(), told, strict=True):
            column.append(text)
        print("  ".join(told), flush=True)
    return table


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", type=int, nargs="+", default=[512])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--model", action="store_true", help="time of the model")
    parser.add_argument("--maps", type=Path, metavar="FOLDER", help="errors on measured maps")
    parser.add_argument("--border", default="taper", help="how these are made periodic, or free")
    parser.add_argument("--csv", type=Path, help="their table")
    parser.add_argument("--peers", help="python of an environment with Tamaas")
    parser.add_argument("--iterations", type=int, default=300, help="of Tamaas")
    args = parser.parse_args()
    if args.maps:
        warnings.simplefilter("ignore")
        table = measured_maps(args.maps, args.border)
        if args.csv:
            write_csv(args.csv, table)
    elif args.model:
        model_times(args.size, args.seeds)
    elif args.peers:
        against_tamaas(args.peers, args.size, args.iterations)
    else:
        pairs(args.size, args.seeds)


if __name__ == "__main__":
    main()
