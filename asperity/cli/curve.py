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
    from asperity.contacts import microcontacts
    from asperity.curve import solve_contacts
    from asperity.loadpoints import checked_loads
    from asperity.plan import make_plan
    from asperity.storage import write_csv

    output.require_folder(args.results, args.csv, args.contacts)
    material, loads = options.material(args), options.loads(args)
    hm = options.load_surface(args.file, args)
    plan = make_plan(hm, material, **loads, **options.model(args))
    _, values = checked_loads(hm, material, loads.get("pressures"), loads.get("separations"))
    shown, advance = output.bar(len(values), "load points")
    with shown:
        done = solve_contacts(hm, material, plan, **loads, progress=advance)
    output.save_curve(done.curve, args)
    if args.contacts:
        table = microcontacts(done.bodies, done.states[-1])
        write_csv(args.contacts, {name: table[name] for name in table.dtype.names})
    print(done.curve)
    print(f"results         {args.results}")
    return output.exit_code([done.curve])
