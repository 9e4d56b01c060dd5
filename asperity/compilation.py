"""The first run on a machine: kernels compiled in several processes at once.

Numba compiles on one processor and keeps the machine code on disk, from where every later run
takes it. On a machine that has none yet, parts that do not need each other are compiled side by
side: each in a process of its own, which runs that part once on a tiny scene.
"""

from __future__ import annotations

import gc
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, cast

import numpy as np

from surfaces import self_affine
from surfaces.heightmap import HeightMap
from surfaces.peaks.profiles import Profiles

from .boundary import Boundary, known_boundary
from .material import HalfSpace

if TYPE_CHECKING:
    from surfaces.peaks.summits import Summits

__all__ = ["compile_ahead", "small_map"]

SHAPE = (160, 192)
"""Large enough to meet every kernel of both models."""


def small_map() -> HeightMap:
    """A map on which both models meet all their kernels."""
    return self_affine(SHAPE, (1.0, 1.0), hurst=0.8, rms_slope=0.1, seed=0)


def compile_ahead(parts: Sequence[str], material: HalfSpace, boundary: Boundary) -> None:
    """Compile in processes of their own what the disk does not hold; returns when all is there.

    Parameters
    ----------
    parts
        Some of "laws" (law tables of summits) and "bem" (boundary elements).
    material, boundary
        Of the run to come.
    """
    if not _cold():
        return
    # a copy of the package in the working folder would be compiled instead of this one
    home = str(Path(__file__).parents[1])
    paths = os.pathsep.join(filter(None, (home, os.environ.get("PYTHONPATH"))))
    children = [
        subprocess.Popen(
            [sys.executable, "-P", "-m", __name__, part, repr(material.m), boundary],
            env={**os.environ, "PYTHONPATH": paths},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for part in parts
    ]
    try:
        with _collecting_nothing():
            _sum_of_contacts(material, boundary)
        for child in children:
            child.wait()
    finally:  # of an interrupted run; those that have ended are left alone
        for child in children:
            child.terminate()
            child.wait()
    for index in _indices():
        index.touch()  # Numba, which compares contents, leaves it where only the date is new


@contextmanager
def _collecting_nothing() -> Iterator[None]:
    """No search for cycles: the compiler's objects are many and stay, and looking through them
    again and again takes a tenth of its time."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _cold() -> bool:
    """Whether the largest kernel has not been compiled since its source was written."""
    from .microcontact import _tabulate_kernels

    newest = max((index.stat().st_mtime for index in _indices()), default=0.0)
    return newest < Path(_tabulate_kernels.__file__).stat().st_mtime


def _indices() -> list[Path]:
    """Files in which Numba notes what it has compiled of the largest kernel."""
    from .microcontact import _tabulate_kernels

    folder = Path(str(_tabulate_kernels.tabulate_rows.stats.cache_path))
    return list(folder.glob(f"{Path(_tabulate_kernels.__file__).stem}.*.nbi"))


def _sum_of_contacts(material: HalfSpace, boundary: Boundary) -> None:
    """Peaks, profiles and interaction, with the law that costs nothing."""
    from .curve import contact_curve
    from .loadpoints import default_pressures

    hm = small_map()
    loads = default_pressures(hm, material, count=2)
    contact_curve(hm, material, pressures=loads, law="hertz", boundary=boundary)


def _lists(material: HalfSpace, boundary: Boundary) -> None:
    """Lists of a few contacts, which a sum of contacts needs late."""
    from .interaction.footprint import Footprints
    from .interaction.operator import Interaction

    y, x = np.random.default_rng(0).uniform(0.0, 1.0, (2, 50))
    Interaction(y, x, (1.0, 1.0), boundary, Footprints(material.modulus, material.m))


def _laws(material: HalfSpace, boundary: Boundary) -> None:
    """Law tables of paraboloids, by every law that "auto" can take; lists before."""
    from .microcontact.laws import tabulate

    _lists(material, boundary)
    rays, nodes, count = 16, 17, 2
    turn = 2 * np.pi * np.arange(rays) / rays
    profiles = Profiles(
        x=np.zeros(count),
        y=np.zeros(count),
        height=np.ones(count),
        curvature=np.ones((count, 2)),
        angle=np.zeros(count),
        phi=np.tile(turn, (count, 1)),
        weight=np.full((count, rays), 2 * np.pi / rays),
        edge=np.ones((count, rays)),
        t=np.linspace(0.0, 1.0, nodes),
        q=np.full((count, rays, nodes), 0.5),
        pixels=np.full(count, 100),
        border=np.zeros(count, bool),
        valid=np.ones(count, bool),
        owner=np.arange(count),
    )
    for law in ("ellipse", "ritz"):
        table = tabulate(profiles, material, law=law)
        table.evaluate(np.arange(count), table.reach)
    _basins(material)


def _basins(material: HalfSpace) -> None:
    """Basins pressed alone: none, of a map that was not segmented."""
    from .microcontact.elements import press

    none = np.zeros(0, np.int64)
    peaks = SimpleNamespace(labels=np.zeros((4, 4), np.int32), row=none, col=none)
    summits = SimpleNamespace(
        hm=HeightMap(np.eye(4), (1.0, 1.0)),
        peaks=peaks,
        owner=none,
        spline=np.zeros((4, 4)),
        places=np.zeros((0, 2)),
        height=np.zeros(0),
        angle=np.zeros(0),
        curvature=np.zeros((0, 2)),
        floor=np.zeros(0),
    )
    press(cast("Summits", summits), none, np.zeros((0, 2)), material)


def _bem(material: HalfSpace, boundary: Boundary) -> None:
    """Boundary elements at two loads."""
    from .bem.curve import bem_curve
    from .loadpoints import default_pressures

    hm = small_map()
    loads = default_pressures(hm, material, count=2)
    bem_curve(hm, material, pressures=loads, tolerance=1e-2, boundary=boundary)


if __name__ == "__main__":
    _, part, m, boundary = sys.argv
    body = HalfSpace.from_modulus(1.0, m=float(m))
    with _collecting_nothing():
        {"laws": _laws, "bem": _bem}[part](body, known_boundary(boundary))
