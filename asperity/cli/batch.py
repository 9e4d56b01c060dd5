"""Many inputs, one mechanism: go on past a bad file, end with one table and one exit code."""

from __future__ import annotations

import argparse
import glob
import shutil
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from asperity.errors import AsperityError, ConvergenceError
from asperity.progress import bar

from . import targets
from .exit_codes import EXIT_BAD_INPUT, EXIT_NOT_CONVERGED, EXIT_OK
from .messages import error_text, tell, warn, warnings_told

Work = Callable[[argparse.Namespace], Mapping[str, Any]]
"""Does the work on the input ``file`` of the options and returns what it found, by name.

Numbers and words are a row of the table; lists and mappings are told by ``--json`` alone.  An entry
``converged`` or ``valid`` that is false decides on the exit code, ``reason`` says why.
"""

WIDEST_CELL = 44
"""Most characters of a cell on the terminal."""


def add_files(parser: argparse.ArgumentParser, count: str = "+") -> None:
    """The inputs; with the count "*" there may be none."""
    parser.add_argument(
        "files", nargs=count, metavar="FILE", help="files and globs, which may be quoted"
    )


def add_table(parser: Any, several: str | None = None) -> None:
    """Options of what is told of all inputs; `several` is the table that several inputs leave."""
    known = f"; {several} for several files" if several else ""
    what = f"CSV table with a row per file{known}"
    targets.add_target(parser, "--table", suffix=".csv", one=True, several=several, help=what)
    add_json(parser)


def add_json(parser: Any) -> None:
    """Option for results that programs read."""
    parser.add_argument(
        "--json", action="store_true", help="results as JSON on standard output, text on the other"
    )


def expand(patterns: Sequence[str]) -> list[Path]:
    """Files of names and glob patterns, in order, each once; a pattern without match is a name."""
    names = [
        name
        for word in patterns
        for name in (not Path(word).exists() and sorted(glob.glob(word, recursive=True))) or [word]
    ]
    return [*dict.fromkeys(Path(name) for name in names)]


def each(args: argparse.Namespace, work: Work) -> int:
    """Do the work on every input, tell the table and return the exit code.

    A bad input is one sentence on standard error and a row with the reason; the others go on.
    """
    files = expand(args.files)
    several = len(files) > 1
    targets.fill_in(args, several)
    runs = [targets.of_input(args, file, several) for file in files]
    against = getattr(args, "against", None)
    targets.require(args, runs, inputs=[against] if against else [])
    rows, code = [], EXIT_OK
    with bar(len(files), "files", hidden=None if several else True) as advance:
        for run in runs:
            row, result = _one(run, work)
            rows.append(row)
            code = max(code, result)
            advance(run)
            sys.stdout.flush()
    args.document = rows
    if several:
        tell(table_text(rows))
    if args.table:
        from asperity.results.storage import write_csv

        names = _columns(rows)
        cells = {name: [row.get(name, "") for row in rows] for name in names}
        write_csv(args.table, {name: np.array(cells[name], object) for name in names})
        tell(f"table           {args.table}")
    return code


def _one(run: argparse.Namespace, work: Work) -> tuple[dict[str, Any], int]:
    """Row and exit code of one input."""
    try:
        with warnings_told(run):
            found = work(run)
    except (AsperityError, MemoryError) as error:
        text = error_text(run.file, error)
        warn(run, text)
        reason = text.removeprefix(f"{run.file}: ")
        bad = not isinstance(error, ConvergenceError)
        return {"file": run.file, "reason": reason}, EXIT_BAD_INPUT if bad else EXIT_NOT_CONVERGED
    code = EXIT_OK if found.get("converged", True) else EXIT_NOT_CONVERGED
    code = code if found.get("valid", True) else EXIT_BAD_INPUT
    return {"file": run.file, **found, "reason": found.get("reason", "")}, code


def _columns(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Names of what a table can hold, the reason last."""
    names = [
        name
        for row in rows
        for name, value in row.items()
        if isinstance(value, str | bool | int | float | np.generic)
    ]
    return [*dict.fromkeys(name for name in names if name != "reason"), "reason"]


def table_text(rows: Sequence[Mapping[str, Any]]) -> str:
    """The table in columns, words to the left and numbers to the right."""
    names = _columns(rows)
    if not any(row["reason"] for row in rows):
        names.remove("reason")
    lines = [names, *([_cell(name, row.get(name, "")) for name in names] for row in rows)]
    words = [any(isinstance(row.get(name), str) for row in rows) for name in names]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    kept: list[int] = []
    room = shutil.get_terminal_size((sys.maxsize, 0)).columns
    for place in sorted(range(len(names)), key=lambda place: names[place] != "reason"):
        room -= widths[place] + 2
        if room >= -2 or not kept:
            kept.append(place)
    form = ["<" if word else ">" for word in words]
    shown = [[f"{line[i]:{form[i]}{widths[i]}}" for i in sorted(kept)] for line in lines]
    left = len(names) - len(kept)
    more = [f"({left} more columns in the file of --table)"] if left else []
    return "\n".join(["", *("  ".join(line).rstrip() for line in shown), *more])


def _cell(name: str, value: Any) -> str:
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float | np.floating):
        number = float(value)
        return f"{number:.0f}" if number.is_integer() and abs(number) < 1e6 else f"{number:.4g}"
    text = str(value)
    if len(text) <= WIDEST_CELL:
        return text
    return f"{text[: WIDEST_CELL - 3]}..." if name == "reason" else f"...{text[3 - WIDEST_CELL :]}"
