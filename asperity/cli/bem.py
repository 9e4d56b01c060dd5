"""``asperity bem``: the contact curve from the full boundary-element solution."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from functools import partial
from typing import Any

from asperity.halfspace.material import HalfSpace
from surfaces.heightmap import HeightMap

from . import derived, options, output

EPILOG = """example:
  asperity bem scan.h5 --E 210GPa --nu 0.3 --pressure 1MPa:500MPa:10 --tolerance 1e-6
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity bem``."""
    options.add_scene_options(parser)
    options.add_tolerance_option(parser)
    output.add_output_options(parser)
    output.add_fields_option(parser, "pressure and gap")
    derived.add_derived_options(parser)


def run(args: argparse.Namespace) -> int:
    """Solve every map, write its results file and print its curve."""
    return output.each(args, _solve)


def _solve(
    hm: HeightMap, material: HalfSpace, loads: dict[str, Any], args: argparse.Namespace
) -> Mapping[str, Any]:
    from asperity.bem.curve import bem_curve

    settings = options.elements(args)
    solve = partial(bem_curve, hm, material, **settings)
    request = output.request_of(hm, material, args, settings)
    curve = output.solve_and_keep(solve, hm, material, loads, args, "bem", request)
    if args.fields and output.last_converged(curve, args):
        _write_fields(hm, material, settings, curve, args.fields)
    return output.finish(curve, hm, material, args)


def _write_fields(hm, material, settings, curve, path) -> None:  # type: ignore[no-untyped-def]
    from asperity.bem.solve import bem_solve
    from asperity.results.paraview import write_vti

    last = bem_solve(hm, material, pressure=float(curve.mean_pressure[-1]), **settings)
    fields = {"pressure": last.pressure, "gap": last.gap}
    if last.saturated.any():
        fields["plastic_depth"] = last.plastic_depth
    write_vti(path, fields, hm.spacing)
