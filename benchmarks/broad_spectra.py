"""Broad spectra: error and time of the contact model and of boundary elements on several grids.

    python benchmarks/broad_spectra.py --seeds 21 22
    python benchmarks/broad_spectra.py --families "to the pixel" --points 1024
    python benchmarks/broad_spectra.py --families graded lay --ways contacts --seeds 31 32

Mean pressures (`--loads`, in units of the pressure that flattens the map) for about 0.4, 2, 8, 15
and 25 % of contact on periodic maps, rms slope 0.1, roll-off an eighth of the side; graded bodies
and lay to the pixel. The reference is solved by boundary elements on the map refined twice by its
own Fourier series. Load error at equal separation (from the separation at equal load), area error
at equal load, processor seconds of all loads, map in memory to curve, compiled before.

Ways: contacts at all summits; the finest waves as a law of the contacts of the others
(`scales="auto"`); boundary elements on the full and on coarser grids.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import asperity
import surfaces
from asperity.loadpoints import pressure_scale

Array = NDArray[np.float64]
Result = tuple[Array, Array, float]

LOADS = np.array([0.002, 0.01, 0.04, 0.08, 0.14])
Body = asperity.HalfSpace


def families(points: int, seed: int) -> dict[str, surfaces.HeightMap]:
    """Maps of pixel size 1; those of graded bodies are named so (`body_of`)."""

    def rough(hurst: float, cutoff: float | None, lay: float = 1.0) -> surfaces.HeightMap:
        return surfaces.self_affine(
            (points, points),
            (float(points), float(points)),
            hurst=hurst,
            rms_slope=0.1,
            rolloff=points / 8,
            cutoff=cutoff,
            anisotropy=lay,
            seed=seed,
        )

    return {
        "to the pixel H 0.8": rough(0.8, None),
        "to the pixel H 0.5": rough(0.5, None),
        "cut-off 4 px H 0.8": rough(0.8, 4.0),
        "cut-off 32 px H 0.8": rough(0.8, 32.0),
        "graded m = 0.3, H 0.8": rough(0.8, None),
        "graded m = -0.3, H 0.8": rough(0.8, None),
        "lay 2:1, H 0.8": rough(0.8, None, 2.0),
        "lay 4:1, H 0.8": rough(0.8, None, 4.0),
    }


def body_of(name: str) -> asperity.HalfSpace:
    """Body of a family."""
    m = float(name.split("=")[1].split(",")[0]) if name.startswith("graded") else 0.0
    return asperity.HalfSpace.from_modulus(1.0, m=m)


def model(hm: surfaces.HeightMap, body: Body, pressures: Array, scales: str) -> Result:
    """Separation, area fraction and time of the contact model."""
    start = time.process_time()
    curve = asperity.contact_curve(hm, body, pressures=pressures, scales=scales)
    return curve.separation, curve.area_fraction, time.process_time() - start


def elements(hm: surfaces.HeightMap, body: Body, pressures: Array, step: int) -> Result:
    """The same of boundary elements on a grid coarser by `step`."""
    start = time.process_time()
    grid = hm if step == 1 else surfaces.resample(hm, step * np.asarray(hm.spacing))
    curve = asperity.bem_curve(grid, body, pressures=pressures, tolerance=1e-2)
    return curve.separation, curve.area_fraction, time.process_time() - start


WAYS: dict[str, Callable[[surfaces.HeightMap, Body, Array], Result]] = {
    "contacts, all summits": lambda hm, body, p: model(hm, body, p, "all"),
    "contacts, law of fine waves": lambda hm, body, p: model(hm, body, p, "auto"),
    "elements": lambda hm, body, p: elements(hm, body, p, 1),
    "elements, grid / 2": lambda hm, body, p: elements(hm, body, p, 2),
    "elements, grid / 4": lambda hm, body, p: elements(hm, body, p, 4),
}


def main() -> None:
    """Run all ways on all families and print one line for each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=512)
    parser.add_argument("--seeds", type=int, nargs="+", default=[21])
    parser.add_argument("--families", nargs="*", default=[], help="parts of family names")
    parser.add_argument("--ways", nargs="*", default=[], help="parts of the names of the ways")
    parser.add_argument("--loads", type=float, nargs="+", default=LOADS.tolist())
    args = parser.parse_args()
    ways = {
        name: way
        for name, way in WAYS.items()
        if not args.ways or any(part in name for part in args.ways)
    }
    small, body = families(128, 1)["to the pixel H 0.8"], body_of("")
    for way in ways.values():
        way(small, body, LOADS[:2] * pressure_scale(small, body))
    for seed in args.seeds:
        for name, hm in families(args.points, seed).items():
            if args.families and not any(part in name for part in args.families):
                continue
            body = body_of(name)
            pressures = np.array(args.loads) * pressure_scale(hm, body)
            refined = surfaces.resample(hm, 0.5 * np.asarray(hm.spacing))
            exact = asperity.bem_curve(refined, body, pressures=pressures, tolerance=1e-4)
            fall = -np.gradient(exact.separation, np.log(pressures))
            area = " ".join(f"{100 * a:.1f}" for a in exact.area_fraction)
            print(f"{name}, seed {seed}: contact {area} %")
            for way, run in ways.items():
                found = run(hm, body, pressures)
                load = np.expm1((found[0] - exact.separation) / fall)
                errors = (load, found[1] / exact.area_fraction - 1)
                loads, areas = (" ".join(f"{100 * e:+6.1f}" for e in error) for error in errors)
                print(f"  {way:32s} load {loads}   area {areas}   {found[2]:.2f} s")


if __name__ == "__main__":
    main()
