"""``asperity sweep``: many maps, materials and settings on many workers, and one index of all."""

from __future__ import annotations

import argparse
import copy
import csv
import itertools
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from asperity.errors import InputError
from asperity.progress import bar
from surfaces.files.arrays import heading

from . import batch, options, quantities, targets
from .exit_codes import EXIT_BAD_INPUT, EXIT_NOT_CONVERGED, EXIT_OK
from .messages import error_text, tell
from .solve import add_accuracy_options, settings_of

if TYPE_CHECKING:
    from asperity.distributed.jobs import Job

EPILOG = """examples:
  asperity sweep 'scans/*.h5' --E 210GPa 70GPa --hardness 1GPa 2GPa --workers 2 -o sweep/
  asperity sweep 'scans/*.h5' --config plan.toml -o sweep/
  asperity sweep plan.toml --fill harmonic -o planned/ --json

A .toml file is a plan: its keys are options, written without dashes, with one value or a
list; each table [[material]] and [[settings]] is a set of them, and all sets are combined. A .csv
file with a column "file" is a table: a row is a job, its other columns are options, several numbers
of one with spaces. Their files lie beside them; with --config a plan needs none and takes those of
the command line.
"""

MOST_ROWS = 40
"""Most rows of an index that are shown on the terminal."""

TABLES = ("material", "settings")
"""Tables of a plan."""

TRUTH = {"true": True, "false": False}
"""Cells of a table that say whether an option without a value is given."""

NUMBER = re.compile(r"[-+.]*\d\S*|inf")
"""A word of a cell that begins another number."""

OPTIONS = {
    "curve": (options.add_model_options, options.model),
    "bem": (options.add_tolerance_option, options.elements),
    "solve": (add_accuracy_options, settings_of),
}
"""What adds the options of what solves a job, and what makes arguments of them, by its name."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity sweep``."""
    planned = type(parser)(add_help=False)
    planned.error = _refuse  # type: ignore[method-assign]
    for part in (parser, planned):
        options.add_surface_options(part)
        options.add_material_options(part, several=True)
        add_solving_options(part)
    parser.set_defaults(planned=planned)
    add_worker_options(parser)
    parser.add_argument("--config", metavar="FILE", help="plan (.toml) for the files given")
    parser.add_argument(
        "-o",
        "--output",
        default="sweep/",
        metavar="DIR",
        help="folder of index.csv, index.h5 and results/; what is finished there is not run again "
        "(default sweep/)",
    )
    targets.add_force(parser)
    batch.add_json(parser)


def _refuse(message: str) -> NoReturn:
    raise InputError(message)


def add_solving_options(parser: argparse.ArgumentParser) -> None:
    """Options that say what is solved, and how."""
    options.add_load_options(parser)
    parser.add_argument(
        "--method",
        choices=OPTIONS,
        default="curve",
        help="what solves: the microcontact model, boundary elements, or the cheaper of both to "
        "an accuracy (default curve)",
    )
    for add, _ in OPTIONS.values():
        add(parser)


def add_worker_options(parser: argparse.ArgumentParser) -> None:
    """Options that say where jobs run."""
    group = parser.add_argument_group("workers")
    place = group.add_mutually_exclusive_group()
    place.add_argument(
        "--workers",
        type=quantities.whole("processes"),
        metavar="N",
        help="processes (default: as many as processors)",
    )
    place.add_argument(
        "--scheduler", metavar="ADDRESS", help="Dask scheduler, tcp://node:8786, with its workers"
    )
    group.add_argument(
        "--threads",
        type=quantities.whole(),
        default=1,
        metavar="N",
        help="threads of each job (default 1)",
    )


def run(args: argparse.Namespace) -> int:
    """Run what is not finished, write the index and tell it."""
    from asperity.distributed.jobs import Jobs
    from asperity.distributed.pool import Workers
    from asperity.distributed.sweep import run_sweep

    folder, on = Path(args.output), Workers(args.workers, args.scheduler, args.threads)
    maker = Jobs(folder)
    jobs = [job for one in _expanded(args) for job in _jobs(one, maker)]
    with bar(len(jobs), "jobs") as advance:
        found = run_sweep(jobs, folder, on, force=args.force, progress=advance)
    args.document = found.to_dataframe().to_dict("records")
    if len(found) <= MOST_ROWS:
        tell(batch.table_text(_shown(args.document)) + "\n")
    tell(str(found))
    if found.failed.size:
        return EXIT_BAD_INPUT
    return EXIT_OK if found.converged else EXIT_NOT_CONVERGED


def _shown(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows without what is the same in all, and without names for programs."""
    kept = [
        name
        for name in rows[0]
        if name in ("surface", "state", "reason")
        or (name not in ("digest", "file") and len({repr(row[name]) for row in rows}) > 1)
    ]
    return [{name: row[name] for name in kept} for row in rows]


def _jobs(args: argparse.Namespace, maker: Any) -> Iterator[Job]:
    """Jobs of all files with all materials."""
    from asperity.distributed.jobs import Surface

    how, settings = options.surface_choices(args), settings_for(args)
    bodies = options.materials(args)
    for file in batch.expand(args.files):
        surface = Surface(str(file), partial(options.load_surface, str(file.absolute()), how))
        yield from (maker.job(surface, body, settings) for body in bodies)


def settings_for(args: argparse.Namespace) -> dict[str, Any]:
    """Method and its keyword arguments."""
    for other, (add, _) in OPTIONS.items():
        if other != args.method:
            why = f"--method {args.method} does not take the options of {other}"
            options.require_default(args, why, add)
    _, chosen = OPTIONS[args.method]
    return {"method": args.method, **chosen(args), **options.loads(args)}


def _expanded(args: argparse.Namespace) -> Iterator[argparse.Namespace]:
    """Options of the command line, with those of each plan and each row of a table."""
    maps = []
    for file in batch.expand(args.files):
        sets = _plan(file) if file.suffix == ".toml" else _table(file)
        if sets is None:
            maps.append(str(file))
            continue
        own = copy.copy(args)
        del own.files
        yield from (_merged(given, own, file) for given in sets)
    if args.config is not None:
        if not maps:
            raise InputError("--config is a plan for the height maps given, and none is given")
        yield from (_merged(one, args, args.config, maps) for one in _plan(Path(args.config)))
    elif maps:
        yield argparse.Namespace(**vars(args) | {"files": maps})


def _merged(
    given: Mapping[str, Any], args: argparse.Namespace, file: str | Path, maps: Sequence[str] = ()
) -> argparse.Namespace:
    """Options of the command line, and those that a plan or a table holds in their place."""
    known = {"file", *vars(args.planned.parse_args(["-"]))}
    if unknown := [name for name in given if name.replace("-", "_") not in known]:
        raise InputError(
            f"{file}: {', '.join(unknown)}: no options of a map, its material or what solves it; "
            "give others on the command line"
        )
    single = {one.dest for one in args.planned._actions if one.nargs in (None, 0)} - {
        *options.LOADS
    }
    for name, value in given.items():
        if name.replace("-", "_") in single and isinstance(value, list) and len(value) > 1:
            text = f"{file}: {name} takes one value; give each a table [[settings]] of its own"
            raise InputError(text)
    try:
        words = _words(given, Path(file), maps)
        found: argparse.Namespace = args.planned.parse_args(words, copy.copy(args))
    except InputError as error:
        raise InputError(error_text(file, error)) from None
    return found


def _plan(file: Path) -> Iterator[dict[str, Any]]:
    """Options of each combination of the tables of a plan."""
    try:
        content = tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: no plan in TOML ({error})") from error
    sets = [_sets(content.pop(name, {}), name, file) for name in TABLES]
    for chosen in itertools.product(*sets):
        merged = dict(content)
        for one in chosen:
            merged |= one
        yield merged


def _sets(given: Any, name: str, file: Path) -> list[dict[str, Any]]:
    """One table [name] of a plan, or several [[name]]."""
    sets = given if isinstance(given, list) else [given]
    if not sets or not all(isinstance(one, dict) for one in sets):
        raise InputError(f"{file}: {name} is no table; write [{name}], or [[{name}]] for each set")
    return sets


def _table(file: Path) -> list[dict[str, Any]] | None:
    """Options of each row of a table; None if the file is none, such as a map of numbers."""
    if file.suffix != ".csv" or not file.is_file() or heading(file) is None:
        return None
    with open(file, newline="", encoding="utf-8-sig", errors="replace") as text:
        head = text.readline()
        text.seek(0)
        rows = csv.DictReader(text, delimiter=max(",;\t", key=head.count))
        names = [name for name in rows.fieldnames or () if name]
        if "file" not in names:
            raise InputError(f'{file}: a table without a column "file"; name that of the maps so')
        if len(set(names)) < len(names):
            raise InputError(f"{file}: two columns have one name; give each option one column")
        cells = []
        for row in rows:
            if row.pop("", None) or any(row.pop(None, ())):
                raise InputError(
                    f"{file}: line {rows.line_num} has a cell without a column; write several "
                    "numbers of one option in one cell, with spaces"
                )
            cells.append({name: _cell(name, text) for name, text in row.items() if text})
    if not cells:
        raise InputError(f"{file}: a table without rows; write one for each job")
    return cells


def _cell(name: str, text: str) -> bool | str | list[str]:
    """A cell of a table as a plan holds it: a truth, several numbers, or a text."""
    words = text.split()
    if name != "file" and len(words) > 1 and all(NUMBER.fullmatch(word) for word in words):
        return words
    return TRUTH.get(text.lower(), text)


def _words(given: Mapping[str, Any], file: Path, maps: Sequence[str]) -> list[str]:
    """Options as words of a command line, the files last; files lie beside the plan."""
    given = dict(given)
    if isinstance(given.get("against"), str):
        given["against"] = str(file.parent / given["against"])
    named = [given.pop(name) for name in ("file", "files") if name in given]
    words = []
    for name, value in given.items():
        if value is False:
            continue
        values = [] if value is True else value if isinstance(value, list) else [value]
        if name in options.LOADS:  # a list of them is one word
            values = [",".join(map(str, values))]
        word = f"--{name.replace('_', '-')}"
        words += [f"{word}={values[0]}"] if len(values) == 1 else [word, *map(str, values)]
    files = [word for one in named for word in (one if isinstance(one, list) else [one])]
    if not (files or maps) or not all(isinstance(word, str) for word in files):
        raise InputError(f'{file}: names no file; give files = ["maps/*.h5"], or a column file')
    return [*words, "--", *(str(file.parent / word) for word in files), *maps]
