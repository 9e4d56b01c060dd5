"""The stated error grows with each limit of the model, and true errors of other maps lie inside."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import asperity
from asperity.halfspace.flags import Flag
from asperity.halfspace.load_points import default_pressures
from asperity.parameters import DEFAULTS
from asperity.trust.error_estimate import TERMS, nonrandomness, terms
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
    decomposition = SimpleNamespace(
        hm=HeightMap(unit * LINES, (2.0 * unit, 1.0 * unit), periodic=True),
        plan=SimpleNamespace(resampled=None, sub_contact_law=None, parameters=DEFAULTS),
        population=SimpleNamespace(table=table),
        material=SimpleNamespace(m=-0.3),
        summits=SimpleNamespace(curvature=np.array([[2.0, 1.0], [3.0, 3.0], [9.0, 1.0]]) / unit),
    )
    state = SimpleNamespace(
        force=force * np.array([3.0, 1.0, 0.0]),
        approach=unit * np.array([0.2, 0.1, 0.0]),
        area=unit**2 * np.array([4.0, 2.0, 0.0]),
        contact_area=6.0 * unit**2,
        filled_share=0.25,
    )
    return decomposition, state, 0.5


def test_terms_of_two_contacts():
    found = terms(*weak_point())
    share, area = np.array([0.75, 0.25]), 24.0
    assert set(found) == set(TERMS)
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
    }
    assert found == pytest.approx(expected)


def test_terms_have_no_units():
    assert terms(*weak_point(1e-6, 1e3)) == pytest.approx(terms(*weak_point()))


def test_with_fine_waves_taken_out_the_terms_are_those_of_the_map_that_was_solved():
    decomposition, state, odd = weak_point()
    decomposition.plan.sub_contact_law, decomposition.plan.resampled = (
        SimpleNamespace(ratio=3.0),
        decomposition.hm,
    )
    decomposition.hm = HeightMap(np.eye(6, 8), (1.0, 0.5), periodic=True)
    found, whole = terms(decomposition, state, odd), terms(*weak_point())
    few, coarse = np.hypot(0.75, 0.25), whole["coarse_contacts"]
    expected = {**whole, "few_taken_out": 0.75 * few, "coarse_taken_out": 0.75 * coarse}
    assert found == pytest.approx(expected)


def test_random_waves_are_not_odd_and_spikes_are():
    hm = self_affine(
        (128, 160), (1.28e-3, 1.6e-3), hurst=0.8, rms_slope=0.1, rolloff=2e-4, cutoff=4e-5, seed=1
    )
    spikes = np.zeros(hm.shape)
    spikes[30, 40] = 20 * hm.rms_height
    assert nonrandomness(hm) < 0.1
    assert nonrandomness(hm.replace(heights=hm.heights + spikes)) == 1.0
    assert 0.0 <= nonrandomness(hm.replace(heights=np.minimum(hm.heights, hm.rms_height))) <= 1.0
