"""Entry point: parse, run one sub-command, turn errors into one sentence and an exit code."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import re
import sys
from collections.abc import Sequence
from typing import Any

import lazy_loader

from asperity import __version__
from asperity.errors import AsperityError, ConvergenceError
from surfaces.numerics.memory import set_memory

from .exit_codes import EXIT_BAD_INPUT, EXIT_INTERRUPTED, EXIT_NOT_CONVERGED, EXIT_OK
from .interrupt import interruptible
from .messages import command_name, warn, warnings_told

COMMANDS = {
    "demo": "make a surface, run both models, write report.html and print the verdict",
    "solve": "the contact curve as accurate as asked for, by the cheaper engine",
    "curve": "load-separation and contact area from the sum of microcontacts",
    "bem": "the same curves from the full boundary-element solution",
    "compare": "both models, their differences and run times; results and report",
    "sweep": "many maps, materials and settings on many workers, and one index of all",
    "ensemble": "mean curve of seeds, windows or repeats, its scatter and how well it is known",
    "plan": "what a run would do, need and leave out, and why; nothing is run",
    "indent": "one microcontact: force, area, contour and pressure against approach",
    "surface": "height maps: info, generate, prepare, convert, validate, peaks",
    "interface": "the curve as an interface law for Abaqus, CalculiX or MOOSE",
    "report": "rebuild the report from a results file",
    "completion": "a script that lets the shell complete commands, options and files",
    "stress": "stiff and extreme cases through every engine, each judged",
    "warmup": "compile what daily use needs for this machine; later runs start at once",
}
"""What each sub-command does; the module of its name has `EPILOG`, `add_arguments` and `run`."""

_module = lazy_loader.attach(__package__, COMMANDS)[0]  # imports it when it is used


class _ShortUsage(argparse.RawDescriptionHelpFormatter):
    """Help whose first line names what is needed; the options follow, each with its words."""

    def add_usage(self, usage, actions, groups, prefix=None):  # type: ignore[no-untyped-def]
        """Show one word in place of the options that may be left out; none in a prefix."""
        needed = [action for action in actions if action.required or not action.option_strings]
        left_out = [argparse.Action(["options"], "options", nargs=0)] if prefix is None else []
        super().add_usage(usage, [*left_out, *needed], (), prefix)


class _OneSentenceParser(argparse.ArgumentParser):
    """Parser whose errors are one sentence on standard error, without the usage block."""

    def __init__(self, *args: Any, **options: Any) -> None:
        # an abbreviation of one option could mean another one day: --out is no --outliers
        known: dict[str, Any] = {"allow_abbrev": False, "formatter_class": _ShortUsage}
        super().__init__(*args, **known | options)
        self._negative_number_matcher = re.compile(r"-[.\d]")  # by itself it takes no -1e6

    def parse_known_args(self, args=None, namespace=None):  # type: ignore[no-untyped-def]
        """Refuse here what is left over: the parser of all commands would name its own help."""
        found, left = super().parse_known_args(args, namespace)
        if left:
            self.error(f"unrecognized arguments: {' '.join(left)}")
        return found, left

    def error(self, message: str) -> None:  # type: ignore[override]
        sys.stderr.write(f"{self.prog}: {message}; see {self.prog} --help\n")
        raise SystemExit(EXIT_BAD_INPUT)


def build_parser(*known: str) -> argparse.ArgumentParser:
    """Parser of the whole command line; of the sub-commands only those `known` have options."""
    parser = _OneSentenceParser(
        prog="asperity",
        description="How much of a rough surface really touches, and how far to trust the answer.",
    )
    parser.add_argument("--version", action="version", version=f"asperity {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, summary in COMMANDS.items():
        sub = commands.add_parser(
            name, help=summary, description=summary[0].upper() + summary[1:] + "."
        )
        if name in known:
            sub.epilog = _module(name).EPILOG
            _module(name).add_arguments(sub)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code: 0, 1 (not converged) or 2 (bad input)."""
    arguments = sys.argv[1:] if argv is None else list(argv)
    _open_streams()
    named = next((word for word in arguments if not word.startswith("-")), "")
    args = argparse.Namespace(command=named)
    try:
        args = build_parser(named).parse_args(arguments)
        with interruptible(), warnings_told(args):
            code = _run(args)
        sys.stdout.flush()
        return code
    except (AsperityError, MemoryError) as error:
        warn(args, " ".join(str(error).split()) or "out of memory")
        return EXIT_NOT_CONVERGED if isinstance(error, ConvergenceError) else EXIT_BAD_INPUT
    except KeyboardInterrupt:
        goes_on = "; --resume goes on from its results file" if "resume" in args else ""
        goes_on = "; the same again goes on where this ended" if "workers" in args else goes_on
        warn(args, f"interrupted{goes_on}")
        return EXIT_INTERRUPTED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_OK
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        warn(args, f"{where}{error.strerror or error}")
        return EXIT_BAD_INPUT


def _run(args: argparse.Namespace) -> int:
    """Run the command within its memory; with ``--json`` what it prints goes to standard error, but
    for the JSON."""
    as_json = getattr(args, "json", False)
    set_memory(getattr(args, "memory", None))
    try:
        with contextlib.redirect_stdout(sys.stderr) if as_json else contextlib.nullcontext():
            code = int(_module(args.command).run(args))
    finally:
        set_memory(None)
    if not as_json:
        return code
    from asperity.results.storage import json_text

    about = {"command": command_name(args), "version": __version__, "exit_code": code}
    text = json_text(about | {"results": args.document})
    # JSON knows no number that is not finite: it is null
    print(json.dumps(json.loads(text, parse_constant=lambda word: None)))
    return code


def _open_streams() -> None:
    """Let both streams take any text, also where they were closed or know ASCII only."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w"))
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
