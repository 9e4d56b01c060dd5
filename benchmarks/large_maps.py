"""Curves of maps that stay on disk: time and peak memory against the map in memory, by points.

    python benchmarks/large_maps.py --sides 4096 8192 16384 --memory 2GiB
    python benchmarks/large_maps.py --sides 16384 --bem 0.005 --memory 10GiB
    python benchmarks/large_maps.py --sides 8192 16384 --pixels 6 40 --memory 3GiB

Self-affine maps, H 0.8, rms slope 0.1, float32 in HDF5, each made by blocks; rough to the pixel, or
with a cut-off and a roll-off in `--pixels`, so that each summit is a contact. Every row is a
process of its own whose kernels are loaded before. `forecast` is the row before times the ratio of
the points: passes over all points bind, loads add next to nothing. `read`, `curve`, `transform` are
medians of one after the other in a process: the map into memory, its ten loads, one real transform
of it; `over both` is the second over the sum of the others. The memory that they take is written
before each, since a host gives it at the first touch, and which of them pays for that is chance.
Below the row the stages of that curve, the contacts at the last load, and the memory above that of
the program and the plan: the most that was taken, and what the plan announces. `--bem` solves one
load, a share of E* times the slope, in place of the curve.
"""

from __future__ import annotations

import argparse
import multiprocessing
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from bem_worker import memory as status
from bem_worker import reset_peak
from common import machine, options, rough
from scipy import fft

import asperity
import surfaces
from asperity.limits import set_memory
from surfaces.numerics.parallel import threads
from surfaces.units import quantity

BODY = asperity.HalfSpace(210e9, 0.3)

REPEATS = 5
"""Rounds of reading, curve and transform."""


def ready(share: float | None) -> None:
    """Load the compiled code."""
    warnings.simplefilter("ignore")
    hm = rough((512, 512), 2.0, 1)
    asperity.contact_curve(hm, BODY)
    if share is not None:
        asperity.bem_solve(hm, BODY, pressure=share * BODY.modulus * hm.roughness.rms_slope)


def run(path: Path, memory: int | None, share: float | None) -> dict[str, Any]:
    """Time and peak memory from file to answer, and the answer."""
    ready(share)
    set_memory(memory)
    begun = time.perf_counter()
    hm = surfaces.read(path)
    found: dict[str, Any] = {"kind": type(hm).__name__}
    before = 0
    if share is None:
        plan = asperity.make_plan(hm, BODY)
        before, held = status("VmHWM"), status("VmRSS")
        reset_peak()
        curve = asperity.contact_curve(hm, BODY, plan=plan)
        found["taken"] = (status("VmHWM") - held) >> 20
        found["announced"] = next(why for why in plan.reasons if why.startswith("memory"))
        found["contacts"] = curve.extra["microcontacts"][-1]
        found["answer"] = np.stack([curve.load, curve.separation, curve.area_fraction])
    else:
        solved = asperity.bem_solve(hm, BODY, pressure=share * BODY.modulus * 0.1)
        found["answer"] = np.array([solved.load, solved.separation, solved.certificate.worst])
    found["seconds"] = time.perf_counter() - begun
    found["peak"] = max(before, status("VmHWM"))
    return found


def apiece(path: Path) -> dict[str, Any]:
    """Seconds to read the map into memory, of its ten loads, and of one real transform of it."""
    ready(None)
    rounds = []
    for _ in range(REPEATS):
        spent = []
        hm = timed(path, spent, lambda: surfaces.read(path))
        curve = timed(path, spent, lambda hm=hm: asperity.contact_curve(hm, BODY))
        timed(path, spent, lambda hm=hm: fft.rfft2(hm.heights, workers=threads()))
        rounds.append(spent)
        del hm
    read, ten, transform = np.median(rounds, axis=0).tolist()
    return {"read": read, "curve": ten, "transform": transform, "stages": curve.seconds}


def timed(path: Path, spent: list[float], function: Callable[[], Any]) -> Any:
    """What a function gives, its time kept, after so much memory was written as it may take."""
    np.ones((4, path.stat().st_size), np.uint8)
    begun = time.perf_counter()
    found = function()
    spent.append(time.perf_counter() - begun)
    return found


def apart(function: Any, *arguments: Any) -> Any:
    """What a function gives in a process of its own."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(function, arguments)


def main(args: argparse.Namespace) -> None:
    """Make the maps and print a row for each."""
    memory = int(quantity(args.memory, "memory"))
    print(f"{machine()}, at most {memory / 2**30:.3g} GiB")
    print("  side   disk [s]  peak [GiB]  forecast [s]  memory [s]  peak [GiB]  read [s]  "
          "curve [s]  transform [s]  over both  differs by")  # fmt: skip
    last = 0.0
    with tempfile.TemporaryDirectory() as folder:
        for side in args.sides:
            path = Path(folder) / "map.h5"
            waves = {"hurst": 0.8, "rms_slope": 0.1, "seed": 3, "dtype": "float32"}
            waves |= dict(zip(("cutoff", "rolloff"), 1e-6 * np.array(args.pixels), strict=False))
            surfaces.write_self_affine(path, (side, side), (side * 1e-6,) * 2, **waves)
            stored = apart(run, path, memory, args.bem)
            held = apart(run, path, None, args.bem) if args.bem is None else stored
            each = apart(apiece, path)
            both = each["read"] + each["transform"]
            forecast, last = 4.0 * last if last else np.nan, stored["seconds"]
            off = np.max(np.abs(stored["answer"] / held["answer"] - 1.0))
            print(
                f"{side:6d} {stored['seconds']:10.1f} {stored['peak'] / 2**30:11.2f} "
                f"{forecast:13.1f} {held['seconds']:11.1f} {held['peak'] / 2**30:11.2f} "
                f"{each['read']:9.2f} {each['curve']:10.2f} {each['transform']:14.2f} "
                f"{each['curve'] / both:10.2f} "
                f"{off:11.1e}  {stored['kind']}",
                flush=True,
            )
            if args.bem is None:
                print("        " + ", ".join(f"{k} {v:.2f} s" for k, v in each["stages"].items()))
                names = "contacts", "taken", "announced"
                told = (f"{name} {stored[name]}" for name in names)
                print("        " + ", ".join(told) + " (MiB above the plan)", flush=True)


if __name__ == "__main__":
    parser = options(__doc__)
    parser.add_argument("--sides", type=int, nargs="+", default=[4096, 8192, 16384])
    parser.add_argument("--memory", default="2GiB", metavar="SIZE")
    parser.add_argument("--pixels", type=float, nargs=2, default=(), metavar="LENGTH")
    parser.add_argument("--bem", type=float, metavar="SHARE", help="one load of boundary elements")
    main(parser.parse_args())
