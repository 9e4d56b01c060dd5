"""``asperity report``: rebuild the report from a results file."""

from __future__ import annotations

import argparse

from . import output, targets
from .messages import tell

EPILOG = """example:
  asperity report results.h5 -o report.html
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity report``."""
    parser.epilog = EPILOG
    parser.add_argument("results", metavar="RESULTS", help="results file of asperity compare")
    targets.add_target(
        parser,
        "-o",
        "--output",
        suffix=targets.ONE,
        alone="report.html",
        help="report file (default report.html)",
    )
    targets.add_force(parser)


def run(args: argparse.Namespace) -> int:
    """Read the results, write the report, print the verdict."""
    from asperity.comparison.result import Comparison

    targets.fill_in(args)
    targets.require(args, inputs=[args.results])
    comparison = Comparison.from_hdf5(args.results)
    comparison.to_html(args.output)
    tell(f"{comparison.verdict()}\nreport {args.output}")
    return output.exit_code([comparison.model, comparison.reference])
