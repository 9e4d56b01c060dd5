"""Maps, a body and settings that take a worker little time."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

import asperity
import surfaces

MAKE = partial(
    surfaces.self_affine, (48, 64), (48e-6, 64e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6
)
STEEL = asperity.HalfSpace(210e9, 0.3)
LOADS = {"pressures": [1e8, 1e9]}


def same_but_seconds(one: asperity.Sweep, two: asperity.Sweep) -> bool:
    """Whether two tables are equal, but for the time that jobs took."""
    frames = [found.to_dataframe().drop(columns="seconds") for found in (one, two)]
    return bool(frames[0].equals(frames[1]))


@pytest.fixture
def maps(tmp_path: Path) -> Callable[[int], list[Path]]:
    """Writes so many files with maps."""

    def written(count: int) -> list[Path]:
        (tmp_path / "maps").mkdir()
        files = [tmp_path / "maps" / f"m{seed}.h5" for seed in range(count)]
        for seed, file in enumerate(files):
            surfaces.write(MAKE(seed=seed), file)
        return files

    return written


@pytest.fixture
def without_dask(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if dask.distributed were not installed."""
    monkeypatch.setitem(sys.modules, "distributed", None)
