"""Curves of maps that stay on disk: time and peak memory against the map in memory, by points.

    python benchmarks/large_maps.py --sides 4096 8192 16384 --memory 2GiB
    python benchmarks/large_maps.py --sides 16384 --bem 0.005 --memory 10GiB
    python benchmarks/large_maps.py --sides 8192 16384 --pixels 6 40 --memory 3GiB

Self-affine maps, H 0.8, rms slope 0.1, float32 in HDF5, each made by blocks; rough to the pixel, or
with a cut-off and a roll-off in `--pixels`, so that each summit is a contact. Every row is a
process of its own whose kernels are loaded before. `read`, `transform`: of the map in memory;
`over both` is the time from file to ten load points over their sum; `forecast` is the row before
times the ratio of the points: passes over all points bind, loads add next to nothing. Below it the
contacts at the last load, and the memory above that of the program and the plan: the most that was
taken, and what the plan announces. `--bem` solves one load, a share of E* times the slope, in place
of the curve.
"""

from __future__ import annotations

import argparse
import multiprocessing
import tempfile
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from bem_worker import memory as status
from bem_worker import reset_peak
from common import machine, options, rough
from scipy import fft

import asperity
import surfaces
from asperity.memory import set_memory
from asperity.threads import threads
from surfaces.units import quantity

BODY = asperity.HalfSpace(210e9, 0.3)


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


def plain(path: Path) -> tuple[float, float]:
    """Seconds to read the map into memory, and of one real transform of it."""
    begun = time.perf_counter()
    heights = surfaces.read(path).heights
    read = time.perf_counter()
    fft.rfft2(heights, workers=threads())
    return read - begun, time.perf_counter() - read


def apart(function: Any, *arguments: Any) -> Any:
    """What a function gives in a process of its own."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(function, arguments)


def main(args: argparse.Namespace) -> None:
    """Make the maps and print a row for each."""
    memory = int(quantity(args.memory, "memory"))
    print(f"{machine()}, at most {memory / 2**30:.3g} GiB")
    print("  side   disk [s]  peak [GiB]  forecast [s]  memory [s]  peak [GiB]  read [s]  "
          "transform [s]  over both  differs by")  # fmt: skip
    last = 0.0
    with tempfile.TemporaryDirectory() as folder:
        for side in args.sides:
            path = Path(folder) / "map.h5"
            waves = {"hurst": 0.8, "rms_slope": 0.1, "seed": 3, "dtype": "float32"}
            waves |= dict(zip(("cutoff", "rolloff"), 1e-6 * np.array(args.pixels), strict=False))
            surfaces.write_self_affine(path, (side, side), (side * 1e-6,) * 2, **waves)
            stored = apart(run, path, memory, args.bem)
            held = apart(run, path, None, args.bem) if args.bem is None else stored
            read, transform = apart(plain, path)
            forecast, last = 4.0 * last if last else np.nan, stored["seconds"]
            off = np.max(np.abs(stored["answer"] / held["answer"] - 1.0))
            print(
                f"{side:6d} {stored['seconds']:10.1f} {stored['peak'] / 2**30:11.2f} "
                f"{forecast:13.1f} {held['seconds']:11.1f} {held['peak'] / 2**30:11.2f} "
                f"{read:9.1f} {transform:14.1f} {held['seconds'] / (read + transform):10.2f} "
                f"{off:11.1e}  {stored['kind']}",
                flush=True,
            )
            if args.bem is None:
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
