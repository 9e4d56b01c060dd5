"""Stress cases that have no answer: each must be refused in one sentence."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from asperity.bem.single import indent_bem
from asperity.bem.solve import bem_solve
from asperity.halfspace.material import HalfSpace
from asperity.microcontact.single.indent import indent
from surfaces.heightmap import HeightMap
from surfaces.polar import PowerLawProfile

from .case import BEM, Case
from .judges import ENGINES
from .maps import rough

__all__ = ["refusal_cases"]

NOT_MATERIALS: dict[str, tuple[Any, ...]] = {
    "E = 0": (0.0, 0.3),
    "E = -1": (-1.0, 0.3),
    "E infinite": (math.inf, 0.3),
    "E no number": (math.nan, 0.3),
    "nu = 0.51": (1.0, 0.51),
    "nu = -1": (1.0, -1.0),
    "m = 1": (1.0, 0.3, 1.0),
    "m = -1": (1.0, 0.3, -1.0),
    "E as text": ("steel", 0.3),
}
NOT_MAPS: dict[str, tuple[Any, Any]] = {
    "1 x n": (np.ones((1, 64)), 1e-6),
    "n x 2": (np.ones((64, 2)), 1e-6),
    "three axes": (np.ones((4, 4, 4)), 1e-6),
    "infinite height": (np.full((8, 8), np.inf), 1e-6),
    "nothing but missing": (np.full((8, 8), np.nan), 1e-6),
    "complex": (np.full((8, 8), 1j), 1e-6),
    "text": (np.full((8, 8), "a"), 1e-6),
    "pixel of 0": (np.eye(8), 0.0),
    "pixel of 1:2000": (np.eye(8), (1.0, 2000.0)),
    "heights of 1e200 m": (1e200 * np.eye(8), 1.0),
}
NOT_LOADS: dict[str, Any] = {
    "negative": [-1.0],
    "infinite": [math.inf],
    "no number": [math.nan],
    "none": [],
    "text": ["much"],
    "1e50 Pa": [1e50],
    "1e-50 Pa": [1e-50],
}
NOT_DEPTHS: dict[str, Any] = {"infinite": math.inf, "no number": math.nan, "text": "deep"}


def refusal_cases() -> Iterator[Case]:
    """Cases without an answer."""
    for name, values in NOT_MATERIALS.items():
        yield _case("material", name, partial(HalfSpace, *values))
    for name, given in NOT_MAPS.items():
        yield _case("map", name, partial(HeightMap, *given))
    material, hm, ball = HalfSpace.from_modulus(1e9), rough(), PowerLawProfile(2.0, 0.5)
    for engine, ask in ENGINES.items():
        for name, loads in NOT_LOADS.items():
            yield _case(engine, f"load: {name}", partial(ask, hm, material, pressures=loads))
        for name, scene in {"no map": (hm.heights, material), "no material": (hm, 1e9)}.items():
            yield _case(engine, name, partial(ask, *scene, pressures=[1.0]))
        yield _case(engine, "no boundary", partial(ask, hm, material, boundary="open"))
    yield _case(BEM, "no gap left", partial(bem_solve, hm, material, separation=0))
    for name, depth in NOT_DEPTHS.items():
        yield _case("law auto", f"approach: {name}", partial(indent, ball, material, depth))
        press = partial(indent_bem, ball, material, depth)
        yield _case(BEM, f"approach: {name}", press)
    for k in (0.0, -1.0, math.nan):
        yield _case("law auto", f"tip of power {k}", partial(PowerLawProfile, k, 1.0))


def _case(engine: str, name: str, ask: partial[Any]) -> Case:
    return Case("no answer", name, engine, "refusal", partial(_asked, ask), must_refuse=True)


def _asked(ask: partial[Any]) -> float:
    ask()
    return 0.0
