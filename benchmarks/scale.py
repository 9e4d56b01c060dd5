"""How sweeps scale: the same jobs and as many for each worker, and what a small job costs beside.

    python benchmarks/scale.py strong              # 100 maps of 512^2 x 3 bodies, 1 and 2 workers
    python benchmarks/scale.py weak --maps 25      # so many maps for each worker
    python benchmarks/scale.py small --maps 1000   # maps of 128^2: overhead of a job
    python benchmarks/scale.py strong --processes  # without Dask

Self-affine maps, H 0.8, rms slope 0.1, cut-off of 4 pixels, in HDF5 files; ten mean pressures from
about 0.1 % to 10 % of contact. The first line is a loop in one process, on one thread, over some of
the jobs: read and solve, write. Then a row for each number of workers: time of the whole sweep, of
which the workers take so much to start; the work, which is what jobs took to read and solve, added
up, and what the loop took to write; the speed-up over the first row; the time of all workers
together over the work, with and without their start. The forecast is start + loop / workers. It
assumes that jobs do not slow each other down, as they do where processors share memory and clock,
and that they are many more than the workers.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from common import machine, options, rough

import asperity
import surfaces

CUTOFF = 4.0
MODULI = (210e9, 110e9, 70e9)

SAMPLE = 100
"""Most maps of the loop."""


def written(folder: Path, maps: int, side: int) -> list[Path]:
    """Files with maps."""
    files = [folder / f"map{seed}.h5" for seed in range(maps)]
    for seed, file in enumerate(files):
        surfaces.write(rough((side, side), CUTOFF, seed), file)
    return files


def materials(bodies: int) -> list[asperity.HalfSpace]:
    """Bodies of the jobs."""
    return [asperity.HalfSpace.from_modulus(modulus) for modulus in MODULI[:bodies]]


def looped(files: Sequence[Path], bodies: int) -> tuple[float, float]:
    """Seconds to read and solve a job, and to write it, in a loop without a sweep."""
    warnings.simplefilter("ignore")
    asperity.set_threads(1)
    seconds = []
    with tempfile.TemporaryDirectory() as folder:
        for file in [files[0], *files[:SAMPLE]]:  # the first loads the compiled code
            for body in materials(bodies):
                begun = time.perf_counter()
                curve = asperity.contact_curve(surfaces.read(file), body)
                solved = time.perf_counter()
                curve.to_hdf5(Path(folder) / "results.h5")
                seconds.append((solved - begun, time.perf_counter() - solved))
    solve, write = np.mean(seconds[bodies:], axis=0)
    return float(solve), float(write)


def timed(files: Sequence[Path], bodies: int, workers: int) -> tuple[float, float, int]:
    """Seconds of a sweep, of its jobs added up, and their number."""
    with tempfile.TemporaryDirectory() as folder:
        begun = time.perf_counter()
        found = asperity.sweep(files, materials(bodies), folder=folder, workers=workers)
        wall = time.perf_counter() - begun
    if not found.converged:
        print(found)
    return wall, float(np.sum(found.table["seconds"])), len(found)


def table(sets: Sequence[Sequence[Path]], bodies: int, workers: Sequence[int]) -> None:
    """Print a row for each number of workers and its files."""
    solve, write = looped(sets[0], bodies)
    print(f"a loop takes {1e3 * solve:.1f} ms to read and solve a job, {1e3 * write:.1f} to write")
    print(
        "workers   jobs   wall [s]  start [s]   work [s]  speed-up  forecast [s]  over work  "
        "without start"
    )
    first = 0.0
    for files, count in zip(sets, workers, strict=True):
        start = timed(files[:count], 1, count)[0] - solve - write
        wall, work, jobs = timed(files, bodies, count)
        work += jobs * write
        first = first or wall / jobs
        over = [f"{seconds * count / work:.3f}" for seconds in (wall, wall - start)]
        print(
            f"{count:7d} {jobs:6d} {wall:10.1f} {start:10.1f} {work:10.1f} "
            f"{first * jobs / wall:9.2f} {start + (solve + write) * jobs / count:13.1f} "
            f"{over[0]:>10} {over[1]:>14}",
            flush=True,
        )


def main(args: argparse.Namespace) -> None:
    """Make the maps and print the table."""
    if args.processes:
        sys.modules["distributed"] = None  # type: ignore[assignment]
    small = args.part == "small"
    side, bodies = args.side or (128 if small else 512), 1 if small else args.bodies
    print(f"{machine()}, maps of {side}^2, {bodies} bodies")
    with tempfile.TemporaryDirectory() as folder:
        most = args.maps * (max(args.workers) if args.part == "weak" else 1)
        files = written(Path(folder), most, side)
        each = [args.maps * (n if args.part == "weak" else 1) for n in args.workers]
        table([files[:count] for count in each], bodies, args.workers)


if __name__ == "__main__":
    parser = options(__doc__)
    parser.add_argument("part", choices=["strong", "weak", "small"])
    parser.add_argument("--maps", type=int, default=100)
    parser.add_argument("--side", type=int, help="points (512; small: 128)")
    parser.add_argument("--bodies", type=int, default=3, choices=[1, 2, 3])
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--processes", action="store_true", help="a pool in place of Dask")
    main(parser.parse_args())
