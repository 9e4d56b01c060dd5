"""Lines on the terminal that do not tear a progress bar, and warnings on standard error."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

__all__ = ["command_name", "tell", "told", "warn"]


def command_name(args: argparse.Namespace) -> str:
    """The command as it is typed, with its action."""
    return " ".join(filter(None, ("asperity", args.command, getattr(args, "action", None))))


def tell(text: str) -> None:
    """Write lines of the result to standard output; with ``--json`` to standard error."""
    from tqdm import tqdm

    tqdm.write(text)


def warn(args: argparse.Namespace, text: str) -> None:
    """One sentence on standard error, below the name of the command."""
    from tqdm import tqdm

    tqdm.write(f"{command_name(args)}: {text}", file=sys.stderr)


def told(file: str | Path, error: BaseException) -> str:
    """What went wrong with one of several files, in one sentence that names it."""
    text = " ".join(str(error).split()) or "out of memory"
    return text if str(file) in text else f"{file}: {text}"
