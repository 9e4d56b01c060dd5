"""Files that a command writes: their names for several inputs, and what they must not replace."""

from __future__ import annotations

import argparse
import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asperity.errors import InputError
from surfaces.files.atomic import make_folder, replacing, require_replaceable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURE = ".png"
"""Suffix of a picture without one; the format of a picture follows from its suffix."""

SUFFIXES = (".csv", ".h5", ".html", ".jpg", ".npz", ".pdf", ".png", ".svg", ".txt", ".vti", ".xlsx")
"""Suffixes of what commands write, and of what may be taken for a table: none is the name of
another."""


@dataclass(frozen=True)
class Target:
    """A file that an option names.

    Its name in a folder ends with `suffix`, with which it may be one file for all inputs, of any
    name without; in place of it those of `formats` may stand. `alone` is written for one input and
    `several` for several where the option is not given.
    """

    suffix: str
    one: bool
    formats: tuple[str, ...]
    alone: str | None = None
    several: str | None = None


def add_target(
    parser: Any,
    *names: str,
    suffix: str,
    one: bool = False,
    formats: tuple[str, ...] = (),
    alone: str | None = None,
    several: str | None = None,
    **settings: Any,
) -> None:
    """Option for a file that is written, see `Target`."""
    action = parser.add_argument(*names, **{"metavar": "FILE", "type": _named} | settings)
    known = parser.get_default("targets") or {}
    parser.set_defaults(
        targets={**known, action.dest: Target(suffix, one, formats, alone, several)}
    )


def _named(name: str) -> str:
    """Type of such an option: a shell variable that is not set is no reason to write nothing."""
    if not name.strip():
        raise argparse.ArgumentTypeError("the name of the file is empty")
    return name


def fill_in(args: argparse.Namespace, several: bool) -> None:
    """Set what is not given; with several inputs a name without a suffix is that of a folder."""
    for option, target in args.targets.items():
        name = getattr(args, option) or (target.several if several else target.alone)
        if name and several and not target.one and not Path(name).suffix:
            name = os.path.join(name, "")
        setattr(args, option, name)


def add_force(parser: Any) -> None:
    """Option that lets files that exist be replaced."""
    parser.add_argument("--force", action="store_true", help="replace files that are there already")


def of_input(args: argparse.Namespace, file: Path, several: bool) -> argparse.Namespace:
    """The options for one input, as ``file``: its name goes into those of the files written.

    A folder, that is there or ends with a slash, takes ``NAME.suffix``; of several inputs each
    puts its name in front of a file name.
    """
    named: dict[str, Any] = {"file": str(file)}
    for option, target in args.targets.items():
        name = getattr(args, option)
        if not name or target.one:
            continue
        if _is_folder(name):
            name = os.path.join(name, f"{file.stem}{target.suffix}")
        elif several:
            name = str(Path(name).with_name(f"{file.stem}-{Path(name).name}"))
        named[option] = name
    return argparse.Namespace(**vars(args) | named)


def beside(name: str, file: str) -> str:
    """The file in the folder of that name, or the name with the suffix of the file."""
    if _is_folder(name):
        return os.path.join(name, file)
    return str(Path(name).with_suffix(Path(file).suffix))


def require(
    args: argparse.Namespace,
    runs: Sequence[argparse.Namespace] = (),
    inputs: Sequence[str] = (),
) -> None:
    """Refuse, before any work, what cannot be written, or would replace a file or another output.

    `runs` are the options of each input, from `of_input`, where each has outputs of its own;
    `inputs` are further files that are read.
    """
    inputs = [*inputs, *(run.file for run in runs)]
    taken = {Path(os.path.realpath(file)): f"would replace the input {file}" for file in inputs}
    for option, target in args.targets.items():
        shared = target.one or not runs
        if not shared and getattr(args, option):
            _require_distinct([run.file for run in runs])
            if getattr(args, option).endswith("/"):
                make_folder(getattr(args, option))
        for file in [getattr(run, option) for run in ([args] if shared else runs)]:
            if not file:
                continue
            place = Path(os.path.realpath(file))
            if place in taken:
                raise InputError(f"{file} {taken[place]}; give every output a name of its own")
            taken[place] = "is named for two outputs"
            resumes, remedy = getattr(args, "resume", None), "--force replaces it"
            if resumes is not None and option == "output":
                remedy += ", --resume goes on with it"
            elif resumes:
                remedy += ", and with --resume the results are kept"
            require_place(file, args.force or (resumes and option == "output"), remedy)
            if target.suffix == PICTURE:
                _require_picture(file)
            elif target.suffix:
                _require_suffix(file, target)


def require_place(
    file: str | Path, replace: bool | None, remedy: str = "--force replaces it"
) -> None:
    """Refuse a file that cannot be written, or is there already and must not be replaced."""
    place = require_replaceable(file)
    if not replace and place.exists():
        raise InputError(f"{file} is there already; {remedy}")
    if not place.parent.is_dir():
        raise InputError(f"{file}: cannot be written, its folder does not exist")
    try:
        with tempfile.TemporaryFile(dir=place.parent):
            pass
    except OSError as error:
        raise InputError(f"{file}: cannot be written ({error.strerror})") from error


def save_figure(figure: Figure, target: str) -> None:
    """Write a picture in the format of the file's suffix, PNG if it has none."""
    with replacing(target) as part:
        figure.savefig(part, dpi=150, format=_format(target))


def _is_folder(name: str) -> bool:
    return name.endswith("/") or os.path.isdir(name)


def _require_distinct(files: Sequence[str]) -> None:
    """Refuse several inputs whose results would be called the same."""
    seen: dict[str, str] = {}
    for file in files:
        stem = Path(file).stem
        if stem in seen:
            raise InputError(
                f"the results of {seen[stem]} and {file} would replace each other; run them apart"
            )
        seen[stem] = file


def _require_suffix(file: str, target: Target) -> None:
    """Refuse the name of a file of another kind."""
    suffix = Path(file).suffix.lower()
    if suffix in SUFFIXES and suffix not in (target.suffix, *target.formats):
        known = ", ".join((target.suffix, *target.formats))
        raise InputError(f"{file}: it is written as {known}, not as {suffix}")


def _require_picture(file: str) -> None:
    from matplotlib.backend_bases import FigureCanvasBase

    known = FigureCanvasBase.get_supported_filetypes()
    if (kind := _format(file)) not in known:
        raise InputError(f"{file}: cannot be written as .{kind}; known are {', '.join(known)}")


def _format(picture: str) -> str:
    return Path(picture).suffix[1:].lower() or "png"
