"""What pixels leave open: found where it is, and not looked for where contacts are resolved."""

from __future__ import annotations

import numpy as np
import pytest

import surfaces
from asperity import HalfSpace, bem_curve, solve
from asperity.engine.resolution import FLOOR, small_share
from asperity.halfspace.scene import default_pressures

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


def difference(hm, loads):
    """Largest differences in load and area to the map on a grid twice as fine."""
    own = bem_curve(hm, BODY, pressures=loads, tolerance=1e-5)
    fine = surfaces.resample(hm, np.asarray(hm.spacing) / 2)
    finer = bem_curve(fine, BODY, pressures=loads, tolerance=1e-5)
    rate = own.load / own.extra["elastic_energy"]
    load = np.abs(rate * (own.separation - finer.separation))
    return load.max(), np.abs(np.log(own.contact_area / finer.contact_area)).max()


@pytest.mark.parametrize(
    "make", [lambda: waves(None, 256), wrapped, clipped], ids=["pixel", "cliff", "clip"]
)
def test_uncertainty_covers_the_finer_grid(make):
    hm = make()
    loads = default_pressures(hm, BODY, 6)
    load, area = difference(hm, loads)
    stated = solve(hm, BODY, pressures=loads).verification["resolution_uncertainty"]
    assert load <= stated[0] and area <= stated[1]


def test_resolved_contacts_are_told_without_another_solution():
    hm = waves(12.0)
    curve = solve(hm, BODY)
    assert curve.verification["resolution_uncertainty"] == list(FLOOR)
    load, area = difference(hm, curve.mean_pressure)
    assert load <= FLOOR[0] and area <= FLOOR[1]
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


def test_share_of_small_contacts():
    contact = np.zeros((20, 20), bool)
    contact[2:4, 2:4] = True
    contact[10:14, 10:13] = True
    assert small_share(contact, periodic=False) == 4 / 16
    contact[:] = False
    contact[0, :6] = contact[-1, :6] = True
    assert small_share(contact, periodic=False) == 1.0
    assert small_share(contact, periodic=True) == 0.0
