"""When, how and with what a results file was made."""

from __future__ import annotations

import importlib.metadata
import platform
import shlex
import sys
from datetime import UTC, datetime
from pathlib import Path

from asperity import __version__

__all__ = ["provenance"]

LIBRARIES = ("numpy", "scipy", "numba")


def provenance() -> dict[str, str]:
    """Date (UTC), command line or name of the script, and versions, as text."""
    versions = {name: importlib.metadata.version(name) for name in LIBRARIES}
    versions = {"asperity": __version__, "Python": platform.python_version()} | versions
    return {
        "date": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "command": _command(),
        "versions": ", ".join(f"{name} {version}" for name, version in versions.items()),
    }


def _command() -> str:
    """The command as it was typed; of another program its name alone."""
    program = Path(sys.argv[0] if sys.argv else "")
    ours = program.name == "asperity" or program.parts[-2:] == ("asperity", "__main__.py")
    return shlex.join(["asperity", *sys.argv[1:]]) if ours else program.name or "python"
