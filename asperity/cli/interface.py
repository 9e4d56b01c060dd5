"""``asperity interface``: the curve of a results file as a law for finite elements."""

from __future__ import annotations

import argparse

from asperity.results.interface_law import BANDS, FORMATS, UNITS

from . import derived, output, targets
from .messages import tell

EPILOG = """example:
  asperity interface results.h5 --format abaqus --units mm-N-MPa --output law.inp
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity interface``."""
    parser.add_argument("results", metavar="RESULTS", help="results file with a curve")
    parser.add_argument("--curve", metavar="NAME", help="name of the curve (default: the first)")
    parser.add_argument("--format", choices=FORMATS, default=FORMATS[0], help="default abaqus")
    parser.add_argument("--units", choices=UNITS, default="SI", help="default SI")
    parser.add_argument("--band", choices=BANDS, default=BANDS[0], help="default pressure")
    derived.add_resistivity_option(
        parser, "thermal resistivities of both bodies [m K/W]: adds the gap conductance"
    )
    targets.add_target(
        parser,
        "-o",
        "--output",
        suffix="",
        default="law.inp",
        help="file (default law.inp)",
    )
    targets.add_force(parser)


def run(args: argparse.Namespace) -> int:
    """Read the curve, write the law."""
    from asperity.results.curve import ContactCurve, read_results

    targets.require(args, inputs=[args.results])
    name = args.curve or next(iter(read_results(args.results).curves), "")
    curve = ContactCurve.from_hdf5(args.results, name)
    law = curve.to_interface_law(**derived.conductance(curve, args))
    law.write(args.output, args.format, units=args.units, band=args.band)
    tell(f"curve           {name}\n{law}\nlaw             {args.output}")
    return output.exit_code([curve])
