"""Lines on the terminal that do not tear a progress bar, and warnings on standard error."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

__all__ = ["bar", "tell", "told", "warn"]


def bar(total: int | None, label: str) -> tuple[Any, Callable[[Any], None]]:
    """A progress bar (nothing when not a terminal) and the function that advances it by one."""
    from tqdm import tqdm

    shown = tqdm(total=total, desc=label, disable=None, leave=False)
    return shown, lambda _: shown.update(1)


def tell(text: str) -> None:
    """Write lines of the result to standard output; with ``--json`` to standard error."""
    from tqdm import tqdm

    tqdm.write(text)


def warn(args: argparse.Namespace, text: str) -> None:
    """One sentence on standard error, below the name of the command."""
    from tqdm import tqdm

    command = " ".join(filter(None, ("asperity", args.command, getattr(args, "action", None))))
    tqdm.write(f"{command}: {text}", file=sys.stderr)


def told(file: str | Path, error: BaseException) -> str:
    """What went wrong with one of several files, in one sentence that names it."""
    text = " ".join(str(error).split()) or "out of memory"
    return text if str(file) in text else f"{file}: {text}"
