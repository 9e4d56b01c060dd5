"""``asperity curve``: load, separation and contact area from the sum of microcontacts."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from functools import partial
from typing import Any

from asperity.halfspace.material import HalfSpace
from surfaces.heightmap import HeightMap

from . import derived, options, output, targets
from .messages import warn

EPILOG = """examples:
  asperity curve scan.h5 --E 210GPa --nu 0.3 --pressure 1MPa:500MPa:30 --plot curve.png
  asperity curve 'scans/*.h5' --E 210GPa --load 10N --fill harmonic -o curves/ --table load.csv
  asperity curve scan.h5 --E 210GPa --contacts contacts.csv --spots spots.csv --fields last.vti
  asperity curve scan.h5 --E 210GPa --resistivity 1e-7 1e-7 --friction 0.3 --slip slip.csv
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity curve``."""
    options.add_scene_options(parser)
    options.add_model_options(parser)
    output.add_output_options(parser)
    for name, what in (
        ("--contacts", "CSV table of the microcontacts, last point"),
        ("--spots", "CSV table of the separate spots, last point"),
        ("--sizes", "CSV table of the spots by their area, last point"),
    ):
        targets.add_target(parser, name, suffix=".csv", help=what)
    output.add_fields_option(parser, "pressure and contact")
    derived.add_derived_options(parser)


def run(args: argparse.Namespace) -> int:
    """Solve every map, write its results file and print its curve."""
    return output.each(args, _solve)


def _solve(
    hm: HeightMap, material: HalfSpace, loads: dict[str, Any], args: argparse.Namespace
) -> Mapping[str, Any]:
    from asperity.compilation import compile_ahead, curve_parts
    from asperity.curve import contact_curve
    from asperity.model.plan import make_plan

    compile_ahead(*curve_parts(material.hardness))
    plan = make_plan(hm, material, **loads, **options.model(args))
    solve = partial(contact_curve, hm, material, plan=plan)
    request = output.request_of(hm, material, args, options.model(args))
    curve = output.solve_and_keep(
        solve, hm, material, loads, args, "asperity", request, chained=True
    )
    if (args.contacts or args.spots or args.sizes or args.fields) and output.last_converged(
        curve, args
    ):
        _write_last_point(hm, material, plan, curve, args)
    return output.finish(curve, hm, material, args)


def _write_last_point(hm, material, plan, curve, args) -> None:  # type: ignore[no-untyped-def]
    from asperity.contacts.run import solve_contacts
    from asperity.contacts.table import size_distribution
    from asperity.results.paraview import write_vti
    from asperity.results.storage import columns, write_csv

    last = solve_contacts(hm, material, plan, pressures=curve.mean_pressure[-1:])
    if args.contacts:
        if plan.sub_contact_law is not None:
            text = "contacts are of the longer waves; fine ones part them into spots (--spots)"
            warn(args, text)
        write_csv(args.contacts, columns(last.microcontacts()))
    if args.spots or args.sizes:
        spots = last.spots()
        if args.spots:
            write_csv(args.spots, columns(spots))
        if args.sizes:
            write_csv(args.sizes, columns(size_distribution(spots["area"])))
    if args.fields:
        pressure = last.pressure_map()
        write_vti(args.fields, {"pressure": pressure, "contact": pressure > 0}, hm.spacing)
