"""Errors of the model on maps that the other body presses as finite punches, tilted or hollow.

    python benchmarks/free_maps.py --seeds 4 5 6

Random waves (Hurst exponent 0.8, 256²), plus a plane or a bowl of so many rms heights at the
border: their contacts are cut by it. Boundary elements on the same points are the judge, from 0.2
to 10 % of contact. Last, of all points together: errors inside the estimate, and the weight of the
term `at_border` that each, and nine in ten, would have needed.
"""

from __future__ import annotations

import argparse
import warnings

import numpy as np
from common import errors, pressures_at

import asperity
import surfaces
from asperity.parameters import DEFAULTS

POINTS, SLOPE = 256, 0.1
BODY = asperity.HalfSpace.from_modulus(1.0)
FRACTIONS = np.array([0.002, 0.005, 0.01, 0.03, 0.1])
X = np.linspace(-1.0, 1.0, POINTS)
PLANE, CORNER, BOWL = X + 0.0 * X[:, None], X + X[:, None], X**2 + X[:, None] ** 2
FORMS = {
    "level": 0.0 * PLANE,
    "plane, 2": 2.0 * PLANE,
    "plane, 6": 6.0 * PLANE,
    "plane, 20": 20.0 * PLANE,
    "corner, 3": 3.0 * CORNER,
    "corner, 10": 10.0 * CORNER,
    "bowl, 2": 2.0 * BOWL,
    "bowl, 10": 10.0 * BOWL,
    "bowl, 50": 50.0 * BOWL,
}


def judged(hm):
    """Errors and estimates [-] of load and area, and the term, shape (2, n) each."""
    loads = pressures_at(asperity.contact_curve(hm, BODY), FRACTIONS)
    off, same, model = errors(
        hm, BODY, asperity.bem_curve(hm, BODY, pressures=loads, tolerance=1e-4)
    )
    stated = np.array([same.error_estimate, model.extra["area_error_estimate"]])
    return off, stated, np.array([each.extra["at_border"] for each in (same, model)])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, nargs="+", default=[4, 5, 6])
    args = parser.parse_args()
    warnings.simplefilter("ignore")
    every = []
    print("form         load, area: worst error [%]    stated there [%]")
    for name, form in FORMS.items():
        found = []
        for seed in args.seeds:
            for cutoff in (8, 24):
                waves = {"hurst": 0.8, "rms_slope": SLOPE, "rolloff": 0.25, "seed": seed}
                hm = surfaces.self_affine(
                    (POINTS,) * 2, (1.0, 1.0), cutoff=cutoff / POINTS, **waves
                )
                heights = hm.heights + hm.rms_height * form
                found.append(judged(surfaces.HeightMap(heights, hm.spacing)))
        off, stated, term = np.concatenate(found, axis=2)
        every.append((off, stated, term))
        worst = np.nanargmax(np.abs(off), axis=1)
        told = (100 * each[[0, 1], worst] for each in (off, stated))
        print(
            f"{name:10}", *("  {:6.1f} {:6.1f}        ".format(*each) for each in told), flush=True
        )
    off, stated, term = np.concatenate(every, axis=2)
    print("inside [%]:", *(100 * np.mean(np.abs(off) <= stated, axis=1)).round(1))
    rest = np.abs(off) - (stated - DEFAULTS.error_estimate.at_border * term)
    needed = np.divide(rest, term, out=np.zeros_like(rest), where=term > 0.02)
    print("needed: most, nine in ten:", *np.max(needed, axis=1), *np.quantile(needed, 0.9, axis=1))


if __name__ == "__main__":
    main()
