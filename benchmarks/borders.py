"""What it costs to make a window of a larger surface periodic, border by border.

    python benchmarks/borders.py --seeds 1 2 3 --rolloff 64 400

Periodic random waves (Hurst exponent 0.8, 1024², cut-off 8 pixels, roll-off in pixels) are cut into
four windows, levelled, and made periodic. Mean and rms of what boundary elements then find less
what they find on the whole surface at the same mean pressures, near 2 and 8 % of contact: contact
area [%], separation [rms heights]. "tenth": a taper over a tenth of the side.
"""

from __future__ import annotations

import argparse
import sys
from itertools import product
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import asperity
import surfaces

POINTS, PIXEL, SLOPE = 1024, 1e-6, 0.1
BODY = asperity.HalfSpace.from_modulus(1.0)
PRESSURES = np.array([0.01, 0.04]) * SLOPE


def answer(hm):
    """Area fractions and separations [m] at the mean pressures."""
    curve = asperity.bem_curve(hm, BODY, pressures=PRESSURES, accuracy=0.01)
    return np.array([curve.area_fraction, curve.separation])


def windows(hm):
    """The four quarters of a map, levelled."""
    half = POINTS // 2
    for row, col in product((0, half), repeat=2):
        yield surfaces.prepare(surfaces.crop(hm, (row, row + half), (col, col + half)))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--rolloff", type=int, nargs="+", default=[64, 400])
    args = parser.parse_args()
    borders = {"taper": {}, "tenth": {"width": 0.05 * POINTS * PIXEL}, "smooth": {}, "mirror": {}}
    print("rolloff  border  area: mean, rms [%]         separation: mean, rms [rms heights]")
    for rolloff in args.rolloff:
        found = {border: [] for border in borders}
        for seed in args.seeds:
            size = (POINTS * PIXEL,) * 2
            spectrum = {"hurst": 0.8, "rms_slope": SLOPE, "cutoff": 8 * PIXEL, "seed": seed}
            hm = surfaces.self_affine((POINTS, POINTS), size, rolloff=rolloff * PIXEL, **spectrum)
            area, separation = answer(hm)
            for window, (border, how) in product(windows(hm), borders.items()):
                kind = "taper" if border == "tenth" else border
                got = answer(surfaces.make_periodic(window, kind, **how))
                off = 100 * (got[0] / area - 1.0), (got[1] - separation) / hm.rms_height
                found[border].append(off)
        for border, rows in found.items():
            mean, rms = np.mean(rows, axis=0), np.sqrt(np.mean(np.square(rows), axis=0))
            told = "   ".join(
                " ".join(f"{one:+.2f} {two:.2f}" for one, two in zip(*pair, strict=True))
                for pair in zip(mean, rms, strict=True)
            )
            print(f"{rolloff:7}  {border:7} {told}", flush=True)


if __name__ == "__main__":
    main()
