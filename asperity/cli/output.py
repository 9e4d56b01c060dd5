"""What the sub-commands share on the way out: progress bars, file names, exit codes."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from asperity.cli.main import EXIT_NOT_CONVERGED, EXIT_OK
from asperity.errors import InputError
from asperity.results import ContactCurve

__all__ = ["add_output_options", "bar", "exit_code", "named", "save_curve"]


def add_output_options(parser: argparse.ArgumentParser, *, report: bool = False) -> None:
    """Options that say where results go."""
    group = parser.add_argument_group("output")
    group.add_argument(
        "-o", "--results", default="results.h5", help="results file (default results.h5)"
    )
    if report:
        group.add_argument(
            "--report", default="report.html", help="report file (default report.html)"
        )
    group.add_argument("--csv", metavar="FILE", help="also write the curve as CSV")


def bar(total: int | None, label: str) -> tuple[Any, Callable[[Any], None]]:
    """A progress bar (nothing when not a terminal) and the function that advances it by one."""
    from tqdm import tqdm

    shown = tqdm(total=total, desc=label, disable=None, leave=False)
    return shown, lambda _: shown.update(1)


def named(file: str, stem: str, several: bool) -> str:
    """File name for the results of one of several inputs: the input's name goes in front."""
    target = Path(file)
    return str(target.with_name(f"{stem}-{target.name}")) if several else file


def save_curve(curve: ContactCurve, args: argparse.Namespace) -> None:
    """Write the curve to the results file, and to CSV where asked."""
    from asperity.results import POINT_FIELDS
    from asperity.storage import write_csv

    curve.to_hdf5(args.results)
    if args.csv:
        write_csv(args.csv, {name: getattr(curve, name) for name in POINT_FIELDS})


def exit_code(curves: Iterable[ContactCurve]) -> int:
    """0 if every load point converged, else 1."""
    return EXIT_OK if all(c.converged.all() for c in curves) else EXIT_NOT_CONVERGED


def require_folder(*files: str | None) -> None:
    """Refuse, before any work, a result file whose folder does not exist."""
    for file in files:
        if file and not Path(file).absolute().parent.is_dir():
            raise InputError(f"cannot write {file}: its folder does not exist")
