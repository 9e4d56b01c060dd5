"""Entry point: parse, run one sub-command, turn errors into one sentence and an exit code."""

from __future__ import annotations

import argparse
import importlib
import re
import sys
from collections.abc import Sequence

from asperity import __version__
from asperity.errors import AsperityError, ConvergenceError

EXIT_OK, EXIT_NOT_CONVERGED, EXIT_BAD_INPUT = 0, 1, 2

COMMANDS = {
    "demo": "make a surface, run both models, write report.html and print the verdict",
    "curve": "load-separation and contact area from the sum of microcontacts",
    "bem": "the same curves from the full boundary-element solution",
    "compare": "both models, their differences and run times; results and report",
    "plan": "what a run would do, need and leave out, and why; nothing is run",
    "indent": "one microcontact: force, area, contour and pressure against approach",
    "surface": "height maps: info, generate, prepare, convert, validate, peaks",
    "report": "rebuild the report from a results file",
}


class _OneSentenceParser(argparse.ArgumentParser):
    """Parser whose errors are one sentence on standard error, without the usage block."""

    def error(self, message: str) -> None:  # type: ignore[override]
        sys.stderr.write(f"{self.prog}: {message}; see {self.prog} --help\n")
        raise SystemExit(EXIT_BAD_INPUT)


def build_parser(command: str | None = None) -> argparse.ArgumentParser:
    """Parser of the whole command line; only `command` (or every command) gets its options."""
    parser = _OneSentenceParser(
        prog="asperity",
        description="How much of a rough surface really touches, and how far to trust the answer.",
    )
    parser.add_argument("--version", action="version", version=f"asperity {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, summary in COMMANDS.items():
        sub = commands.add_parser(
            name,
            help=summary,
            description=summary[0].upper() + summary[1:] + ".",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        if command in (None, name):
            _module(name).add_arguments(sub)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code: 0, 1 (not converged) or 2 (bad input)."""
    arguments = _with_negative_numbers(sys.argv[1:] if argv is None else argv)
    named = next((word for word in arguments if not word.startswith("-")), "")
    args = build_parser(named).parse_args(arguments)
    try:
        return int(_module(args.command).run(args))
    except (AsperityError, MemoryError) as error:
        text = " ".join(str(error).split()) or "out of memory"
        sys.stderr.write(f"asperity {args.command}: {text}\n")
        return EXIT_NOT_CONVERGED if isinstance(error, ConvergenceError) else EXIT_BAD_INPUT
    except BrokenPipeError:
        sys.stderr.close()
        return EXIT_OK


def _with_negative_numbers(words: Sequence[str]) -> list[str]:
    """Join ``--option -1e6`` to ``--option=-1e6``, which argparse would take for two options."""
    joined: list[str] = []
    for word in words:
        if joined and re.match(r"--[a-z-]+$", joined[-1]) and re.match(r"-[.\d]", word):
            joined[-1] += f"={word}"
        else:
            joined.append(word)
    return joined


def _module(command: str):  # type: ignore[no-untyped-def]
    return importlib.import_module(f"asperity.cli.{command}")
