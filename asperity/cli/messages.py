"""Lines on the terminal that do not tear a progress bar, and warnings on standard error."""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from asperity.errors import ContactWarning


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


def error_text(file: str | Path, error: BaseException) -> str:
    """What went wrong with one of several files, in one sentence that names it."""
    text = " ".join(str(error).split()) or "out of memory"
    return text if str(file) in text else f"{file}: {text}"


@contextmanager
def warnings_told(args: argparse.Namespace) -> Iterator[None]:
    """Let doubts about an answer be sentences on standard error, below the name of the file.

    Each is told once, however many solvers a command calls.
    """
    known: set[str] = set()
    with warnings.catch_warnings():
        show = warnings.showwarning

        def tell_doubt(message: Warning | str, category: type[Warning], *rest: Any) -> None:
            if not issubclass(category, ContactWarning):
                return show(message, category, *rest)
            file = getattr(args, "file", None)
            text = f"{file}: {message}" if file else str(message)
            if text not in known:
                known.add(text)
                warn(args, text)

        warnings.simplefilter("always", ContactWarning)
        warnings.showwarning = tell_doubt  # type: ignore[assignment]
        yield
