"""``asperity report``: one page about one or several results files."""

from __future__ import annotations

import argparse

from . import output, targets
from .batch import expand
from .messages import tell

EPILOG = """examples:
  asperity report results.h5 -o report.html
  asperity report ground.h5 polished.h5 -o both.html
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity report``."""
    parser.add_argument(
        "results",
        metavar="RESULTS",
        nargs="+",
        help="results files of compare, solve, curve or bem, and globs; several are laid side by "
        "side",
    )
    targets.add_target(
        parser,
        "-o",
        "--output",
        suffix=".html",
        default="report.html",
        help="report file (default report.html)",
    )
    targets.add_force(parser)


def run(args: argparse.Namespace) -> int:
    """Read the results, write the report, print what each says."""
    from asperity.comparison.report.build import write_report
    from asperity.comparison.report.sample import read_sample

    files = expand(args.results)
    targets.require(args, inputs=[str(file) for file in files])
    samples = [read_sample(file) for file in files]
    write_report(args.output, samples)
    for sample in samples:
        tell(f"{sample.name}: {sample.verdict()}")
    tell(f"report {args.output}")
    return output.exit_code([curve for one in samples for curve in one.curves.values()])
