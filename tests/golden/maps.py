"""The maps, materials and options of the golden curves.

Every case has its own branch of the model: a spectrum that ends before the pixel or at it, lay,
worn plateaus, grading, a free border, few hills, a form with noise and a taper, flat tops. Grids
and pixels are not square.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

import asperity
import surfaces

LOADS = np.array([1e-3, 3e-3, 1e-2, 2e-2, 4e-2, 7e-2])
"""Mean pressures over E* times the rms slope: contact fractions of about 0.2 to 14 %."""


@dataclass(frozen=True)
class Case:
    """One curve: what the map is made by, the grading, and the options of the model."""

    recipe: dict[str, Any] = field(default_factory=dict)
    m: float = 0.0
    kind: str = "random"
    model: dict[str, Any] = field(default_factory=dict)
    boundary: str = "periodic"
    points: tuple[int, int] = (256, 192)


CASES = {
    "random": Case({"cutoff": 8.0}),
    "random_long_waves": Case({"cutoff": 16.0, "hurst": 0.5}, model={"law": "ellipse"}),
    "to_the_pixel": Case({}, points=(512, 512)),
    "to_the_pixel_all_summits": Case({"cutoff": 3.0}, model={"scales": "all"}),
    "lay_4": Case({"cutoff": 8.0, "anisotropy": 4.0, "angle": 0.5}),
    "lay_6_to_the_pixel": Case({"anisotropy": 6.0}, points=(512, 640)),
    "worn": Case({"cutoff": 6.0}, kind="worn"),
    "graded_stiff_below": Case({"cutoff": 8.0}, m=0.3),
    "graded_stiff_above": Case({"cutoff": 8.0}, m=-0.3),
    "free": Case({"cutoff": 8.0}, boundary="free"),
    "few_hills": Case({"cutoff": 10.0, "rolloff": 1.0}, kind="hills"),
    "measured_like": Case({"cutoff": 6.0}, kind="measured"),
    "flat_tops": Case({"cutoff": 8.0}, kind="clipped"),
    "independent": Case({"cutoff": 8.0}, model={"interaction": False}),
}
"""The curves by name."""


def height_map(case: Case, scale: float = 1.0) -> surfaces.HeightMap:
    """The map of a case, with pixels of 1 by 1.25 um, on `scale` times its points."""
    ny, nx = (int(scale * n) for n in case.points)
    spacing = (1e-6, 1.25e-6)
    shape, size = (ny, nx), (ny * spacing[0], nx * spacing[1])
    recipe = {"hurst": 0.8, "rms_slope": 0.1, "seed": 5, **case.recipe}
    recipe["rolloff"] = recipe.get("rolloff", 0.125) * min(size)
    if recipe.get("cutoff") is not None:
        recipe["cutoff"] *= spacing[1]
    if case.kind == "worn":
        recipe.pop("hurst"), recipe.pop("rolloff")
        return surfaces.plateau_honed(shape, size, **recipe)
    hm = surfaces.self_affine(shape, size, **recipe)
    heights = hm.heights
    if case.kind == "clipped":
        return hm.replace(heights=np.minimum(heights, 1.2 * hm.rms_height))
    if case.kind == "hills":
        return hm.replace(heights=hm.rms_height * np.exp(heights / hm.rms_height))
    if case.kind == "measured":
        y, x = np.meshgrid(np.linspace(-1, 1, ny), np.linspace(-1, 1, nx), indexing="ij")
        noise = np.random.default_rng(7).normal(size=shape)
        heights = heights - hm.rms_height * (y**2 + 0.5 * x**2 - 0.02 * noise)
        bent = surfaces.prepare(surfaces.HeightMap(heights, spacing))
        return surfaces.make_periodic(bent, "taper", width=0.1 * min(size))
    return hm


def material(case: Case) -> asperity.HalfSpace:
    """The half-space of a case."""
    return asperity.HalfSpace(210e9, 0.3, case.m)
