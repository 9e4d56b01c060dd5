"""The maps that corrections and constants of the model are judged on, and its errors there.

No constant was fitted on them: the families of accuracy.py, drawn.py, maps that resemble measured
ones, maps cut off flat, long lay and worn plateaus to the pixel, and measured maps. The reference
is boundary elements on the map refined twice (cut-off maps: on their own grid), tolerance 1e-4, at
seven loads; loads from 0.05 to 8.5 % of contact count. Load errors are taken at equal separation,
area errors at equal load. Families of one group are related.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from accuracy import RECIPES, TO_THE_PIXEL, measured_like, surface
from common import measured
from drawn import FAMILIES, drawn
from numpy.typing import NDArray

import asperity
import surfaces
from asperity.contacts.run import solve_contacts
from asperity.halfspace.scene import pressure_scale
from asperity.parameters import DEFAULTS, Parameters

__all__ = ["Scene", "errors", "reference", "scenes"]

LOADS = np.geomspace(5e-4, 4.5e-2, 7)
LIGHTEST, HEAVIEST = 5e-4, 8.5e-2
TOLERANCE = 1e-4

Array = NDArray[np.float64]


class Scene(NamedTuple):
    """One map, what it belongs to, and its body."""

    group: str
    family: str
    seed: int
    hm: surfaces.HeightMap
    m: float = 0.0
    boundary: str | None = None
    refined: bool = True
    hardness: float = math.inf

    @property
    def body(self) -> asperity.HalfSpace:
        """Half-space of unit modulus; its hardness is told over E* times the rms slope."""
        elastic = asperity.HalfSpace.from_modulus(1.0, m=self.m)
        scale = pressure_scale(self.hm, elastic)
        return asperity.HalfSpace.from_modulus(1.0, m=self.m, hardness=self.hardness * scale)


def group_of(family: str) -> str:
    """Group of a family of accuracy.py or drawn.py: those of one group are related."""
    if family.startswith("isotropic H 0.8 cut-off 32"):
        return "few hills"
    for group, names in {
        "graded": ("graded",),
        "worn": ("plateau",),
        "lay": ("anisotropic", "an1.5", "an2", "an3", "an4", "an6", "ground", "lay"),
        "to the pixel": ("to the pixel", "cut-off 3 px", "iso2:", "iso3:", "expo:", "spectrum"),
        "few hills": ("few summits", "bumps", "caps", "iso24", "iso32"),
        "regular": ("lattice", "hexlat", "spheres", "weier", "bands"),
        "disturbed": ("noise", "spikes", "steps", "heighttail"),
        "free border": ("free",),
        "isotropic": ("iso", "gauss", "expocut"),
    }.items():
        if family.startswith(names):
            if group == "to the pixel" and "lay" in family:
                return "lay to the pixel"
            return "graded" if "graded" in family else group
    raise KeyError(family)


def special(seed: int) -> Iterator[Scene]:
    """Maps for corrections that no other family needs: flat tops, long lay, worn to the pixel."""
    base = surface(256, seed, RECIPES["isotropic H 0.8 cut-off 8 px"])
    for level in (1.0, 2.0):
        heights = np.minimum(base.heights, base.heights.mean() + level * base.rms_height)
        hm = surfaces.HeightMap(heights, base.spacing, periodic=True)
        yield Scene("cut off flat", f"cut off at {level:g} rms", seed, hm, refined=False)
    shape, size = (512, 512), (512.0, 512.0)
    for ratio in (6.0, 8.0):
        recipe = {"hurst": 0.8, "rms_slope": 0.1, "rolloff": 64.0, "anisotropy": ratio}
        hm = surfaces.self_affine(shape, size, cutoff=None, seed=seed, **recipe)
        yield Scene("lay to the pixel", f"to the pixel, lay {ratio:g}:1", seed, hm)
    hm = surfaces.plateau_honed(shape, size, rms_slope=0.1, cutoff=2.0, seed=seed)
    yield Scene("worn", "plateau-honed to the pixel", seed, hm)
    heights = surface(512, seed, TO_THE_PIXEL["to the pixel H 0.8"]).heights
    hm = surfaces.prepare(surfaces.HeightMap(heights, (1.0, 1.0)), periodic="taper")
    yield Scene("fading border", "to the pixel, fading border", seed, hm)


def hills(seed: int) -> Iterator[Scene]:
    """Single tips, and wide hills with fine waves on top."""
    points, steps = 192, np.arange(192.0)
    r = np.hypot(steps[:, None] - points / 2, 1.1 * (steps - points / 2 + 0.1 * (seed % 5)))
    for power in (1.0, 1.5, 3.0):
        heights = -0.1 * points / 2 * (2.0 * r / points) ** power
        hm = surfaces.HeightMap(heights, (1.0, 1.1))
        yield Scene("single tip", f"tip r^{power:g}", seed, hm, boundary="free")
    waves = surfaces.self_affine(
        (points, points),
        (192.0, 192.0),
        hurst=0.8,
        rms_slope=0.1,
        rolloff=16.0,
        cutoff=5.0,
        seed=seed,
    )
    angle = 2.0 * np.pi * steps / points
    lattice = np.cos(2.0 * angle)[:, None] + np.cos(2.0 * angle)
    shapes = {
        "rough sphere": -(r**2) / (2.0 * 600.0),
        "rough lattice of hills": 4.0 * waves.rms_height * lattice,
    }
    for name, shape in shapes.items():
        hm = surfaces.HeightMap(shape + waves.heights, (1.0, 1.0), periodic="lattice" in name)
        boundary = None if hm.periodic else "free"
        yield Scene(name, name, seed, hm, boundary=boundary)


def large(seed: int) -> Iterator[Scene]:
    """Larger maps, on which more spectra are split."""
    shape, size = (1024, 1024), (1024.0, 1024.0)
    hm = surfaces.plateau_honed(shape, size, rms_slope=0.1, cutoff=2.0, seed=seed)
    yield Scene("worn", "plateau-honed to the pixel, large", seed, hm)
    for ratio in (4.0, 8.0):
        recipe = {"hurst": 0.8, "rms_slope": 0.1, "rolloff": 128.0, "anisotropy": ratio}
        hm = surfaces.self_affine(shape, size, cutoff=None, seed=seed, **recipe)
        yield Scene("lay to the pixel", f"to the pixel, lay {ratio:g}:1, large", seed, hm)
    hm = surface(1024, seed, RECIPES["isotropic H 0.8 cut-off 32 px"])
    yield Scene("few hills", "isotropic H 0.8 cut-off 32 px, large", seed, hm)


def scenes(maps: Path | None) -> Iterator[Scene]:
    """All judged maps."""
    for points, seeds in ((256, (61, 62)), (512, (31,))):
        for seed in seeds:
            for name, recipe in (RECIPES | TO_THE_PIXEL).items():
                hm = surface(points, seed, recipe)
                yield Scene(group_of(name), name, seed, hm, recipe.get("m", 0.0))
    for seed in (61, 62):
        for name, hm in measured_like(256, seed).items():
            group = "lay" if name.startswith("lay") else group_of(name)
            yield Scene(group, f"{name} (like measured)", seed, hm)
        yield from special(seed)
        yield from hills(seed)
    yield from large(31)
    for seed in (101, 102):
        for name in FAMILIES:
            hm, m, boundary = drawn(name, seed)
            yield Scene(group_of(name), f"drawn {name}", seed, hm, m, boundary)
    for path in sorted(maps.glob("*.h5")) if maps else ():
        yield Scene("measured", path.stem, 0, measured(path))


def reference(scene: Scene, kept: Path | None) -> asperity.ContactCurve:
    """Boundary elements; kept and read back."""
    grid = scene.hm
    if scene.refined:
        grid = surfaces.resample(grid, np.asarray(grid.spacing) / 2)
    plastic = f"_{scene.hardness:g}" if scene.hardness < math.inf else ""
    path = kept and kept / f"{grid.digest}_{scene.m:g}{plastic}.h5"
    if path and path.exists():
        return asperity.ContactCurve.from_hdf5(path)
    body = scene.body
    pressures = LOADS * pressure_scale(scene.hm, body)
    solved = {"pressures": pressures, "tolerance": TOLERANCE, "boundary": scene.boundary}
    curve = asperity.bem_curve(grid, body, **solved)
    if path:
        curve.to_hdf5(path)
    return curve


def errors(
    scene: Scene, exact: asperity.ContactCurve, parameters: Parameters = DEFAULTS
) -> tuple[Array, Array, float]:
    """Errors of load at equal separation and area at equal load, NaN where a point does not come
    out, and seconds of the processor for the second."""
    body = scene.body
    chosen = {"boundary": scene.boundary, "parameters": parameters}
    hm = surfaces.HeightMap(scene.hm.heights, scene.hm.spacing, periodic=scene.hm.periodic)
    plan = asperity.make_plan(hm, body, separations=exact.separation, **chosen)
    same = solve_contacts(hm, body, plan, separations=exact.separation).curve
    hm = surfaces.HeightMap(scene.hm.heights, scene.hm.spacing, periodic=scene.hm.periodic)
    start = time.process_time()
    plan = asperity.make_plan(hm, body, pressures=exact.mean_pressure, **chosen)
    model = solve_contacts(hm, body, plan, pressures=exact.mean_pressure).curve
    seconds = time.process_time() - start
    load = np.where(same.converged, same.mean_pressure / exact.mean_pressure - 1.0, np.nan)
    area = np.where(model.converged, model.contact_area / exact.contact_area - 1.0, np.nan)
    counted = (exact.area_fraction >= LIGHTEST) & (exact.area_fraction <= HEAVIEST)
    return load[counted], area[counted], seconds
