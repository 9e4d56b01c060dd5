"""Hills with several summits: contacts that join on them, against boundary elements."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
from asperity.halfspace.scene import pressure_scale
from asperity.interaction.elongation import Elongation
from asperity.microcontact.basin_bem import press
from asperity.model.corrections.joined_pairs import join
from asperity.model.decomposition import Decomposition
from asperity.model.law_rows import LoadShares
from asperity.parameters import DEFAULTS
from surfaces import HeightMap, segment, self_affine
from surfaces.peaks.summits import Summits, locate_summits

BODY = asperity.HalfSpace.from_modulus(1.0)


def hills(seed: int) -> HeightMap:
    """Few hills with smooth, shorter waves, on pixels that are not square."""

    def waves(**recipe: float) -> np.ndarray:
        return self_affine((96, 120), (96.0, 144.0), hurst=0.8, rms_slope=0.1, **recipe).heights

    long = waves(cutoff=36.0, seed=seed)
    short = waves(cutoff=10.0, rolloff=24.0, seed=seed + 1)
    return HeightMap(long + 0.25 * short, (1.0, 1.2), periodic=True)


@pytest.mark.parametrize(("seed", "bound"), [(1, 0.02), (6, 0.015), (8, 0.035)])
def test_contacts_of_one_hill_join_though_some_of_its_summits_lie_too_far(seed, bound):
    """Summits that join the group last, too far to be pressed with it, leave the others joined;
    with all of the group apart the loads differ by 6, 3 and 9 %."""
    hm = hills(seed)
    loads = np.array([1e-2, 3e-2, 6e-2]) * pressure_scale(hm, BODY)
    curve = asperity.contact_curve(hm, BODY, pressures=loads)
    exact = asperity.bem_curve(hm, BODY, pressures=loads)
    rate = exact.stiffness / exact.mean_pressure
    assert np.abs(rate * (curve.separation - exact.separation)).max() < bound


def located(hm: HeightMap) -> Summits:
    return locate_summits(hm, segment(hm))


def two_summits(finer: int = 1) -> HeightMap:
    """Two summits, 0.01 apart in height, with a pass 0.05 below them."""
    y, x = np.meshgrid(
        *((np.arange(finer * n) + 0.5) / (finer * n) - 0.5 for n in (64, 96)), indexing="ij"
    )
    gap = 0.05 * (16.0 * x**2 - 1.0) ** 2 + 4.0 * y**2 - 0.02 * x
    return HeightMap(-gap, (1 / (finer * 64), 1 / (finer * 96)), periodic=True)


def test_summits_that_join_are_pressed_as_one():
    fine, apart = two_summits(2), located(two_summits())
    pair = join(apart, LoadShares.of(apart), BODY, DEFAULTS)[0]
    np.testing.assert_array_equal(pair.owner, 0)
    assert pair.pixels[0] == 64 * 96 and np.isfinite(pair.floor[0]) and not pair.valid[1]
    high, low = apart.height
    depths = np.array([[0.03, 0.1, 0.2]])  # the first before they join
    one = press.press(pair, np.array([0]), depths, BODY)[0]
    first = press.press(apart, np.array([0]), depths, BODY)[0]
    second = press.press(apart, np.array([1]), depths - (high - low), BODY)[0]
    for d, found, alone in zip(depths[0], one, first + second, strict=True):
        level = high - d - fine.heights.mean()
        whole = asperity.bem_solve(fine, BODY, separation=level, boundary="free", tolerance=1e-4)
        assert found[0] == pytest.approx(whole.load, rel=0.01)
        assert found[1] == pytest.approx(whole.contact_area, rel=0.03)
        assert alone[0] > 1.05 * whole.load  # neither feels the other


def test_joined_summits_begin_as_the_highest_of_them():
    """However small its contact is beside the basin of them all."""
    apart = located(two_summits())
    depths = np.array([[1e-4, 1e-3, 5e-3]])
    pair = join(apart, LoadShares.of(apart), BODY, DEFAULTS)[0]
    one = press.press(pair, np.array([0]), depths, BODY)[0]
    first = press.press(apart, np.array([0]), depths, BODY)[0]
    np.testing.assert_allclose(one[:, :2], first[:, :2], rtol=0.02)


def test_joined_summits_have_the_form_of_their_contact():
    hm = two_summits()  # one beside the other along x, each longer along x than along y
    decomposition = Decomposition.of(hm, BODY, asperity.make_plan(hm, BODY))
    assert decomposition.summits.owner[1] == 0
    highest = Elongation.of(
        decomposition.summits.curvature,
        decomposition.summits.angle,
        decomposition.population.footprints,
        DEFAULTS.elongation,
    )
    across, along, skew = decomposition.population.elongation.moments[0]
    assert along > 1.5 * highest.moments[0, 1] and across < highest.moments[0, 0]
    assert abs(skew) < 0.02 * along
