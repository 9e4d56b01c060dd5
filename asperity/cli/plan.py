"""``asperity plan``: what a scene needs and what is left out; nothing is run."""

from __future__ import annotations

import argparse

from . import options

EPILOG = """example:
  asperity plan scan.h5 --E 210e9 --pressure 1e6:5e8:30
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity plan``."""
    parser.epilog = EPILOG
    options.add_surface_options(parser)
    options.add_material_options(parser)
    options.add_load_options(parser)
    options.add_model_options(parser)


def run(args: argparse.Namespace) -> int:
    """Print the plan."""
    from asperity.model.plan import make_plan

    from .exit_codes import EXIT_OK

    material, loads = options.material(args), options.loads(args)
    hm = options.load_surface(args.file, args)
    print(hm)
    print(make_plan(hm, material, **loads, **options.model(args)))
    return EXIT_OK
