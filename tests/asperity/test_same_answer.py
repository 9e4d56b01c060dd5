"""One answer to a question asked in several ways: one load or many, a load or a separation."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
import surfaces
from asperity.halfspace.load_points import default_pressures, pressure_scale
from asperity.interaction.ewald.operator import Interaction

BODY = asperity.HalfSpace.from_modulus(1.0)


def spheres(spread: float, seed: int = 1) -> surfaces.HeightMap:
    """9 x 9 caps of 7 to 9 pixels, of heights that differ by `spread` of their radius."""
    shape, rng = (128, 160), np.random.default_rng(seed)
    pitch = np.array(shape) / 9
    radius = 0.6 * pitch.max()
    heights = np.full(shape, -np.inf)
    for place, top in np.ndenumerate(rng.normal(0.0, spread * radius, (9, 9))):
        y, x = (
            (np.arange(n) + 0.5 - (k + 0.5) * step + n / 2) % n - n / 2
            for n, k, step in zip(shape, place, pitch, strict=True)
        )
        rest = np.maximum(radius**2 - y[:, None] ** 2 - x**2, 0.0)
        heights = np.maximum(heights, np.sqrt(rest) + top - radius)
    return surfaces.HeightMap(0.1 * (heights - heights.mean()), (1.0, 1.0), periodic=True)


def asked_apart(hm: surfaces.HeightMap, pressures: np.ndarray, **options):
    """Curve of the loads, and the differences from it, in load at equal separation and in area at
    equal load, of the loads from heavy to light with one twice, among many others, each alone, and
    of the separations."""
    curve = asperity.contact_curve(hm, BODY, pressures=pressures, **options)
    between = np.sqrt(pressures[1:] * pressures[:-1])
    more = np.sort(np.concatenate((pressures, between, 1.01 * between)))
    turned = np.append(pressures[::-1], pressures[-1])
    others = [
        asperity.contact_curve(hm, BODY, pressures=more, **options).select(
            np.searchsorted(more, pressures)
        ),
        asperity.contact_curve(hm, BODY, pressures=turned, **options).select(
            np.arange(len(pressures))[::-1]
        ),
        asperity.contact_curve(hm, BODY, separations=curve.separation, **options),
    ]
    alone = [asperity.contact_curve(hm, BODY, pressures=p, **options) for p in pressures]
    alone += [asperity.contact_curve(hm, BODY, separations=s, **options) for s in curve.separation]
    count = len(pressures)
    for part in (alone[:count], alone[count:]):
        joined = part[0]
        for one in part[1:]:
            joined = joined.joined(one)
        others.append(joined)
    assert curve.converged.all() and all(other.converged.all() for other in others)
    ratio = np.array([np.log(other.mean_pressure / curve.mean_pressure) for other in others])
    fall = np.array([curve.separation - other.separation for other in others])
    area = np.array([np.log(other.contact_area / curve.contact_area) for other in others])
    return curve, np.abs(ratio - fall * curve.stiffness / curve.mean_pressure), np.abs(area - ratio)


@pytest.mark.parametrize("spread", [0.0, 0.02])
def test_crowded_spheres(spread):
    """Their contacts stand beside their summits and near each other, and move with the load."""
    hm = spheres(spread)
    loads = np.array([5e-3, 2e-2, 6e-2, 0.12]) * pressure_scale(hm, BODY)
    curve, load, area = asked_apart(hm, loads)
    assert curve.area_fraction[-1] > 0.35
    assert load.max() < 0.02 and area.max() < 0.01


@pytest.mark.parametrize(("cutoff", "seed"), [(6.0, 11), (8.0, 12)])
def test_few_contacts_of_a_rough_map(cutoff, seed):
    """The laws of few summits, joined ones too, do not average out: they are those of the map."""
    shape = (160, 128)
    size = tuple(float(n) for n in shape)
    hm = surfaces.self_affine(shape, size, hurst=1.0, rms_slope=0.1, cutoff=cutoff, seed=seed)
    loads = np.array([1e-3, 3e-3, 1e-2, 3e-2, 0.1]) * pressure_scale(hm, BODY)
    _, load, area = asked_apart(hm, loads)
    assert load.max() < 0.015 and area.max() < 0.01


def test_long_contacts_do_not_hang_on_the_near_pairs_listed(monkeypatch):
    """Beyond the near pairs footprints are round."""
    size = (160.0, 192.0)
    hm = surfaces.self_affine(
        (160, 192), size, hurst=0.8, rms_slope=0.1, cutoff=6.0, seed=1, anisotropy=6.0, rolloff=24.0
    )
    loads = np.array([0.01, 0.04]) * pressure_scale(hm, BODY)
    few = asperity.contact_curve(hm, BODY, pressures=loads)
    monkeypatch.setitem(Interaction.__init__.__kwdefaults__, "neighbors", 160)
    many = asperity.contact_curve(hm, BODY, pressures=loads)
    assert few.converged.all() and many.converged.all() and few.area_fraction[-1] > 0.09
    change = (few.separation - many.separation) * many.stiffness / many.mean_pressure
    assert np.abs(change).max() < 0.01
    np.testing.assert_allclose(few.contact_area, many.contact_area, rtol=0.01)


def test_crowded_long_contacts():
    """Contacts that push each other aside, on summits of a lay: one load fell back on round
    footprints, which heavier loads took over, and differed by 3 % from the same load alone."""
    hm = surfaces.self_affine(
        (192, 256),
        (192.0, 256.0),
        hurst=0.8716,
        rms_slope=0.1,
        anisotropy=4.0,
        rolloff=30.0,
        seed=9001,
    )
    loads = np.array([5e-4, 1.3e-3, 3e-3, 1e-2]) * pressure_scale(hm, BODY)
    curve, load, _ = asked_apart(hm, loads)
    assert (load < 0.1 * curve.error_estimate).all()


@pytest.mark.parametrize(
    ("shape", "recipe"),
    [
        # residuals of many contacts do not average out where all start from a guess
        ((160, 192), {"hurst": 0.43, "cutoff": 3.0, "rolloff": 30.0, "seed": 9023}),
        # long footprints that need more than 24 steps to a small residual
        ((192, 384), {"hurst": 0.90967750155, "anisotropy": 4.0, "seed": 9013}),
    ],
)
def test_a_load_alone_agrees_with_one_of_a_curve(shape, recipe):
    """To about a tenth of the stated error; differences were 0.17 and 0.9 of it."""
    size = tuple(float(n) for n in shape)
    exact = surfaces.self_affine(shape, size, rms_slope=0.1, **recipe)
    shares = []
    for seed in range(3):
        noise = np.random.default_rng(seed).normal(0.0, 1e-12 * exact.rms_height, shape)
        hm = exact.replace(heights=exact.heights + noise)
        curve = asperity.contact_curve(hm, BODY, pressures=default_pressures(hm, BODY)).select([8])
        alone = asperity.contact_curve(hm, BODY, pressures=curve.mean_pressure)
        fall = (curve.separation - alone.separation) * curve.stiffness / curve.mean_pressure
        shares.append(np.abs(fall) / curve.error_estimate)
    assert np.max(shares) < 0.15


def test_crowded_ridges_turned_bear_the_same_load():
    """The last Newton step led off by up to 2 % of the load, a third of the stated error."""
    size = (256.0, 256.0)
    hm = surfaces.self_affine((256, 256), size, hurst=0.8, rms_slope=0.1, anisotropy=4.0, seed=8008)
    heights, load = hm.heights, default_pressures(hm, BODY)[-1]
    rolled = np.roll(heights, (37, 101), (0, 1))
    first, *others = (
        asperity.contact_curve(hm.replace(heights=same), BODY, pressures=load)
        for same in (heights, heights[::-1], heights[:, ::-1], heights.T, rolled)
    )
    rate = first.stiffness / first.mean_pressure / first.error_estimate
    area = first.contact_area, first.extra["area_error_estimate"]
    for other in others:
        assert abs(first.separation - other.separation) * rate < 0.1
        assert abs(np.log(other.contact_area / area[0])) < 0.1 * area[1]
