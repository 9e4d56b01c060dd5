"""The first run on a machine: loops compiled in several processes at once.

Numba compiles on one processor and keeps the machine code on disk, from where every later run
takes it. On a machine that has none yet, parts that do not need each other are compiled side by
side, each in a process of its own (`asperity.warmup`).
"""

from __future__ import annotations

import fcntl
import json
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from surfaces.numerics.compiled import cache_folder, kept_sources, stamp
from surfaces.numerics.parallel import available

__all__ = ["CURVE", "HARD", "compile_ahead", "compiling", "curve_parts"]

CURVE = ("contacts", "laws", "summits", "basins", "plan")
"""Parts of a contact curve."""

HARD = ("hardness",)
"""Further parts of that of a half-space with a hardness."""

SECONDS = {
    "contacts": 15.0,
    "laws": 12.0,
    "bem": 10.5,
    "summits": 9.5,
    "basins": 5.0,
    "hardness": 4.0,
    "plan": 1.5,
}
"""Time that each part takes [s] on a processor of its own, of 2.5 GHz."""

_compiled: set[str] = set()


def compile_ahead(*parts: str) -> None:
    """Compile the loops of some parts, as far as the disk does not hold their code.

    Says so in one line on standard error if there is anything to compile. A part that fails is
    left to the run itself, which compiles what it meets.

    Parameters
    ----------
    parts
        Some of "contacts" (their interaction), "laws" (law tables of summits), "summits" (peaks
        and summits of a map), "plan" (of its scales), "basins" (basins pressed alone), "hardness"
        (contacts under one) and "bem" (boundary elements).
    """
    if _missing(parts):
        with _locked():
            missing = _missing(parts)  # another process may have compiled them meanwhile
            if missing:
                _compile(_shares(missing, available()))
    _compiled.update(parts)


def curve_parts(hardness: float) -> tuple[str, ...]:
    """Parts of a contact curve of a half-space of this hardness [Pa]."""
    return CURVE if hardness == math.inf else CURVE + HARD


@contextmanager
def compiling(part: str) -> Iterator[None]:
    """Compile a part within this process, which starts no other, and note that it is done."""
    _compiled.update({part, *CURVE, *HARD})
    yield
    stamps = {str(source): stamp(source) for source in kept_sources()}
    _stamp_file(part).write_text(json.dumps(stamps), encoding="utf-8")


def _missing(parts: tuple[str, ...]) -> list[str]:
    return [part for part in parts if part not in _compiled and not _on_disk(part)]


def _on_disk(part: str) -> bool:
    """Whether a part was compiled from files and versions as they are now."""
    try:
        stamps = json.loads(_stamp_file(part).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return all(stamp(Path(source)) == found for source, found in stamps.items())


def _stamp_file(part: str) -> Path:
    return cache_folder() / f"{part}.json"


@contextmanager
def _locked() -> Iterator[None]:
    """Let one process compile at a time: of several that start together the others wait."""
    with open(cache_folder() / "lock", "w") as lock:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _shares(parts: list[str], processors: int) -> list[list[str]]:
    """Parts for each processor, so that all end at about the same time.

    The shortest come first: of loops that two parts need, the second then finds the code on disk.
    """
    shares: list[list[str]] = [[] for _ in range(min(len(parts), processors))]
    for part in sorted(parts, key=SECONDS.__getitem__, reverse=True):
        min(shares, key=_time).append(part)
    return [sorted(share, key=SECONDS.__getitem__) for share in shares]


def _time(share: list[str]) -> float:
    return sum(SECONDS[part] for part in share)


def _compile(shares: list[list[str]]) -> None:
    """Compile each share of the parts in a process of its own."""
    longest = max(map(_time, shares))
    if sys.stderr is not None:
        about = 10 * math.ceil(0.13 * longest)
        sys.stderr.write(f"asperity: compiling for this machine, about {about} s, once\n")
    # a copy of the package in the working folder would be compiled instead of this one
    home = str(Path(__file__).parents[1])
    paths = os.pathsep.join(filter(None, (home, os.environ.get("PYTHONPATH"))))
    keeps = {"PYTHONPATH": paths, "NUMBA_CACHE_DIR": str(cache_folder().parent)}
    children = [
        subprocess.Popen(
            [sys.executable, "-P", "-m", f"{__package__}.warmup", *share],
            env=os.environ | keeps,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for share in shares
    ]
    try:
        for child in children:
            child.wait()
    finally:  # of an interrupted run; those that have ended are left alone
        for child in children:
            child.terminate()
            child.wait()
