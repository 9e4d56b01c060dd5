"""``asperity report``: rebuild the report from a results file."""

from __future__ import annotations

import argparse

from . import output

EPILOG = """example:
  asperity report results.h5 -o report.html
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity report``."""
    parser.epilog = EPILOG
    parser.add_argument("results", metavar="RESULTS", help="results file of asperity compare")
    parser.add_argument(
        "-o", "--output", default="report.html", help="report file (default report.html)"
    )


def run(args: argparse.Namespace) -> int:
    """Read the results, write the report, print the verdict."""
    from asperity.comparison.result import Comparison

    output.require_outputs(args.output, inputs=[args.results])
    comparison = Comparison.from_hdf5(args.results)
    comparison.to_html(args.output)
    print(comparison.verdict())
    print(f"report {args.output}")
    return output.exit_code([comparison.model, comparison.reference])
