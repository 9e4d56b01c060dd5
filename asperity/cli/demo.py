"""``asperity demo``: make a surface, run both models, write the report, print the verdict."""

from __future__ import annotations

import argparse
from pathlib import Path

from asperity.progress import bar
from surfaces.files.atomic import make_folder

from . import output, quantities, targets
from .messages import tell

EPILOG = """example:
  asperity demo -o demo
"""

POINTS, SIZE = 256, 1e-3
"""Points along a side of the surface, and its length [m]."""

STEEL, POISSON = 210e9, 0.3
"""Young's modulus [Pa] and Poisson's ratio of the body."""

HARDNESS = 2e9
"""Hardness [Pa] of a mild steel."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity demo``."""
    parser.add_argument(
        "-o",
        "--output",
        default=".",
        metavar="DIR",
        help="folder for surface.h5, results.h5 and report.html (default: this one)",
    )
    parser.add_argument(
        "--seed",
        type=quantities.whole(),
        default=1,
        metavar="X",
        help="seed of the surface (default 1)",
    )
    targets.add_force(parser)


def run(args: argparse.Namespace) -> int:
    """Generate a self-affine steel surface of 1 mm and compare both models on it."""
    import surfaces
    from asperity.comparison.run import compare
    from asperity.halfspace.material import HalfSpace

    folder = Path(args.output)
    made = surface, results, report = [
        folder / name for name in ("surface.h5", "results.h5", "report.html")
    ]
    make_folder(folder)
    for file in made:
        targets.require_place(file, args.force)
    hm = surfaces.self_affine(
        (POINTS, POINTS),
        (SIZE, SIZE),
        hurst=0.8,
        rms_slope=0.1,
        rolloff=SIZE / 8,
        cutoff=SIZE * 8 / POINTS,
        seed=args.seed,
    ).replace(name="demo")
    surfaces.write(hm, surface)
    with bar(None, "demo") as advance:
        steel = HalfSpace(STEEL, POISSON, hardness=HARDNESS)
        comparison = compare(hm, steel, progress=advance)
    comparison.to_hdf5(results)
    comparison.to_html(report)
    tell(f"{comparison}\nsurface {surface}, results {results}\nreport  {report}")
    return output.exit_code([comparison.model, comparison.reference])
