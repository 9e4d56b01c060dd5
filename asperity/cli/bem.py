"""``asperity bem``: the contact curve from the full boundary-element solution."""

from __future__ import annotations

import argparse

from asperity.cli import options, output

EPILOG = """example:
  asperity bem scan.h5 --E 210e9 --nu 0.3 --pressure 1e6:5e8:10 --tolerance 1e-6
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity bem``."""
    parser.epilog = EPILOG
    options.add_surface_options(parser)
    options.add_material_options(parser)
    options.add_load_options(parser)
    parser.add_argument(
        "--tolerance", type=float, default=1e-6, help="bound of the certificate (default 1e-6)"
    )
    output.add_output_options(parser)


def run(args: argparse.Namespace) -> int:
    """Solve, write the results file and print the curve."""
    from asperity.bem import bem_curve
    from asperity.loadpoints import checked_loads

    output.require_folder(args.results, args.csv)
    material, loads = options.material(args), options.loads(args)
    hm = options.load_surface(args.file, args)
    _, values = checked_loads(hm, material, loads.get("pressures"), loads.get("separations"))
    shown, advance = output.bar(len(values), "load points")
    with shown:
        curve = bem_curve(
            hm,
            material,
            **loads,
            tolerance=args.tolerance,
            boundary=args.boundary,
            progress=advance,
        )
    output.save_curve(curve, args)
    print(curve)
    print(f"results         {args.results}")
    return output.exit_code([curve])
