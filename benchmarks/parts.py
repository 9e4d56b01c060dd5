"""The model checked on parts of a map: whether its bounds hold, and what it costs.

    python benchmarks/parts.py --points 1536 --seeds 75 76
    python benchmarks/parts.py --time --points 2048 4096

Maps of random waves, drawn: Hurst exponent, cut-off, roll-off, lay to 3.5:1, grading and border
(those drawn with a hardness are left out: parts do not tell of them); hills with a band of short
waves; and the textures of `textures.py` whose finest waves are random. The truth is a curve of
boundary elements to 1 % in area. `--time`: elastic waves of five spectra, `solve` by parts against
boundary elements to the accuracy asked for, alternately in one run.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from common import machine
from textures import TEXTURES

import asperity
import surfaces
from asperity.engine.parts import can_sample
from asperity.halfspace.scene import default_pressures
from asperity.trust.verified import Accuracy

DRAWN, HILLS = 14, 8
SPECTRA: list[dict[str, float]] = [
    {"hurst": 0.8},
    {"hurst": 0.5},
    {"hurst": 0.8, "cutoff": 10.0, "rolloff": 200.0},
    {"hurst": 0.8, "rolloff": 100.0},
    {"hurst": 0.6, "cutoff": 8.0, "rolloff": 60.0},
]
Scene = tuple[str, surfaces.HeightMap, asperity.HalfSpace, str | None]


def waves(points: int, **recipe: Any) -> surfaces.HeightMap:
    """Random waves on pixels of unit length."""
    size = (float(points), float(points))
    return surfaces.self_affine((points, points), size, rms_slope=0.1, **recipe)


def scenes(points: int, seed: int) -> Iterator[Scene]:
    """Textures and drawn waves of one seed."""
    for name, make in TEXTURES.items():
        hm = surfaces.HeightMap(make(points, seed), (1.0, 1.0), periodic=True)
        yield name, hm, asperity.HalfSpace.from_modulus(1.0), None
    rng = np.random.default_rng(seed)
    for i in range(DRAWN):
        recipe: dict[str, Any] = {"hurst": rng.uniform(0.2, 1.0), "seed": 100 * seed + i}
        if rng.random() < 0.6:
            recipe["cutoff"] = rng.uniform(2.0, 24.0)
        if rng.random() < 0.6:
            recipe["rolloff"] = np.exp(rng.uniform(np.log(40.0), np.log(points / 2)))
        if rng.random() < 0.3:
            recipe["anisotropy"] = rng.uniform(1.0, 3.5)
        m, hardness = (
            rng.choice([0.0, 0.0, 0.0, 0.3, -0.3]),
            rng.choice([np.inf, np.inf, 0.2, 0.05]),
        )
        body = asperity.HalfSpace.from_modulus(1.0, m, hardness=0.1 * hardness)
        told = " ".join(f"{key} {value:.3g}" for key, value in recipe.items())
        border = "free" if rng.random() < 0.25 else None
        yield f"{told} m {m} x {hardness} {border}", waves(points, **recipe), body, border
    for i in range(HILLS):
        name, hm = hills(points, rng, 100 * seed + 50 + 2 * i)
        yield name, hm, asperity.HalfSpace.from_modulus(1.0), None


def hills(points: int, rng: np.random.Generator, seed: int) -> tuple[str, surfaces.HeightMap]:
    """Long waves, of up to the size of the map, and a band of short ones."""
    shortest, longest = np.exp(rng.uniform(np.log((16.0, 100.0)), np.log((100.0, points))))
    cutoff = rng.uniform(2.5, 12.0)
    share, wide = np.exp(rng.uniform(np.log(0.02), np.log(0.3))), rng.uniform(1.5, 4.0)
    long = waves(points, hurst=1.0, cutoff=shortest, rolloff=longest, seed=seed)
    short = waves(points, hurst=0.8, cutoff=cutoff, rolloff=wide * cutoff, seed=seed + 1)
    rms = long.roughness.rms_height / short.roughness.rms_height
    told = f"hills {shortest:.0f} to {longest:.0f}, waves {cutoff:.1f} to {wide * cutoff:.1f}"
    hm = long.replace(heights=long.heights + share * rms * short.heights)
    return f"{told} x {share:.2g}", hm


def judge(points: int, seed: int) -> list[np.ndarray]:
    """Errors over bounds of load and area, shape (2, n) for each map that parts answer."""
    found = []
    for name, hm, body, border in scenes(points, seed):
        if not can_sample(hm, body, asperity.make_plan(hm, body, boundary=border), Accuracy()):
            continue
        loads = default_pressures(hm, body, 8)
        true = asperity.bem_curve(hm, body, pressures=loads, accuracy=0.01, boundary=border)
        curve = asperity.solve(hm, body, pressures=loads, engine="sampled", boundary=border)
        if curve.settings["engine"] != "sampled":
            print(f"{name}: left to boundary elements", flush=True)
            continue
        rate = true.stiffness / true.mean_pressure
        off = [rate * (curve.separation - true.separation), curve.contact_area / true.contact_area]
        off[1] = np.log(off[1])
        bound = np.array([curve.error_estimate, curve.extra["area_error_estimate"]])
        bound += [true.error_estimate, true.extra["area_error_estimate"]]
        found.append(np.abs(off) / bound)
        worst = " ".join(
            f"{error:.3f} ({share:.2f} of its bound)"
            for error, share in zip(np.abs(off).max(axis=1), found[-1].max(axis=1), strict=True)
        )
        anchors = len(curve.verification["anchors"])
        print(f"{name}: off by {worst}; {anchors} points by boundary elements of all", flush=True)
    return found


def timed(points: int, seed: int) -> None:
    """Seconds of `solve` by parts and of boundary elements alone."""
    body = asperity.HalfSpace.from_modulus(1.0)
    for recipe in SPECTRA:
        hm = waves(points, seed=seed, **recipe)
        curve = asperity.contact_curve(hm, body)
        loads = curve.mean_pressure[curve.converged]
        begun = time.perf_counter()
        asperity.bem_curve(hm, body, pressures=loads, accuracy=0.1)
        middle = time.perf_counter()
        asperity.solve(hm, body, pressures=loads, engine="sampled")
        alone, parts = middle - begun, time.perf_counter() - middle
        print(f"{points} {recipe}: {alone:.2f} / {parts:.2f} s = {alone / parts:.2f}", flush=True)


def main() -> None:
    """ReferenceSolver or time."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, nargs="+", default=[1536])
    parser.add_argument("--seeds", type=int, nargs="+", default=[51])
    parser.add_argument("--time", action="store_true")
    args = parser.parse_args()
    warnings.simplefilter("ignore")
    print(machine())
    asperity.solve(waves(1536, hurst=0.8), asperity.HalfSpace.from_modulus(1.0), engine="sampled")
    for points in args.points:
        found = []
        for seed in args.seeds:
            if args.time:
                timed(points, seed)
            else:
                found += judge(points, seed)
        if found:
            ratio = np.concatenate(found, axis=1)
            inside = 100.0 * (ratio <= 1.0).mean(axis=1)
            print(
                f"{ratio.shape[1]} points: load inside its bound {inside[0]:.1f} %, area "
                f"{inside[1]:.1f} %, beyond twice {(ratio > 2.0).sum(axis=1)}"
            )


if __name__ == "__main__":
    main()
