"""What the sub-commands share on the way out: progress bars, file names, exit codes."""

from __future__ import annotations

import argparse
import math
import os
import sys
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asperity import __version__
from asperity.errors import InputError
from asperity.progress import bar
from asperity.results.curve import ContactCurve
from surfaces.files.atomic import replacing, require_replaceable

from . import derived
from .exit_codes import EXIT_NOT_CONVERGED, EXIT_OK

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from asperity.halfspace.material import HalfSpace
    from surfaces import HeightMap

__all__ = [
    "add_fields_option",
    "add_output_options",
    "bar",
    "exit_code",
    "finish",
    "last_converged",
    "make_folder",
    "named",
    "request_of",
    "require_distinct",
    "require_outputs",
    "require_pictures",
    "save_figure",
    "solve_and_keep",
    "tell",
    "told",
]


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
    group.add_argument(
        "--resume", action="store_true", help="continue from the points in the results file"
    )
    group.add_argument("--csv", metavar="FILE", help="also write the curve as CSV")


def add_fields_option(parser: argparse.ArgumentParser, what: str) -> None:
    """Option for the fields of the last load point."""
    parser.add_argument("--fields", metavar="VTI", help=f"ParaView file of {what}, last point")


def tell(text: str, *, error: bool = False) -> None:
    """Write lines above the progress bar, or to standard error."""
    from tqdm import tqdm

    tqdm.write(text, file=sys.stderr if error else None)


def named(file: str, stem: str, several: bool) -> str:
    """File name for the results of one of several inputs: the input's name goes in front."""
    target = Path(file)
    return str(target.with_name(f"{stem}-{target.name}")) if several else file


def solve_and_keep(
    solve: Callable[..., ContactCurve],
    hm: HeightMap,
    material: HalfSpace,
    loads: dict[str, Any],
    path: str,
    model: str,
    request: dict[str, Any],
    resume: bool,
    chained: bool = False,
) -> ContactCurve:
    """Run a solver that takes load points, `progress` and `checkpoint`, such as `contact_curve` of
    a map and a material; each finished point is kept in the file.

    With `chained`, missing points are solved with all others (`run_resumably`).
    """
    from asperity.halfspace.scene import checked_loads
    from asperity.results.resume import run_resumably

    kind, values = checked_loads(hm, material, loads.get("pressures"), loads.get("separations"))
    with bar(len(values), "load points") as advance:
        return run_resumably(
            lambda points, keep: solve(**{f"{kind}s": points}, progress=advance, checkpoint=keep),
            values,
            kind,
            path,
            model=model,
            request=request,
            resume=resume,
            chained=chained,
        )


def request_of(
    hm: HeightMap, material: HalfSpace, args: argparse.Namespace, settings: dict[str, Any]
) -> dict[str, Any]:
    """Facts that an interrupted run and the one that goes on with it must share."""
    return {
        "version": __version__,
        "command": args.command,
        "kind of load points": "pressure" if args.separation is None else "separation",
        "input": hm.digest,
        "modulus": material.modulus,
        "m": material.m,
        **({"hardness": material.hardness} if material.hardness < math.inf else {}),
        **settings,
    }


def finish(curve: ContactCurve, material: HalfSpace, args: argparse.Namespace) -> int:
    """Write the CSV where asked, print the curve and what follows from it, give the exit code."""
    from asperity.results.storage import write_csv

    more = derived.conductance(curve, args)
    if args.csv:
        write_csv(args.csv, curve.columns() | more)
    try:
        if args.slip:
            derived.write_slip(curve, material, args)
    finally:
        print(curve)
        for name, values in more.items():
            print(f"{name}     {' '.join(f'{value:.4g}' for value in values)}")
        print(f"results         {args.results}")
    return exit_code([curve])


def told(file: str | Path, error: BaseException) -> str:
    """What went wrong with one of several files, in one sentence that names it."""
    text = " ".join(str(error).split()) or "out of memory"
    return text if str(file) in text else f"{file}: {text}"


def last_converged(curve: ContactCurve, args: argparse.Namespace) -> bool:
    """Whether the last load point can be shown; says so where it cannot."""
    if not curve.converged[-1]:
        text = "the last load point did not converge: no table and no field of it is written"
        sys.stderr.write(f"asperity {args.command}: {text}\n")
    return bool(curve.converged[-1])


def exit_code(curves: Iterable[ContactCurve]) -> int:
    """0 if every load point converged, else 1."""
    return EXIT_OK if all(c.converged.all() for c in curves) else EXIT_NOT_CONVERGED


def require_outputs(*files: str | Path | None, inputs: Iterable[str | Path] = ()) -> None:
    """Refuse, before any work, files that cannot be written or would replace one another."""
    taken = {Path(os.path.realpath(file)): f"would replace the input {file}" for file in inputs}
    for file in files:
        if not file:
            continue
        place = require_replaceable(file)
        if place in taken:
            raise InputError(f"{file} {taken[place]}; give every output a name of its own")
        if not place.parent.is_dir():
            raise InputError(f"{file}: cannot be written, its folder does not exist")
        try:
            with tempfile.TemporaryFile(dir=place.parent):
                pass
        except OSError as error:
            raise InputError(f"{file}: cannot be written ({error.strerror})") from error
        taken[place] = "is named for two outputs"


def make_folder(folder: str | Path) -> None:
    """Make a folder for results, with those around it, where it does not exist."""
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror})") from error


def require_distinct(files: Iterable[Path]) -> None:
    """Refuse several inputs whose results would be called the same."""
    seen: dict[str, Path] = {}
    for file in files:
        if file.stem in seen:
            raise InputError(
                f"the results of {seen[file.stem]} and {file} would replace each other; "
                "run them apart"
            )
        seen[file.stem] = file


def require_pictures(*files: str | None) -> None:
    """Refuse, before any work, pictures in a format that cannot be written."""
    for file in filter(None, files):
        from matplotlib.backend_bases import FigureCanvasBase

        known = FigureCanvasBase.get_supported_filetypes()
        if (kind := _format(file)) not in known:
            raise InputError(f"{file}: cannot be written as .{kind}; known are {', '.join(known)}")


def save_figure(figure: Figure, target: str) -> None:
    """Write a picture in the format of the file's suffix, PNG if it has none."""
    with replacing(target) as part:
        figure.savefig(part, dpi=150, format=_format(target))


def _format(picture: str) -> str:
    return Path(picture).suffix[1:].lower() or "png"
