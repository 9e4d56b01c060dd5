"""Random hostile maps through model and `solve`: no traceback, no warning, no hang, no silence.

    python benchmarks/hostile.py --maps 2000 --seconds 30

A map is one of a dozen ugly kinds (spikes, steps, checkerboards, one line, ties, tilt, tiny or huge
units, an offset, numbers of a few bits) on a grid of 1 to 48 points a side, with loads over many
decades, a grading, a boundary and, for half of them, a hardness. An answer is right if it is an
error of this package, or a curve whose points are finite and converged, within the hardness, or not
converged with a reason.
"""

from __future__ import annotations

import argparse
import time
import traceback
import warnings

import numpy as np
from numpy.typing import NDArray

import asperity
import surfaces

Heights = NDArray[np.float64]


def heights_of(kind: int, rng: np.random.Generator, shape: tuple[int, int]) -> Heights:
    """Heights of one ugly kind."""
    y, x = np.indices(shape)
    noise = rng.normal(size=shape)
    match kind:
        case 0:
            return noise
        case 1:
            return np.where(rng.random(shape) < 0.02, 10.0 ** rng.uniform(0, 4), 0.1 * noise)
        case 2:
            return np.sign(x - shape[1] / 2 + 0.0 * y).astype(float)
        case 3:
            return ((x + y) % 2).astype(float)
        case 4:
            return np.round(noise * rng.choice([1, 3, 10]))
        case 5:
            return x * 1.0 + 1e-12 * noise
        case 6:
            return np.minimum(noise, rng.uniform(-1, 1)) + 10.0 ** rng.uniform(-16, -6) * noise
        case 7:
            return np.cos(2 * np.pi * x * rng.integers(1, 5) / shape[1])
        case 8:
            return -(np.hypot(x - shape[1] / 2, y - shape[0] / 2) ** rng.uniform(0.05, 8))
        case 9:
            return np.cumsum(np.cumsum(noise, axis=0), axis=1)
        case 10:
            return np.exp(rng.uniform(1, 6) * noise)
        case _:
            return (x % rng.integers(2, 9)).astype(float)


def draw(seed: int) -> tuple[surfaces.HeightMap, asperity.HalfSpace, dict]:
    """Map, body and further arguments of one case."""
    rng = np.random.default_rng(seed)
    shape = (int(rng.integers(1, 49)), int(rng.integers(1, 49)))
    heights = heights_of(int(rng.integers(12)), rng, shape) * 10.0 ** rng.uniform(-12, 2)
    if rng.random() < 0.2:
        heights = heights + 10.0 ** rng.uniform(-3, 6)
    spacing = tuple(10.0 ** rng.uniform(-9, 0) * np.array([1.0, 10.0 ** rng.uniform(-1.5, 1.5)]))
    hm = surfaces.HeightMap(heights, spacing, periodic=bool(rng.random() < 0.5))
    m = float(rng.choice([0.0, 0.0, rng.uniform(-0.99, 0.99)]))
    body = asperity.HalfSpace.from_modulus(10.0 ** rng.uniform(-3, 15), m)
    how: dict = {}
    if rng.random() < 0.7:
        how["pressures"] = body.modulus * 10.0 ** rng.uniform(-20, 1, rng.integers(1, 7))
    if rng.random() < 0.5:
        hardness = body.modulus * 10.0 ** rng.uniform(-12, 3)
        body = asperity.HalfSpace.from_modulus(body.modulus, m, hardness=hardness)
        if "pressures" in how:
            how["pressures"] = np.minimum(how["pressures"], hardness)
    return hm, body, how


def told(curve: asperity.ContactCurve) -> str:
    """What is wrong with a curve; empty if nothing is."""
    good = curve.converged
    columns = curve.separation, curve.mean_pressure, curve.contact_area
    if not all(np.isfinite(column[good]).all() for column in columns):
        return "a converged point is not finite"
    hardness = curve.settings.get("hardness", np.inf)
    if (curve.mean_pressure[good] > hardness * curve.area_fraction[good] * 1.001).any():
        return "a pressure exceeds the hardness"
    if any(not why for why in np.array(curve.reasons)[~good]):
        return "a point that did not converge has no reason"
    return ""


def main() -> int:
    """Run as asked; the number of failures is the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--maps", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--seconds", type=float, default=30.0, help="longest time of a run")
    args = parser.parse_args()
    counts = {"answered": 0, "refused": 0}
    failures, slowest = 0, 0.0
    warnings.simplefilter("error")
    warnings.simplefilter("ignore", asperity.ContactWarning)
    for seed in range(args.first, args.first + args.maps):
        for name, run in (("model", asperity.contact_curve), ("solve", asperity.solve)):
            begun, fault = time.perf_counter(), ""
            try:
                fault = told(run(*(scene := draw(seed))[:2], **scene[2]))
                counts["answered"] += 1
            except asperity.AsperityError:
                counts["refused"] += 1
            except Exception:
                fault = traceback.format_exc(limit=-2)
            seconds = time.perf_counter() - begun
            slowest = max(slowest, seconds)
            if fault or seconds > args.seconds:
                failures += 1
                print(f"seed {seed}, {name}, {seconds:.1f} s: {fault or 'too slow'}", flush=True)
        done = seed + 1 - args.first
        if done % 100 == 0 or done == args.maps:
            told_so_far = f"{counts}, {failures} failures, slowest {slowest:.1f} s"
            print(f"{done} maps, {told_so_far}", flush=True)
    return min(failures, 99)


if __name__ == "__main__":
    raise SystemExit(main())
