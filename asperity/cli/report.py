"""``asperity report``: one page about one or several results files."""

from __future__ import annotations

import argparse
from pathlib import Path

from asperity.errors import InputError

from . import output
from .surface import expand

EPILOG = """examples:
  asperity report results.h5 -o report.html
  asperity report ground.h5 polished.h5 -o both.html
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity report``."""
    parser.epilog = EPILOG
    parser.add_argument(
        "results",
        metavar="RESULTS",
        nargs="+",
        help="results files of compare, solve, curve or bem; several are laid side by side",
    )
    parser.add_argument(
        "-o", "--output", default="report.html", help="report file (default report.html)"
    )
    parser.add_argument("--force", action="store_true", help="replace a report that is there")


def run(args: argparse.Namespace) -> int:
    """Read the results, write the report, print what each says."""
    from asperity.comparison.report.build import write_report
    from asperity.comparison.report.sample import read_sample

    files = expand(args.results)
    output.require_outputs(args.output, inputs=files)
    if Path(args.output).exists() and not args.force:
        raise InputError(f"{args.output} is there already; --force replaces it")
    samples = [read_sample(file) for file in files]
    write_report(args.output, samples)
    for sample in samples:
        print(f"{sample.name}: {sample.verdict()}")
    print(f"report {args.output}")
    return output.exit_code(curve for one in samples for curve in one.curves.values())
