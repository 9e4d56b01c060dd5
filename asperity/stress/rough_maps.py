"""Stress cases of rough maps: exact scalings, symmetries, bounds and certificates."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from asperity.bem.curve import bem_curve
from asperity.bem.solve import bem_solve
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import pressure_scale
from surfaces.arrays import Array
from surfaces.heightmap import HeightMap
from surfaces.preparation.resampling import resample

from .case import BEM, Case
from .closed_forms import periodic_displacement, wave_contact
from .judges import ENGINES, Question, alike, bounded, certified, close, refuse
from .maps import TEXTURES, rough, rough_heights

__all__ = ["map_cases"]

UNIT = 1e-6
"""Pixel size [m] of maps whose units are not the point."""

MODULI = 1e-3, 1.0, 1e3, 1e6, 1e12, 1e15
LENGTHS = 1e-12, 1e-9, 1e-3, 1.0, 1e3
OFFSETS = -1e3, 1.0, 1e3, 1e6, 1e9, 1e12
SLOPES = 1e-15, 1e-9, 1e-6, 1e-3, 1.0, 10.0, 100.0
GRADINGS = -0.99, -0.9, -0.5, -0.1, 0.1, 0.5, 0.9, 0.99
PIXELS = 0.02, 0.1, 0.5, 2.0, 10.0, 50.0
GRIDS = (4, 256), (8, 512), (512, 8), (3, 192), (3, 3), (5, 7), (61, 67)
FINER = 4
"""How much finer the grid is on which boundary elements judge the model at light loads: contacts
are a pixel or a few on the grid of the map, which does not show the summits."""

LIGHTEST = 1e-5
"""Loads over the scale below which one summit touches, on less than a pixel."""

LOADS = 1e-45, 1e-35, 1e-20, 1e-10, 1e-6, 1e-4, 1.0


def map_cases() -> Iterator[Case]:
    """Cases of height maps, by theme."""
    yield from _units()
    yield from _symmetries()
    yield from _materials()
    yield from _grids()
    yield from _loads()
    yield from _textures()


def _units() -> Iterator[Case]:
    """Modulus, lengths and slopes: the same answer in other units."""
    scaling = partial(_alike, "scaling", Question.of(rough()))
    for modulus in MODULI:
        other = Question.of(rough(), HalfSpace.from_modulus(modulus))
        yield from scaling(other, "moduli", f"{modulus:g} Pa", pressure=modulus / 1e9)
    for length in LENGTHS:
        other = Question.of(rough(pixel=length))
        yield from scaling(other, "lengths", f"{length:g} m", length=length / UNIT)
    for slope in SLOPES:
        other, factor = Question.of(rough(slope=slope)), slope / 0.1
        yield from scaling(other, "slopes", f"{slope:g}", length=factor, pressure=factor)


def _alike(
    against: str, question: Question, other: Question, theme: str, name: str, **units: float
) -> Iterator[Case]:
    """Two questions of one answer, to every engine; `units` are those of `alike`."""
    for engine in ENGINES:
        judge = partial(alike, engine, question, other, **units)
        yield Case(theme, name, engine, against, judge)


def _bounded(question: Question, theme: str, name: str) -> Iterator[Case]:
    """Boundary elements by displacements of another code, the other engines by their bounds."""
    yield Case(theme, name, BEM, "certificate", partial(certified, question))
    for engine in ENGINES:
        if engine != BEM:
            yield Case(theme, name, engine, "stated error", partial(bounded, engine, question))


def _symmetries() -> Iterator[Case]:
    """The same surface raised, turned, mirrored, moved, or disturbed by rounding."""
    question = Question.of(rough())
    hm = question.hm
    rms, heights = hm.rms_height, hm.heights
    tiny = 1e-12 * rms * np.random.default_rng(2).normal(size=hm.shape)
    changed = {
        "mirrored": hm.replace(heights=heights[:, ::-1]),
        "turned over": hm.replace(heights=heights[::-1, ::-1]),
        "transposed": hm.replace(heights=heights.T),
        "moved": hm.replace(heights=np.roll(heights, (7, 31), (0, 1))),
        "rounding": hm.replace(heights=heights + tiny),
    }
    for name, other in changed.items():
        yield from _alike("symmetry", question, question.on(other), "same surface", name)
    for offset in OFFSETS:
        raised, name = heights + offset * rms, f"{offset:g} rms heights"
        lowered = question.on(hm.replace(heights=raised - offset * rms))  # what is left of it
        lifted = question.on(hm.replace(heights=raised))
        yield from _alike("symmetry", lowered, lifted, "offset of heights", name)


def _materials() -> Iterator[Case]:
    """Gradings."""
    for m in GRADINGS:
        question = Question.of(rough(), HalfSpace.from_modulus(1e9 * UNIT**-m, m))
        yield from _bounded(question, "grading", f"m = {m}")


def _grids() -> Iterator[Case]:
    """Pixels that are not square, and slim or small grids."""
    heights = 0.1 * UNIT * rough_heights()
    maps = {
        f"pixel of 1:{ratio:g}": HeightMap(heights, (UNIT, ratio * UNIT), periodic=True)
        for ratio in PIXELS
    } | {f"{ny} x {nx}": _small((ny, nx)) for ny, nx in GRIDS}
    for name, hm in maps.items():
        question = Question.of(hm, heaviest=0.05)
        turned = HeightMap(hm.heights.T, hm.spacing[::-1], periodic=True)
        theme = "pixels" if name.startswith("pixel") else "grids"
        yield Case(theme, name, BEM, "certificate", partial(certified, question))
        yield from _alike("symmetry", question, question.on(turned), theme, name)


def _small(shape: tuple[int, int]) -> HeightMap:
    """Rough map of any shape, cut from a large one."""
    side = max(*shape, 64)
    heights = rough_heights((side, side), cutoff=4.0)[: shape[0], : shape[1]]
    return HeightMap(0.1 * UNIT * heights, (UNIT, UNIT), periodic=True)


def _loads() -> Iterator[Case]:
    """From one pixel or summit in contact to beyond full contact."""
    for load in LOADS:
        question = Question.of(rough(), lightest=load, heaviest=10.0 * load)
        name = f"{load:g} of the scale"
        yield Case("loads", name, BEM, "certificate", partial(certified, question))
        for engine in ("solve", "solve, anchored"):
            judge = partial(bounded, engine, question)
            yield Case("loads", name, engine, "stated error", judge)
        fine = resample(question.hm, UNIT / FINER)
        judge, against = partial(bounded, "model", question, fine), "stated error"
        if load < LIGHTEST:
            judge, against = partial(_one_summit, question), "scaling"
        yield Case("loads", name, "model", against, judge)
    for share in (1.01, 2.0, 100.0, 1e6):
        for m in (-0.5, 0.0, 0.5):
            yield Case(
                "loads",
                f"{share:g} of full contact, m = {m}",
                BEM,
                "closed form",
                partial(_full_contact, share, m),
            )
        for engine in ENGINES:
            judge = partial(_all_touches, engine, share)
            yield Case("loads", f"{share:g} of full contact", engine, "closed form", judge)
    for share in (1e-4, 1e-2, 0.1, 0.5, 0.9, 0.99):
        yield Case(
            "loads", f"ridges, {share:g} of full contact", BEM, "closed form", partial(_wave, share)
        )


def _one_summit(question: Question) -> float:
    """Hertz: the area of one summit grows as the load to the power 2/3."""
    curve = question.answer("model")
    grown = curve.contact_area / curve.mean_pressure ** (2.0 / 3.0)
    return float(np.ptp(grown[curve.converged]) / grown[curve.converged].mean()) / 1e-2


def _flattening(hm: HeightMap, material: HalfSpace) -> Array:
    """Pressure [Pa] that flattens a map wave by wave, zero on average."""
    unit = np.zeros(hm.shape)
    unit[0, 0] = 1.0
    answer = np.fft.rfft2(periodic_displacement(unit, hm.spacing, material.modulus, material.m))
    answer[0, 0] = 1.0
    waves = np.fft.rfft2(hm.heights)
    waves[0, 0] = 0.0
    return np.fft.irfft2(waves / answer, s=hm.shape)


def _full_contact(share: float, m: float) -> float:
    """Full contact: the pressure is the load and the one that flattens every wave."""
    hm, material = rough(), HalfSpace.from_modulus(1e9 * UNIT**-m, m)
    flattening = _flattening(hm, material)
    load = -share * float(flattening.min())
    found = bem_solve(hm, material, pressure=load)
    refuse(found.reason)
    off = float(np.abs(found.pressure - flattening - load).max() / np.abs(flattening).max())
    return max(off / 1e-4, abs(found.area_fraction - 1.0) / 1e-9, found.separation / hm.rms_height)


def _all_touches(engine: str, share: float) -> float:
    """Beyond full contact all of the area touches and no gap is left."""
    hm, material = rough(), HalfSpace.from_modulus(1e9)
    full = -float(_flattening(hm, material).min())
    loads = full * np.array([0.02, 0.1, 0.5, share, 2.0 * share])
    curve = Question(hm, material, loads).answer(engine)
    if not curve.converged[-1]:
        refuse(curve.reasons[-1])
    gap = abs(float(curve.separation[-1])) / hm.rms_height
    return max(gap / 1e-3, abs(float(curve.area_fraction[-1]) - 1.0) / 1e-3)


def _wave(share: float) -> float:
    """A wave of ridges on 512 points: Westergaard's area and mean gap."""
    x = 2.0 * np.pi * np.arange(512) / 512
    hm = HeightMap(np.tile(0.01 * np.cos(x), (4, 1)), (1.0 / 512, 1.0 / 512), periodic=True)
    material = HalfSpace.from_modulus(1e9)
    load = share * np.pi * 1e9 * 0.01
    curve = bem_curve(hm, material, pressures=[load], tolerance=1e-8)
    refuse(curve.reasons[0])
    area, gap = wave_contact(np.array(share))
    found = curve.area_fraction[0], curve.separation[0] / 0.01
    two_pixels = 2.0 / (512.0 * float(area))
    return close(found, (float(area), float(gap)), (0.01 + two_pixels, 0.01))


def _textures() -> Iterator[Case]:
    for name, heights in TEXTURES.items():
        for boundary in ("periodic", "free"):
            hm = HeightMap(0.1 * UNIT * heights(), (UNIT, UNIT), periodic=boundary == "periodic")
            yield from _bounded(_of_texture(hm), "textures", f"{name}, {boundary}")
    missing = rough_heights()
    missing[20:23] = np.nan
    question = Question(HeightMap(missing, (UNIT, UNIT)), HalfSpace.from_modulus(1e9), np.ones(1))
    for engine in ENGINES:
        judge = partial(alike, engine, question, question)
        yield Case("textures", "missing rows", engine, "refusal", judge, must_refuse=True)


def _of_texture(hm: HeightMap) -> Question:
    """Five loads; of a map without slopes some pressures."""
    material = HalfSpace.from_modulus(1e9)
    if pressure_scale(hm, material) > 0.0:
        return Question.of(hm)
    return Question(hm, material, 1e5 * np.geomspace(1e-3, 0.1, 5))
