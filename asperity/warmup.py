"""Scenes that meet every loop of daily use: each part of the first run compiles its own.

Run as ``python -m asperity.warmup PART ...`` by `asperity.compilation`. A part is run once on a
tiny scene, which keeps its machine code on disk; it is the same for every body and boundary.
"""

from __future__ import annotations

import gc
import os
import sys
import warnings
from types import SimpleNamespace
from typing import Any

import numpy as np

from asperity.compilation import compiling
from asperity.errors import ContactWarning
from asperity.halfspace.material import HalfSpace
from surfaces import self_affine
from surfaces.heightmap import HeightMap
from surfaces.peaks.profiles import Profiles

__all__ = ["PARTS", "small_map"]

SHAPE = (160, 192)
"""Large enough to meet every kernel of both models."""

BODY = HalfSpace.from_modulus(1.0)

SPHERES, NODES = 1100, 9
"""Spheres that touch, enough for the solver to take them in cells, and nodes of their laws."""


def small_map() -> HeightMap:
    """A map on which both models meet all their kernels."""
    return self_affine(SHAPE, (1.0, 1.0), hurst=0.8, rms_slope=0.1, seed=0)


def _plan() -> None:
    """Plan of the scales of a map, and of a free one."""
    from asperity.model.plan import make_plan

    for periodic in True, False:
        make_plan(small_map().replace(periodic=periodic), BODY)


def _summits() -> None:
    """Peaks and summits of a map, and the rays of a few."""
    from asperity.model.load_point import joined_spots
    from surfaces.peaks.segmentation import segment
    from surfaces.peaks.summits import locate_summits

    hm = small_map()
    peaks = segment(hm)
    two = np.arange(2)
    summits = locate_summits(hm, peaks)
    summits.tilted(two, np.zeros((2, 2)), np.zeros(2)).rows(two)
    column = np.zeros(len(peaks))
    joined_spots(peaks.neighbors.astype(np.int32), peaks.passes, column, column)


def _contacts() -> None:
    """Spheres that touch a flat together: few on a small mesh, and many; also at separations."""
    from asperity.interaction.population import Population
    from asperity.microcontact.law_table import LawTable

    y, x, height = np.random.default_rng(0).uniform(0.0, 1.0, (3, SPHERES))
    u = np.tile(np.linspace(0.0, 1.0, NODES), (SPHERES, 1))
    table = LawTable(
        reach=np.full(SPHERES, 0.01),
        force=4 / 3 * (0.1 * u) ** 3,
        stiffness=0.2 * u,
        area=np.pi * (0.1 * u) ** 2,
        flags=np.zeros(u.shape, np.uint8),
        spread=np.zeros(u.shape),
        centre=np.zeros((*u.shape, 2)),
    )
    population = Population(
        x=x,
        y=y,
        height=0.01 * height,
        table=table,
        cell=(1.0, 1.0),
        boundary="periodic",
        material=BODY,
    )
    state = None
    for pressure in 1e-5, 2e-5, 1e-3, 2e-3:
        state = population.solve(pressure=pressure, state=state)
    for separation in 7e-3, 6e-3, 5e-3:
        state = population.solve(separation=separation, state=state)


def _laws() -> None:
    """Law tables of paraboloids, by every law that "auto" can take."""
    from asperity.microcontact.laws import tabulate

    profiles = _paraboloids()
    for law in ("ellipse", "ritz"):
        table = tabulate(profiles, BODY, law=law)
        table.evaluate(np.arange(len(profiles)), table.reach)


def _paraboloids() -> Profiles:
    rays, nodes, count = 16, 17, 2
    turn = 2 * np.pi * np.arange(rays) / rays
    return Profiles(
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


def _basins() -> None:
    """A basin pressed alone, at no approach or force, of a map that was not segmented."""
    from asperity.microcontact.basin_bem.press import press

    one = np.zeros(1, np.int64)
    press(_summit(), one, np.zeros((1, 1)), BODY)


def _hardness() -> None:
    """Hertzian laws, and a basin pressed alone, under a hardness."""
    from asperity.microcontact.basin_bem.press import areas_under
    from asperity.microcontact.laws import tabulate

    hard = HalfSpace.from_modulus(1.0, hardness=0.1)
    tabulate(_paraboloids(), hard, law="hertz")
    areas_under(_summit(), np.zeros(1, np.int64), np.zeros(1), np.ones(1), hard)


def _summit() -> Any:
    """What is read of the summits of a map, of one summit."""
    one = np.zeros(1, np.int64)
    peaks = SimpleNamespace(labels=np.zeros((4, 4), np.int32), row=one, col=one)
    return SimpleNamespace(
        hm=HeightMap(np.eye(4), (1.0, 1.0)),
        peaks=peaks,
        owner=one,
        spline=np.zeros((4, 4)),
        places=np.zeros((1, 2)),
        height=np.ones(1),
        angle=np.zeros(1),
        curvature=np.ones((1, 2)),
        floor=np.zeros(1),
        tilt=np.zeros((1, 2)),
    )


def _bem() -> None:
    """Boundary elements at three loads, two of them close, and at a separation, with pixels at the
    hardness."""
    from asperity.bem.convolution import plan
    from asperity.bem.curve import bem_curve
    from asperity.halfspace.scene import default_pressures

    hm = small_map()
    low, high = default_pressures(hm, BODY, count=2)
    body = HalfSpace.from_modulus(1.0, hardness=5.0 * high)
    solved = bem_curve(hm, body, pressures=[low, 0.8 * high, high], tolerance=1e-2)
    bem_curve(hm, body, separations=solved.separation[2:], tolerance=1e-2)
    # a free map of 512 x 512, whose transforms go in blocks
    plan((512, 512), (1024, 1024)).apply(np.zeros((513, 513)))


PARTS = {
    "contacts": _contacts,
    "laws": _laws,
    "summits": _summits,
    "plan": _plan,
    "basins": _basins,
    "hardness": _hardness,
    "bem": _bem,
}
"""Each part with its scene."""


def types_once() -> None:
    """Let the compiler find the type of an operation once for operands of the same types.

    It tries about thirty rules wherever an operation stands, which takes a quarter of its time.
    Answers stay as they are: they follow from the operation and the types alone.
    """
    from numba.core.types import functions

    rules: Any = functions.BaseFunction
    find = rules.get_call_type
    known: dict[tuple[Any, Any], Any] = {}

    def found(operation: Any, context: Any, types: Any, named: Any) -> Any:
        if named:
            return find(operation, context, types, named)
        place = operation, tuple(types)
        signature = known.get(place)
        if signature is None:  # a rule may still be loaded
            signature = known[place] = find(operation, context, types, named)
        return signature

    rules.get_call_type = found


if __name__ == "__main__":
    types_once()
    # the compiler's objects are many and stay: looking through them for cycles again and again
    # takes a tenth of its time
    gc.disable()
    warnings.simplefilter("ignore", ContactWarning)
    for part in sys.argv[1:]:
        with compiling(part):
            PARTS[part]()
    # all is on disk; to take these objects down one by one would take seconds
    os._exit(0)
