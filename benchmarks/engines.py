"""What the engine that `solve` chooses takes, against boundary elements and the other ones.

    python benchmarks/engines.py --points 256 512 1024 2048 4096 --seeds 2
    python benchmarks/engines.py --maps MEASURED
    python benchmarks/engines.py --families turned terraces --points 512 --seeds 7

The default loads, ten or --loads, to 5 % in load and 10 % in area. Maps: random waves of seven
spectra, the textures of textures.py with `--families`, or measured ones, free and tapered, without
and with a hardness of 0.2 E* times the rms slope. Per engine the seconds, how many loads boundary
elements solved, and the forecast; behind them the engine chosen and its time over that of boundary
elements. What the pixels leave open is not counted: each engine looks at it. Maps and engines one
after the other in one run.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Iterator
from pathlib import Path

from common import machine, measured, options
from parts import SPECTRA, waves
from textures import TEXTURES

import asperity
import surfaces
from asperity.engine.cost import can_anchor, cheapest, forecast
from asperity.engine.parts import can_sample
from asperity.halfspace.scene import default_pressures, pressure_scale
from asperity.trust.verified import Accuracy

WAVES = [*SPECTRA, {"hurst": 0.8, "cutoff": 4.0}, {"hurst": 0.5, "cutoff": 6.0, "rolloff": 40.0}]
HARDNESS = 0.2
Scene = tuple[str, surfaces.HeightMap, asperity.HalfSpace]


def scenes(args: argparse.Namespace) -> Iterator[Scene]:
    """Name, map and body of everything asked for."""
    soft = asperity.HalfSpace.from_modulus(1.0)
    for path in sorted(args.maps.glob("*.h5")) if args.maps else ():
        free = surfaces.prepare(surfaces.read(path), fill="harmonic")
        for kind, hm in (("free", free), ("tapered", measured(path))):
            hard = asperity.HalfSpace.from_modulus(
                1.0, hardness=HARDNESS * pressure_scale(hm, soft)
            )
            yield f"{path.stem} {kind}", hm, soft
            yield f"{path.stem} {kind}, hard", hm, hard
    for points in () if args.maps else args.points:
        for seed in args.seeds:
            for name in args.families:
                hm = surfaces.HeightMap(TEXTURES[name](points, seed), (1.0, 1.0), periodic=True)
                yield f"{points} {name}", hm, soft
            for recipe in () if args.families else WAVES:
                yield f"{points} {recipe}", waves(points, seed=seed, **recipe), soft


def main(args: argparse.Namespace) -> None:
    """Print a row for each map."""
    warnings.simplefilter("ignore")
    print(machine())
    hard = asperity.HalfSpace.from_modulus(1.0, hardness=0.02)
    asperity.solve(waves(1536, hurst=0.8), hard, engine="anchored")  # compiles
    worst = 0.0
    for name, hm, body in scenes(args):
        plan = asperity.make_plan(hm, body)
        loads = default_pressures(hm, body, args.loads)
        seconds = forecast(hm, body, plan.boundary, args.loads, plan)
        if not can_sample(hm, body, plan, Accuracy()):
            del seconds["sampled"]
        spent, told = {}, []
        for engine in seconds:
            curve = asperity.solve(hm, body, pressures=loads, engine=engine)
            spent[engine] = sum(v for key, v in curve.seconds.items() if key != "resolution")
            anchors = len(curve.verification["anchors"])
            told.append(f"{engine} {spent[engine]:.2f} s ({anchors}; {seconds[engine]:.2f})")
        if not can_anchor(hm, plan):
            del seconds["anchored"]
        chosen = cheapest(seconds)
        ratio = spent[chosen] / spent["bem"]
        worst = max(worst, ratio)
        print(f"{name}: {', '.join(told)}: {chosen}, {ratio:.2f}", flush=True)
    print(f"at most {worst:.2f} times boundary elements")


if __name__ == "__main__":
    parser = options(__doc__)
    parser.add_argument("--points", type=int, nargs="+", default=[256, 512, 1024, 2048])
    parser.add_argument("--seeds", type=int, nargs="+", default=[2])
    parser.add_argument("--loads", type=int, default=10)
    parser.add_argument("--families", nargs="*", default=[], choices=list(TEXTURES), metavar="NAME")
    parser.add_argument("--maps", type=Path, metavar="FOLDER", help="measured maps")
    main(parser.parse_args())
