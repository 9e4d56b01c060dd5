"""The memory that may be used: a limit, what is left of it, and refusals of what would not fit."""

from __future__ import annotations

import os
from pathlib import Path

from surfaces.errors import InputError, SurfaceError, as_number

__all__ = ["available_bytes", "require_memory", "room_for", "set_memory"]

_USUAL = 2 << 30
"""Memory of a program that works on a map in sections of columns, if nothing limits it [bytes]."""

_PROGRAM = 384 << 20
"""What the program takes beside the arrays of a map that is worked on in blocks, libraries
included."""

_MEMINFO = Path("/proc/meminfo")
_CGROUP = Path("/sys/fs/cgroup")
_limit: int | None = None


def set_memory(limit: int | None) -> None:
    """Let this process use so many bytes of memory from now on; None: as much as there is.

    Parameters
    ----------
    limit
        Largest resident size of the process [bytes], the libraries' share included; 384 MiB and
        more. Maps that would take more stay on disk and are read in parts; what cannot be done so
        is refused with a sentence.

    Raises
    ------
    InputError
        If the limit is smaller.

    Examples
    --------
    >>> import asperity
    >>> asperity.set_memory(2 << 30)
    >>> asperity.set_memory(None)
    """
    global _limit
    if limit is not None and not as_number("the memory limit", limit) > _PROGRAM:
        raise InputError(f"the memory limit is {limit} bytes; give at least {_PROGRAM >> 20} MiB")
    _limit = None if limit is None else int(limit)


def available_bytes() -> int:
    """Memory that this process may still take [bytes]: what can be had without swapping, less what
    `set_memory` withholds."""
    free = _free_bytes()
    return free if _limit is None else max(0, min(free, _limit - _resident_bytes()))


def _resident_bytes() -> int:
    """Memory that this process holds; its largest so far where the system tells no more."""
    try:
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        import resource

        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _free_bytes() -> int:
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


def room_for(least: int, what: str) -> int:
    """Bytes for the arrays of a map in sections, within the limit of `set_memory`; 2 GiB if none.

    Parameters
    ----------
    least
        Bytes of arrays without which there is no section.
    what
        Subject of the sentence that refuses less.
    """
    bound = _USUAL if _limit is None else _limit
    if bound - _PROGRAM < least:
        raise InputError(
            f"{what} takes {-(-(_PROGRAM + least) >> 20)} MiB of memory or more, not "
            f"{bound / 2**20:.4g} MiB"
        )
    require_memory(least, what, "raise the limit of memory, or free some")
    return min(bound - _PROGRAM, available_bytes())
