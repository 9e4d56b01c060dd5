"""Two hundred random contacts: any shape, pixel, boundary, grading, spectrum and load.

    python benchmarks/bem_random.py --cases 200

Prints every case that misses its certificate, then how many were certified, the transform pairs
and the seconds.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from bem_support import random_case  # noqa: E402

from asperity import bem_solve  # noqa: E402

TOLERANCE = 1e-7


def main() -> int:
    """Solve the cases; 1 if one of them is not certified."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--largest", type=int, default=260, help="most points per axis")
    args = parser.parse_args()
    pairs, areas, missed = [], [], 0
    start = time.perf_counter()
    for seed in range(args.cases):
        hm, body, pressure, boundary = random_case(seed, args.largest)
        found = bem_solve(hm, body, pressure=pressure, boundary=boundary, tolerance=TOLERANCE)
        pairs.append(found.fft_pairs)
        areas.append(found.area_fraction)
        if not found.converged:
            missed += 1
            print(f"case {seed}: {hm.shape}, {boundary}, m = {body.m:.2f}\n{found}")
    seconds = time.perf_counter() - start
    print(
        f"{args.cases - missed} of {args.cases} certified at {TOLERANCE:.0e}; contact "
        f"{100 * min(areas):.2g} to {100 * max(areas):.3g} %; transform pairs mean "
        f"{np.mean(pairs):.2f}, most {max(pairs)}; {seconds:.0f} s"
    )
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
