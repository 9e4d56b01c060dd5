"""The stated error grows with each limit of the model, and true errors of other maps lie inside."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import asperity
from asperity.errors import Flag
from asperity.halfspace.scene import default_pressures
from asperity.parameters import DEFAULTS
from asperity.trust.error_estimate import (
    EXPECTED_ERROR,
    OUTSIDE_MODEL,
    TERMS,
    estimate,
    nonrandomness,
    terms,
)
from surfaces import HeightMap, resample, self_affine

STEEL = asperity.HalfSpace(210e9, 0.3)

FITTED = DEFAULTS.error_estimate


def rough(seed: int) -> HeightMap:
    return self_affine(
        (144, 192),
        (1.44e-3, 1.92e-3),
        hurst=0.8,
        rms_slope=0.1,
        rolloff=4e-4,
        cutoff=8e-5,
        seed=seed,
    )


def test_a_surface_on_a_coarser_grid_is_trusted_less():
    stated = []
    for pixel in (5e-6, 1e-5, 2e-5):
        curve = asperity.contact_curve(resample(rough(4), pixel), STEEL, pressures=[1e7, 1e8])
        stated.append((curve.error_estimate, curve.extra["area_error_estimate"]))
    assert (np.diff(stated, axis=0) > 0).all()


def test_without_contact_there_is_nothing_to_be_wrong():
    hm = rough(4)
    above = hm.heights.max() - hm.heights.mean() + np.array([0.1, 0.0]) * hm.rms_height
    curve = asperity.contact_curve(hm, STEEL, separations=[above[0], 0.5 * above[1]])
    for stated in (curve.error_estimate, curve.extra["area_error_estimate"]):
        assert stated[0] == 0.0 < stated[1] < 0.3


def test_true_errors_lie_inside_the_statement_on_surfaces_it_was_not_fitted_on():
    inside, stated, closed, wide = [], [], [], []
    for seed in (101, 102, 103):
        hm = rough(seed)
        loads = default_pressures(hm, STEEL, count=4)
        reference = asperity.bem_curve(hm, STEEL, pressures=loads)
        model = asperity.contact_curve(hm, STEEL, separations=reference.separation)
        error = np.abs(model.mean_pressure / reference.mean_pressure - 1)
        inside += (error <= model.error_estimate).tolist()
        stated += model.error_estimate.tolist()
        loaded = asperity.contact_curve(hm, STEEL, pressures=reference.mean_pressure)
        error = np.abs(loaded.contact_area / reference.contact_area - 1)
        closed += (error <= loaded.extra["area_error_estimate"]).tolist()
        wide += loaded.extra["area_error_estimate"].tolist()
    assert np.mean(inside) >= 0.8
    assert max(stated) < 0.15
    assert np.mean(closed) >= 0.8
    assert max(wide) < 0.25


LINES = np.array([[0.0, 1.0, 3.0, 1.0], [2.0, 0.0, 1.0, -1.0], [1.0, 4.0, 1.0, 5.0]])


def weak_point(unit=1.0, force=1.0):
    """Two contacts, a third that is open: a load point whose terms are known in closed form."""
    table = SimpleNamespace(
        flags_at=lambda rows, depth: np.array([Flag.BEYOND_RADIUS, Flag.FILLED, 0])[rows],
        spread_at=lambda rows, depth: np.array([-0.1, 0.3, 9.0])[rows],
    )
    hm = HeightMap(unit * LINES, (2.0 * unit, 1.0 * unit), periodic=True)
    decomposition = SimpleNamespace(
        hm=hm,
        solved=hm,
        plan=SimpleNamespace(sub_contact_law=None, boundary="periodic", parameters=DEFAULTS),
        population=SimpleNamespace(table=table),
        summits=SimpleNamespace(
            curvature=np.array([[2.0, 1.0], [3.0, 3.0], [9.0, 1.0]]) / unit,
            height=unit * np.array([1.06, 1.01, 1.0]),
            peaks=SimpleNamespace(height=unit * np.ones(3)),
        ),
        top_areas=np.zeros(3),
    )
    state = SimpleNamespace(
        force=force * np.array([3.0, 1.0, 0.0]),
        approach=unit * np.array([0.2, 0.1, 0.0]),
        area=unit**2 * np.array([4.0, 2.0, 0.0]),
        contact_area=6.0 * unit**2,
        filled_share=0.25,
    )
    return decomposition, SimpleNamespace(state=state, overlap=0.2), 0.5


def test_terms_of_two_contacts():
    found = terms(*weak_point())
    share, area = np.array([0.75, 0.25]), 24.0
    assert list(found) == [*TERMS, *OUTSIDE_MODEL]
    few, spread = np.hypot(*share), share @ [0.1, 0.3]
    coarse = np.sqrt(2.0 / (share @ [4.0, 2.0]))
    long, crowding = 0.75 * np.log(2.0), 6.0 / area
    expected = {
        "coarse_contacts": coarse,
        "scatter": 0.75,
        "odd_spread": 0.5 * spread,
        "few_taken_out": 0.0,
        "coarse_taken_out": 0.0,
        "few_elongated": long * few,
        "crowding": crowding,
        "long_crowding": long * crowding,
        "few_crowded": few * np.sqrt(crowding),
        "flat_tops": 0.0,
        "at_border": 0.0,
        "unsure": 0.0,
        "unresolved": share @ [1 / 2, 1] - 1 / FITTED.resolved_pixels,
        "overlap": 0.2,
        "overshoot": share @ [0.3, 0.1] - FITTED.usual_overshoot,
    }
    assert found == pytest.approx(expected)


def test_terms_have_no_units():
    assert terms(*weak_point(1e-6, 1e3)) == pytest.approx(terms(*weak_point()))


def test_with_fine_waves_taken_out_the_terms_are_those_of_the_map_that_was_solved():
    decomposition, point, odd = weak_point()
    decomposition.plan.sub_contact_law = SimpleNamespace(ratio=3.0)
    decomposition.hm = HeightMap(np.eye(6, 8), (1.0, 0.5), periodic=True)
    found, whole = terms(decomposition, point, odd), terms(*weak_point())
    few, coarse = np.hypot(0.75, 0.25), whole["coarse_contacts"]
    expected = {**whole, "few_taken_out": 0.75 * few, "coarse_taken_out": 0.75 * coarse}
    expected["unresolved"] = 0.0  # pixels of the finer map
    assert found == pytest.approx(expected)


def test_the_border_of_a_punch_cuts_a_contact_by_the_part_of_its_radius():
    decomposition, state, odd = weak_point()
    decomposition.plan.boundary = "free"
    decomposition.places = np.array([3.0, 1.5, 3.0]), np.array([2.0, 2.0, 2.0])
    outside = 1.0 - 0.5 / np.sqrt(2.0 / np.pi)  # the outermost points are half a pixel inside
    found = terms(decomposition, state, odd)["at_border"]
    assert found == pytest.approx((0.25 * outside) ** 2)


@pytest.mark.parametrize(("wide", "left"), [(0.9, 1.0 - FITTED.pressed), (1.1, 1.0)])
def test_a_flat_top_that_is_pressed_alone_counts_less_unless_it_is_wide(wide, left):
    decomposition, state, odd = weak_point()
    top = wide * FITTED.wide_top * decomposition.hm.area
    decomposition.top_areas = np.array([top, 0.0, 0.0])
    decomposition.population.table.spread_at = lambda rows, depth: np.full(2, EXPECTED_ERROR)
    decomposition.summits.dip = np.ones(3)
    decomposition.summits.peaks.min_prominence = 0.5
    found = terms(decomposition, state, odd)["flat_tops"]
    assert found == pytest.approx(0.75 * min(top / 4.0, 1.0) * left)


def test_the_plastic_part_of_the_area_is_known():
    """The estimate falls to a least share of it; contacts outside the model keep their terms."""
    values = {name: np.ones(3) for name in TERMS}
    slope, least = FITTED.yielded
    share = np.array([0.0, 1.0 - 0.5 / slope, 1.0])
    found = estimate(values, FITTED.area_weights, FITTED, share)
    np.testing.assert_allclose(found, sum(FITTED.area_weights) * np.array([1.0, 0.5, least]))
    outside = {**values, "flat_tops": np.ones(3)}
    more = estimate(outside, FITTED.area_weights, FITTED, share) - found
    np.testing.assert_allclose(more, FITTED.flat_tops)


def test_random_waves_are_not_odd_and_spikes_are():
    hm = self_affine(
        (128, 160), (1.28e-3, 1.6e-3), hurst=0.8, rms_slope=0.1, rolloff=2e-4, cutoff=4e-5, seed=1
    )
    spikes = np.zeros(hm.shape)
    spikes[30, 40] = 20 * hm.rms_height
    assert nonrandomness(hm) < 0.1
    assert nonrandomness(hm.replace(heights=hm.heights + spikes)) == 1.0
    assert 0.0 <= nonrandomness(hm.replace(heights=np.minimum(hm.heights, hm.rms_height))) <= 1.0
