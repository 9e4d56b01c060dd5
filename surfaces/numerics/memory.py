"""Available memory, and the check before a large allocation."""

from __future__ import annotations

import os
from pathlib import Path

from surfaces.errors import InputError, SurfaceError, as_number

__all__ = ["MEMORY", "available_bytes", "require_memory", "room_within"]

MEMORY = 2 << 30
"""Memory of a program that works on a map in blocks, if nothing else is said [bytes]."""

_PROGRAM = 384 << 20
"""What the program takes beside the arrays of a map that is worked on in blocks, libraries
included."""

_MEMINFO = Path("/proc/meminfo")
_CGROUP = Path("/sys/fs/cgroup")


def available_bytes() -> int:
    """Memory that can be had without swapping [bytes]; 4 GiB where the system does not say."""
    if _MEMINFO.is_file():
        for line in _MEMINFO.read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return min(int(line.split()[1]) * 1024, _left_in_container())
    names = os.sysconf_names if hasattr(os, "sysconf_names") else {}
    if "SC_PHYS_PAGES" in names and "SC_PAGE_SIZE" in names:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2
    return 4 << 30


def _left_in_container() -> int:
    """What the limit of a container leaves [bytes]; no limit is a very large number."""
    try:
        limit = (_CGROUP / "memory.max").read_text().strip()
        used = (_CGROUP / "memory.current").read_text().strip()
    except OSError:
        return 1 << 62
    return max(0, int(limit) - int(used)) if limit.isdigit() else 1 << 62


def require_memory(needed: int, what: str, remedy: str) -> None:
    """Refuse in one sentence what would not fit.

    Parameters
    ----------
    needed
        Bytes that the step will hold at its peak.
    what
        Subject of the sentence.
    remedy
        What to do instead.
    """
    free = available_bytes()
    if needed > free:
        raise SurfaceError(
            f"{what} needs {needed / 1e9:.3g} GB of memory and {free / 1e9:.3g} GB are available; "
            f"{remedy}"
        )


def room_within(memory: float, least: int, what: str) -> int:
    """Bytes for the arrays of a map in blocks, in a program that may take so much in all.

    Parameters
    ----------
    memory
        Bytes of the whole program.
    least
        Bytes of arrays without which there is no block.
    what
        Subject of the sentence that refuses less.
    """
    room = min(as_number("memory", memory), 2.0**62) - _PROGRAM
    if not room >= least:
        raise InputError(
            f"{what} takes {-(-(_PROGRAM + least) >> 20)} MiB of memory or more, not "
            f"{memory / 2**20:.4g} MiB"
        )
    return int(room)
