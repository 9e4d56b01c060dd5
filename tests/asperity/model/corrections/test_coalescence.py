"""Areas of contacts that have joined: closed forms, boundary elements, slow twins of the loops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import asperity
import surfaces
from asperity import HalfSpace
from asperity.halfspace.load_points import pressure_scale
from asperity.model.corrections import _coalescence_kernels as kernels
from asperity.model.corrections.coalescence import Basins
from asperity.model.decomposition import Asperities
from asperity.model.plan import make_plan
from surfaces.peaks.segmentation import segment
from surfaces.peaks.summits import locate_summits

SPACING = (0.8, 1.0)


def egg_box(height: float = 1.0, shape=(60, 64)) -> surfaces.HeightMap:
    """Four equal summits of a cell of 24 by 32."""
    y, x = (2 * np.pi * np.arange(n) / n for n in shape)
    waves = np.cos(2 * y)[:, None] + np.cos(2 * x)
    spacing = 48.0 / shape[0], 64.0 / shape[1]
    return surfaces.HeightMap(0.5 * height * waves, spacing, periodic=True)


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.3])
def test_a_paraboloid_has_the_area_of_its_law(m):
    """Where little of the basin touches, F = 4 E a^(3+m) / (p^2 (p + 2) R) on the summit."""
    hm, body = egg_box(shape=(300, 320)), HalfSpace.from_modulus(3.0, m=m)
    summits = locate_summits(hm, segment(hm))
    basins = Basins(summits, body)
    radius = 3.0
    bend = np.sqrt(np.prod(summits.curvature, axis=1))
    force = 12.0 * bend * radius ** (3 + m) / ((1 + m) ** 2 * (3 + m))
    approach = radius**2 * bend / (1 + m)
    area, fall = basins._carrying(np.arange(len(summits)), approach, force)
    np.testing.assert_allclose(area, np.pi * radius**2, rtol=0.04)
    np.testing.assert_allclose(fall, 0.5 * bend * radius**2, rtol=0.06)


def test_no_more_than_its_basin_touches_however_much_it_carries():
    hm, body = egg_box(), HalfSpace.from_modulus(1.0)
    summits = locate_summits(hm, segment(hm))
    rows = np.arange(len(summits))
    basin = hm.area / len(rows)
    areas = [
        Basins(summits, body)._carrying(rows, np.full(len(rows), 2.0), np.full(len(rows), force))[0]
        for force in (1.0, 20.0, 60.0, 200.0, 2e4)
    ]
    assert (np.diff(areas, axis=0) >= 0.0).all()
    np.testing.assert_allclose(areas[-1], basin, rtol=0.03)


def test_contacts_along_a_ridge_touch_as_much_as_boundary_elements_find():
    """Area within 5 %, of which the basins pressed alone lack 14 %."""
    ny, nx = 96, 120
    rough = surfaces.self_affine(
        (ny, nx), (96.0, 120.0), hurst=0.8, rms_slope=0.04, rolloff=16.0, cutoff=6.0, seed=2
    )
    ridge = 3.0 * np.cos(2 * np.pi * np.arange(ny) / ny)[:, None]
    hm = surfaces.HeightMap(rough.heights + ridge, (1.0, 1.0), periodic=True)
    fine, body = surfaces.resample(hm, np.asarray(hm.spacing) / 2), HalfSpace.from_modulus(1.0)
    pressure = 0.06 * pressure_scale(hm, body)
    exact = asperity.bem_solve(fine, body, pressure=pressure, tolerance=1e-4)
    bodies = Asperities.of(hm, body, make_plan(hm, body, pressures=[pressure]))
    joined = bodies.population.solve(mean_pressure=pressure)
    bodies.population.joined = None
    alone = bodies.population.solve(mean_pressure=pressure)
    np.testing.assert_array_equal(joined.force, alone.force)
    assert joined.contact_area == pytest.approx(exact.contact_area, rel=0.05)
    assert alone.contact_area < 0.88 * exact.contact_area


def test_contacts_apart_keep_their_areas():
    hm = egg_box()
    summits = locate_summits(hm, segment(hm))
    basins, rows = Basins(summits, HalfSpace.from_modulus(1.0)), np.arange(len(summits))
    area = np.full(len(rows), 2.0)
    assert basins.areas(rows, np.full(len(rows), 0.1), area, area) is area


def crowded(fall: float):
    """Areas of the contacts of an egg box, all of them joined, from those of their laws."""
    hm = egg_box()
    summits = locate_summits(hm, segment(hm))
    basins, rows = Basins(summits, HalfSpace.from_modulus(1.0)), np.arange(len(summits))
    deep, force = np.full(len(rows), 2.0), np.full(len(rows), 60.0)
    alone = fall * basins._carrying(rows, deep, force)[0]
    return basins, (rows, deep, force, alone)


def test_joining_adds_area():
    basins, state = crowded(0.5)
    np.testing.assert_allclose(basins.areas(*state), 2.0 * state[-1], rtol=1e-9)
    basins, state = crowded(2.0)
    assert basins.areas(*state) is state[-1]


def test_contacts_that_the_border_cuts_keep_their_law():
    basins, state = crowded(0.5)
    border = np.array([True, False, False, True])
    cut = Basins(replace(basins.summits, border=border), basins.material)
    ratio = np.where(border, 1.0, 2.0)
    np.testing.assert_allclose(cut.areas(*state), ratio * state[-1], rtol=1e-9)


@pytest.mark.parametrize("periodic", [True, False])
def test_pixels_and_outlines_are_counted_as_one_by_one(periodic):
    rng = np.random.default_rng(0)
    heights, labels = rng.normal(size=(9, 13)), rng.integers(-1, 4, (9, 13)).astype(np.int32)
    slot = np.array([2, -1, 0, 1, -1])
    own = slot[labels]
    mode = "wrap" if periodic else "edge"
    padded = np.pad(heights, 1, mode=mode)
    steps = [np.full(n, 2.0 * s) for n, s in zip(heights.shape, SPACING, strict=True)]
    if not periodic:
        for step in steps:
            step[[0, -1]] /= 2
    slope = np.hypot(
        (padded[2:, 1:-1] - padded[:-2, 1:-1]) / steps[0][:, None],
        (padded[1:-1, 2:] - padded[1:-1, :-2]) / steps[1],
    )
    top, depth = heights.max() + np.array([0.0, 0.2, 0.1]), np.array([2.0, 3.0, 4.0])
    count, total = np.zeros((2, 3, 5))
    read = heights, labels, slot, periodic, SPACING
    level = rng.normal(size=3)
    common, free = np.zeros((2, 3))
    for lines in ((0, 4), (4, 9)):
        kernels.tally(*read, *lines, top, depth, count, total)
        kernels.outlines(*read, *lines, level, np.empty((2, 13), np.int64), common, free)
    closed = heights > np.append(level, np.inf)[own]
    for k in range(3):
        place = ((top[k] - heights) / depth[k] * 5).astype(int)
        for b in range(5):
            here = (own == k) & (place == b)
            assert (count[k, b], total[k, b]) == pytest.approx((here.sum(), slope[here].sum()))
        touching = np.zeros(2)
        for axis, shift in ((0, 1), (0, -1), (1, 1), (1, -1)):
            beside, other = (np.roll(a, shift, axis) for a in (closed, own))
            inside = np.ones(heights.shape, bool)
            if not periodic:
                np.moveaxis(inside, axis, 0)[0 if shift > 0 else -1] = False
            mine = inside & closed & (own == k)
            length = SPACING[1 - axis]
            touching += (
                length * (mine & beside & (other != k)).sum(),
                length * (mine & ~beside).sum(),
            )
        assert (common[k], free[k]) == pytest.approx(tuple(touching))


def test_joined_summits_count_as_one_basin():
    hm = egg_box()
    summits = locate_summits(hm, segment(hm))
    one = summits.joined(np.array([[0, 1], [0, 2], [0, 3]]), np.zeros(3))
    area, _ = Basins(one, HalfSpace.from_modulus(1.0))._carrying(
        np.array([0]), np.array([0.5]), np.array([1e4])
    )
    whole, _ = Basins(summits, HalfSpace.from_modulus(1.0))._carrying(
        np.arange(4), np.full(4, 0.5), np.full(4, 1e4)
    )
    assert area[0] == pytest.approx(whole.sum(), rel=0.05)
