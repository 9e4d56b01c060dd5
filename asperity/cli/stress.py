"""``asperity stress``: stiff and extreme cases through every engine, each judged."""

from __future__ import annotations

import argparse
import sys
from dataclasses import fields

from . import targets
from .exit_codes import EXIT_NOT_CONVERGED, EXIT_OK

EPILOG = """examples:
  asperity stress -o stress.csv
  asperity stress --theme textures -o textures.csv
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity stress``."""
    parser.add_argument("--theme", help="cases of one theme only, such as loads or textures")
    targets.add_target(parser, "-o", "--output", suffix=".csv", help="write every case as CSV")
    targets.add_force(parser)


def run(args: argparse.Namespace) -> int:
    """Run the cases; print the table and whatever failed."""
    from asperity.errors import InputError
    from asperity.progress import bar
    from asperity.results.storage import write_csv
    from asperity.stress.table import FAILURE, Row, cases, summary
    from asperity.stress.table import run as rows_of

    targets.require(args)
    chosen = cases(args.theme)
    if not chosen:
        known = ", ".join(dict.fromkeys(case.theme for case in cases()))
        raise InputError(f"--theme {args.theme}: there is none of this name; there are {known}")
    rows = []
    with bar(len(chosen), "cases") as advance:
        for row in rows_of(chosen):
            rows.append(row)
            advance(row)
    if args.output:
        names = [field.name for field in fields(Row)]
        write_csv(args.output, {name: [getattr(row, name) for row in rows] for name in names})
    table = summary(rows)
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    for line in table:
        print("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)))
    failed = [row for row in rows if row.outcome == FAILURE]
    for row in failed:
        sys.stderr.write(
            f"{row.theme}, {row.case}, {row.engine}, {row.against}: {row.reason} "
            f"(error {row.error_over_allowance:.3g} of what is allowed)\n"
        )
    print(f"{len(rows)} cases, {len(failed)} failures, {sum(r.seconds for r in rows):.0f} s")
    return EXIT_NOT_CONVERGED if failed else EXIT_OK
