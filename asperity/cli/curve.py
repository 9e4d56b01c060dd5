"""``asperity curve``: load, separation and contact area from the sum of microcontacts."""

from __future__ import annotations

import argparse

from asperity.cli import options, output

EPILOG = """example:
  asperity curve scan.h5 --E 210e9 --nu 0.3 --pressure 1e6:5e8:30
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity curve``."""
    parser.epilog = EPILOG
    options.add_surface_options(parser)
    options.add_material_options(parser)
    options.add_load_options(parser)
    options.add_model_options(parser)
    output.add_output_options(parser)
    parser.add_argument("--contacts", metavar="CSV", help="table of the microcontacts, last point")


def run(args: argparse.Namespace) -> int:
    """Solve, write the results file and print the curve."""
    output.require_folder(args.results, args.csv, args.contacts)
    material, loads = options.material(args), options.loads(args)
    hm = options.load_surface(args.file, args)
    from asperity.curve import contact_curve
    from asperity.plan import make_plan

    plan = make_plan(hm, material, **loads, **options.model(args))

    def solve(kind, values, progress, checkpoint):  # type: ignore[no-untyped-def]
        return contact_curve(
            hm, material, **{kind: values}, plan=plan, progress=progress, checkpoint=checkpoint
        )

    curve = output.solve_and_keep(solve, hm, material, loads, args, options.model(args))
    if args.contacts:
        _write_contacts(hm, material, plan, curve, args.contacts)
    return output.finish(curve, args)


def _write_contacts(hm, material, plan, curve, path) -> None:  # type: ignore[no-untyped-def]
    from asperity.contacts import microcontacts
    from asperity.curve import solve_contacts
    from asperity.storage import write_csv

    last = solve_contacts(hm, material, plan, separations=curve.separation[-1:])
    table = microcontacts(last.bodies, last.states[0])
    write_csv(path, {name: table[name] for name in table.dtype.names})
