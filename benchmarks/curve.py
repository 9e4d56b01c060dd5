"""Run time of the default contact curve by stage: map in memory to ten load points.

    python benchmarks/curve.py                # 1024 x 1024
    python benchmarks/curve.py 4096 2 32      # side, then cut-offs [pixels]

Self-affine maps, H 0.8, rms slope 0.1, roll-off at an eighth of the side; ten mean pressures from
about 0.1 % to 10 % of contact. Compilation is done before; every run has a fresh map, so that
nothing kept from an earlier one helps. Least total of several runs with its stages, and the
processor time of that run.
"""

from __future__ import annotations

import time

from common import machine, options, rough

from asperity import HalfSpace, contact_curve

REPEATS = 5
CUTOFFS = (2.0, 4.0, 8.0, 16.0, 32.0)


def main(n: int, cutoffs: tuple[float, ...]) -> None:
    """Print one row per cut-off."""
    material = HalfSpace.from_modulus(1.0)
    for side, cutoff in ((160, 2.0), (256, 32.0)):
        contact_curve(rough((side, side), cutoff, 3), material)
    print(f"{machine()}, {n}^2")
    print("cut-off  total [s]  processor [s]   peaks   grid        stages [s]")
    for cutoff in cutoffs:
        hm = rough((n, n), cutoff, 3)
        runs = []
        for _ in range(REPEATS):
            fresh = hm.replace()
            wall, cpu = time.perf_counter(), time.process_time()
            curve = contact_curve(fresh, material)
            runs.append((time.perf_counter() - wall, time.process_time() - cpu, curve))
        wall, cpu, curve = min(runs, key=lambda run: run[0])
        stages = ", ".join(f"{stage} {value:.3f}" for stage, value in curve.seconds.items())
        ny, nx = curve.settings["grid"]
        print(
            f"{cutoff:7g} {wall:10.3f} {cpu:14.3f} {curve.settings['peaks']:7d}   "
            f"{f'{ny} x {nx}':<11} {stages}",
            flush=True,
        )


if __name__ == "__main__":
    parser = options(__doc__)
    parser.add_argument("points", type=int, nargs="?", default=1024, help="points per side")
    parser.add_argument("cutoffs", type=float, nargs="*", default=CUTOFFS, help="[pixels]")
    args = parser.parse_args()
    main(args.points, tuple(args.cutoffs))
