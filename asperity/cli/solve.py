"""``asperity solve``: the contact curve, as accurate as asked for, by the cheaper engine."""

from __future__ import annotations

import argparse
import copy
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from asperity.halfspace.material import HalfSpace
from asperity.results.curve import ContactCurve
from surfaces.heightmap import HeightMap

from . import derived, options, output, quantities

if TYPE_CHECKING:
    from asperity.bem.curve import SolvedLoad

EPILOG = """examples:
  asperity solve scan.h5 --E 210GPa --nu 0.3 --accuracy 5%
  asperity solve scan.h5 --E 210GPa --pressure 1MPa:500MPa:30 --accuracy 2% --csv curve.csv
  asperity solve 'scans/*.h5' --E 210GPa --hardness 2GPa --fill harmonic -o solved/ --json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity solve``."""
    options.add_scene_options(parser)
    add_accuracy_options(parser)
    output.add_output_options(parser)
    derived.add_derived_options(parser)


def add_accuracy_options(parser: argparse.ArgumentParser) -> None:
    """Options of the answer that is asked for."""
    group = parser.add_argument_group("accuracy")
    group.add_argument(
        "--accuracy",
        type=quantities.of("share"),
        default=0.05,
        metavar="SHARE",
        help="relative error allowed in the load, as 0.05 or 5%% (default 5%%)",
    )
    group.add_argument(
        "--area-accuracy",
        type=quantities.of("share"),
        metavar="SHARE",
        help="relative error allowed in the contact area (default twice that)",
    )
    group.add_argument(
        "--engine",
        default="auto",
        choices=["auto", "bem", "anchored", "sampled"],
        help="auto: the cheapest; bem: boundary elements at every load; anchored: the microcontact "
        "model, anchored by boundary elements at a few loads; sampled: checked on parts of the map "
        "(default auto)",
    )


def run(args: argparse.Namespace) -> int:
    """Solve every map, write its results file and print its curve."""
    return output.each(args, _solve)


def _solve(
    hm: HeightMap, material: HalfSpace, loads: dict[str, Any], args: argparse.Namespace
) -> Mapping[str, Any]:
    from asperity.engine.solve import solve
    from asperity.halfspace.scene import checked_loads
    from asperity.results.curve import read_results
    from asperity.results.resume import require_continuable, with_held
    from asperity.results.storage import ResultFile, write_results

    settings = settings_of(args)
    request = output.request_of(hm, material, args, settings)
    judge = _Resumable(args, request)
    kind, values = checked_loads(hm, material, **loads)
    count, held = len(values), dict[str, ContactCurve]()
    if args.resume and Path(args.output).exists():
        held = require_continuable(args.output, request).curves
        values = with_held(values, kind, held.values())
    points: dict[str, Any] = {f"{kind}s": values}
    curve = solve(hm, material, **points, **settings, judge=judge)
    if judge.asked.size:  # it added to what the file held
        held = read_results(args.output).curves
    curves = {one.model: one for one in (held.get("bem"), curve) if one is not None}
    write_results(args.output, ResultFile(curves=curves, about={"request": request}))
    return output.finish(curve.select(np.arange(count)), hm, material, args)


def settings_of(args: argparse.Namespace) -> dict[str, Any]:
    """What is asked of the answer, as keyword arguments."""
    names = ("accuracy", "area_accuracy", "boundary", "engine")
    return {name: getattr(args, name) for name in names}


class _Resumable:
    """Boundary elements that keep what they solve in the results file, and go on from it."""

    def __init__(self, args: argparse.Namespace, request: dict[str, Any]) -> None:
        self.args, self.request = copy.copy(args), request
        self.asked = np.empty(0)

    def __call__(
        self,
        hm: HeightMap,
        material: HalfSpace,
        *,
        progress: Callable[[SolvedLoad], object],
        **how: Any,
    ) -> ContactCurve:
        """Solve the load points that the file lacks."""
        from asperity.bem.curve import bem_curve

        kind = "pressures" if self.args.separation is None else "separations"
        points = how.pop(kind)
        how = {name: value for name, value in how.items() if value is not None}

        tell_engine = progress

        def solve(progress: Any, **asked: Any) -> ContactCurve:
            def both(point: SolvedLoad) -> None:
                tell_engine(point)
                progress(point)

            return bem_curve(hm, material, progress=both, **asked, **how)

        self.asked = np.append(self.asked, points)
        solved = output.solve_and_keep(
            solve, hm, material, {kind: self.asked}, self.args, "bem", self.request
        )
        self.args.resume = True  # what follows is added to it
        return solved.select(np.arange(len(self.asked) - len(points), len(self.asked)))
