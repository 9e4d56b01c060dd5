"""What the benchmarks share: a rough map, a clock, the name of the machine, the options."""

from __future__ import annotations

import argparse
import platform
import time
from collections.abc import Callable
from typing import Any

import numba

import surfaces


def rough(
    shape: tuple[int, int], cutoff: float | None, seed: int, **more: float
) -> surfaces.HeightMap:
    """Self-affine map of unit pixels; H 0.8, rms slope 0.1 and a roll-off at an eighth of the
    shorter side unless `more` says otherwise."""
    size = (float(shape[0]), float(shape[1]))
    recipe = {"hurst": 0.8, "rms_slope": 0.1, "rolloff": min(shape) / 8} | more
    return surfaces.self_affine(shape, size, cutoff=cutoff, seed=seed, **recipe)


def least(call: Callable[[], object], repeats: int = 7) -> float:
    """Least seconds of several calls, after one that compiles."""
    call()
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def machine() -> str:
    """Processor, and the threads that compiled loops run on."""
    processor = platform.processor() or platform.machine()
    return f"{processor}, {numba.get_num_threads()} threads"


def options(page: str | None, **settings: Any) -> argparse.ArgumentParser:
    """Parser whose help is the docstring of the script."""
    form = argparse.RawDescriptionHelpFormatter
    return argparse.ArgumentParser(description=page, formatter_class=form, **settings)
