"""What pixels leave open: found where it is, and not looked for where contacts are resolved."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import surfaces
from asperity import HalfSpace, bem_curve, solve
from asperity.bem import part
from asperity.bem.answer import answer
from asperity.engine import resolution
from asperity.engine.resolution import PIXELS, narrow_share, opened_share
from asperity.halfspace.scene import closed_share, default_pressures

BODY = HalfSpace.from_modulus(1.0)


def waves(cutoff: float | None, points: int = 128) -> surfaces.HeightMap:
    return surfaces.self_affine(
        (points, points), (float(points), float(points)),
        hurst=0.8, rms_slope=0.1, cutoff=cutoff, rolloff=32.0, seed=1,
    )  # fmt: skip


def wrapped() -> surfaces.HeightMap:
    """A part of a larger map, taken as periodic."""
    return surfaces.HeightMap(waves(8.0, 256).heights[:128, :128], (1.0, 1.0), periodic=True)


def clipped() -> surfaces.HeightMap:
    """Heights cut off, with noise of rounding."""
    heights = waves(8.0).heights
    heights = np.minimum(heights, heights.std())
    noise = 1e-12 * heights.std() * np.random.default_rng(0).normal(size=heights.shape)
    return surfaces.HeightMap(heights + noise, (1.0, 1.0), periodic=True)


def ridges() -> surfaces.HeightMap:
    """Sharp riblets of uneven height, whose contacts are long and a pixel wide."""
    fine = waves(4.0)
    y, x = np.meshgrid(*2 * ((np.arange(128) + 0.5) / 128,), indexing="ij")
    place, which = np.modf(5.0 * x)
    heights = 4.0 * np.minimum(place / 0.8, (1.0 - place) / 0.2) + 0.1 * np.sin(
        6 * np.pi * y + which
    )
    heights += 0.3 * np.random.default_rng(0).normal(size=5)[which.astype(int)]
    return fine.replace(heights=heights + 0.1 * fine.heights / fine.rms_height)


def blocks() -> surfaces.HeightMap:
    """Tops rougher than the map, between grooves whose walls hold most of the slope."""
    fine = waves(6.0)
    y, x = np.meshgrid(*2 * ((np.arange(128) + 0.5) / 128,), indexing="ij")
    walls = (np.tanh(5.0 * (np.abs(np.sin(np.pi * turns)) - 0.25)) for turns in (5 * y, 4 * x))
    heights = 2.0 * np.minimum(sum(walls), 1.6)
    return fine.replace(heights=heights + 0.05 * fine.heights / fine.rms_height)


def hill_above_blocks() -> surfaces.HeightMap:
    """A smooth hill bears the lightest loads; heavier ones reach blocks that are rough."""
    low = blocks()
    y, x = np.indices(low.shape) - 64.0
    hill = low.heights.max() + 1.0 - (x**2 + y**2) / 400.0
    return low.replace(heights=np.maximum(low.heights, hill))


def difference(hm, loads):
    """Largest differences in load and area to the map on a grid twice as fine."""
    own = bem_curve(hm, BODY, pressures=loads, tolerance=1e-5)
    fine = surfaces.resample(hm, np.asarray(hm.spacing) / 2)
    finer = bem_curve(fine, BODY, pressures=loads, tolerance=1e-5)
    rate = own.stiffness / own.mean_pressure
    load = np.abs(rate * (own.separation - finer.separation))
    return load.max(), np.abs(np.log(own.contact_area / finer.contact_area)).max()


@pytest.mark.parametrize(
    "make",
    [lambda: waves(None, 256), wrapped, clipped, ridges, blocks, hill_above_blocks],
    ids=["pixel", "cliff", "clip", "ridges", "blocks", "hill"],
)
def test_uncertainty_covers_the_finer_grid(make):
    hm = make()
    loads = default_pressures(hm, BODY, 6)
    load, area = difference(hm, loads)
    stated = solve(hm, BODY, pressures=loads).verification["resolution_uncertainty"]
    assert load <= stated[0] and area <= stated[1]


def test_a_part_bears_the_load_of_its_contacts(monkeypatch):
    """All that touches is one rough hill: its part is pressed as it is on the whole map."""
    fine = waves(None, 256)
    y, x = np.indices(fine.shape) - 128.0
    hill = fine.replace(heights=fine.heights / fine.rms_height - (x**2 + y**2) / 250.0)
    loads = [1e-5, 4e-5, 1.6e-4]
    stated = {}
    for tile in (128, 256):
        monkeypatch.setattr(part, "POINTS", tile)
        stated[tile] = solve(hill, BODY, pressures=loads).verification["resolution_uncertainty"]
    assert stated[256][1] > 2.0 * PIXELS.floor[1]  # the case tells something
    assert stated[128] == pytest.approx(stated[256], rel=0.2)


def test_resolved_contacts_are_told_without_another_solution():
    hm = waves(12.0)
    curve = solve(hm, BODY)
    assert curve.verification["resolution_uncertainty"] == list(PIXELS.floor)
    load, area = difference(hm, curve.mean_pressure[3:])  # of 100 pixels: one of 20 is 5 %
    assert load <= PIXELS.floor[0] and area <= PIXELS.floor[1]
    assert not any("pixels" in warning for warning in curve.settings["warnings"])


def test_cure_is_named_where_the_uncertainty_is_large():
    noise = np.random.default_rng(1).normal(size=(96, 96))
    curve = solve(surfaces.HeightMap(noise, (1.0, 1.0), periodic=True), BODY)
    assert any("bandpass" in warning for warning in curve.settings["warnings"])


@pytest.mark.parametrize("lightest", [0.01, 1.0])
@pytest.mark.parametrize("hardness", [0.01, 0.3])
def test_a_load_of_the_hardness_itself_is_answered(hardness, lightest):
    """Rounding put loads of the finer grid above the hardness."""
    hm, body = waves(None, 64), HalfSpace.from_modulus(1.0, hardness=hardness)
    found = solve(hm, body, pressures=[lightest * hardness, hardness])
    assert found.contact_area[-1] == pytest.approx(hm.area)


def test_share_of_narrow_contacts():
    contact = np.zeros((20, 20), bool)
    contact[2:4, 2:4] = True
    contact[10:14, 10:14] = True
    assert narrow_share(contact) == 4 / 20
    contact[:] = False
    contact[-2:, 3:9] = True  # the border of the part cuts it
    assert narrow_share(contact) == 0.0
    contact[:] = False
    contact[:, 7] = True  # a ridge is as narrow as it is long
    assert narrow_share(contact) == 1.0
    assert narrow_share(~contact) == 0.0


@pytest.mark.parametrize("m", [0.0, 0.3])
def test_share_that_short_waves_open(m):
    """Waves of two pixels, pressed by half the pressure that flattens them; none in a plane."""
    dy, dx, pressed = 2e-6, 3e-6, np.zeros((8, 10), bool)
    pressed[:, :4] = True  # up to two borders of a free map
    body = HalfSpace.from_modulus(1e9, m)
    waves_of_two = np.tile([1e-8, -1e-8], (8, 5))
    flattens = 1e9 * (dx / np.pi) ** m * 2e-8 / dx
    load = 0.5 * flattens * pressed.mean()
    for heights, periodic, expected in (
        (waves_of_two, True, 1.0 - closed_share(0.5)),
        (waves_of_two, False, 1.0 - closed_share(0.5)),
        (np.add.outer(np.arange(8.0), np.arange(10.0)), False, 0.0),
    ):
        hm = surfaces.HeightMap(heights, (dy, dx), periodic=periodic)
        point = SimpleNamespace(hm=hm, contact=pressed, mean_pressure=load)
        share = opened_share(point, body, periodic=periodic)
        assert share == pytest.approx(expected, abs=1e-12)


def test_a_contact_without_elastic_energy_is_answered():
    """Every second point of a checkerboard: the influence of its own wave alone is rounding."""
    heights = np.add.outer(np.arange(45), np.arange(4)) % 2 * 1e-3
    hm = surfaces.HeightMap(heights, (0.15, 0.024), periodic=True)
    body = HalfSpace.from_modulus(4e10)
    curve = solve(hm, body, pressures=[4e6])
    assert curve.converged.all()
    assert np.isfinite(curve.verification["resolution_uncertainty"]).all()


def test_a_load_that_does_not_converge_on_a_finer_grid_leaves_an_unknown_part_open(monkeypatch):
    def stalled(*solution):
        return {**answer(*solution), "converged": False}

    hm = waves(None)
    loads = default_pressures(hm, BODY, 3)
    solved = resolution.SolvedLoads(BODY, "periodic", "pressure", loads)
    bem_curve(hm, BODY, pressures=loads[:1], progress=solved)
    monkeypatch.setattr(resolution, "answer", stalled)
    found = resolution.resolution(hm, solved)
    assert np.isnan([found.load, found.area]).all()
    assert "did not converge" in found.told_by and "an unknown part" in found.warnings[0]


def test_a_lightest_load_that_was_solved_before_tells_of_the_pixels():
    """A resumed run: what the file holds is not solved again, but lies on the same curve."""
    hm = waves(4.0).replace(spacing=(1.2, 1.0))
    loads = default_pressures(hm, BODY, 4) * [1e-2, 1.0, 1.0, 1.0]
    whole = solve(hm, BODY, pressures=loads)
    held = bem_curve(hm, BODY, pressures=loads[:2], accuracy=(0.05, 0.1))

    def judge(hm, body, *, pressures, **how):
        if len(pressures) == 1:
            return bem_curve(hm, body, pressures=pressures, **how)
        return held.joined(bem_curve(hm, body, pressures=pressures[2:], **how))

    resumed = solve(hm, BODY, pressures=loads, judge=judge)
    names = "resolution", "resolution_uncertainty"
    for name in names:
        assert resumed.verification[name] == whole.verification[name]
