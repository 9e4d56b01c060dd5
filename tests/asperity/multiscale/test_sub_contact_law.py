"""The law of fine waves within one contact."""

from __future__ import annotations

import dataclasses
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import erf, exp1
from strategies import FINE


@pytest.mark.parametrize("pressure", [2e7, 3e8, 2e9, 3e10])
@pytest.mark.parametrize("share", [0.0, 0.4])
def test_closed_forms_are_means_over_rayleighs_distribution(pressure, share):
    scale = np.sqrt(2 / np.pi) * pressure
    spread = (FINE.spread + (1 - FINE.spread) * share**2) * FINE.variance

    def mean(law):
        def weighed(t):
            return t * np.exp(-0.5 * t * t) * law(t * scale / np.sqrt(2 * spread))

        return quad(weighed, 0, 1, epsrel=1e-9)[0] + quad(weighed, 1, 12, epsrel=1e-9)[0]

    def energy(x):
        return erf(x) + (x * exp1(x * x) / np.sqrt(np.pi) if 0 < x < 20 else 0.0)

    assert FINE.remaining(pressure, share) == pytest.approx(mean(erf), rel=1e-6)
    assert FINE.stored(pressure, share) == pytest.approx(FINE.energy * mean(energy), rel=1e-6)


def test_pressed_hard_all_is_closed_and_all_energy_stored():
    assert FINE.remaining(1e14, 0.1) == pytest.approx(1.0, abs=1e-8)
    assert FINE.stored(1e14, 0.1) == pytest.approx(FINE.energy, rel=1e-6)
    assert FINE.lift(3e-9, 1.0) == 3e-9


@settings(deadline=None, derandomize=True, max_examples=20)
@given(st.floats(1e6, 1e11), st.floats(0.0, 0.9), st.floats(1e-18, 1e-6))
def test_a_contact_smaller_than_the_fine_waves_stays_whole(pressure, share, area):
    areas = np.array([1e-22, area, 2.0 * area, np.inf])
    kept = FINE.remaining(pressure, share, areas)
    assert np.all(np.diff(kept) <= 0)
    assert kept[0] == pytest.approx(1.0, abs=1e-2)
    assert kept[-1] == FINE.remaining(pressure, share)
    # half the pressure of the fine waves where a wave number times the radius is 1
    halved = dataclasses.replace(FINE, variance=0.5 * FINE.variance)
    there = FINE.remaining(pressure, share, np.pi / FINE.number**2)
    assert there == pytest.approx(halved.remaining(pressure, share))


@settings(deadline=None, derandomize=True, max_examples=20)
@given(st.floats(1e6, 1e11), st.floats(0.0, 0.9))
def test_more_pressure_closes_more_and_stores_more(pressure, share):
    pair = np.array([pressure, 1.1 * pressure])
    closed, stored = FINE.remaining(pair, share), FINE.stored(pair, share)
    assert 0 < closed[0] < closed[1] <= 1
    assert 0 < stored[0] < stored[1] <= FINE.energy
    assert FINE.remaining(pressure, share) >= FINE.remaining(pressure, min(share + 0.1, 1.0))


@settings(deadline=None, derandomize=True, max_examples=20)
@given(st.floats(-0.5, 0.5), st.floats(0.1, 50.0))
def test_part_of_the_pressure_spreads(m, ratio):
    law = dataclasses.replace(FINE, m=m, ratio=ratio, rms=(0.9e-8, 1e-8))
    assert 0 < law.spread < 1
    assert law.lift(1e-9, 0.01) > law.lift(1e-9, 0.2) > 0.95e-9
    assert law.spread <= dataclasses.replace(law, m=m - 0.01).spread


def test_vanishing_fine_waves_leave_the_contacts_as_they_are():
    law = dataclasses.replace(FINE, variance=1e-12 * FINE.variance, energy=1e-6 * FINE.energy)
    assert law.remaining(3e8, 0.1) == pytest.approx(1.0, abs=1e-9)
    assert law.stored(3e8, 0.1) == pytest.approx(law.energy, rel=1e-6)


@pytest.mark.parametrize("hardness", [np.inf, 1e3])
def test_light_contacts_touch_in_proportion_to_their_pressure(hardness):
    """Shares below 1e-5 were lost in the rounding of a difference from one."""
    pressure = np.geomspace(1e-20, 1e2, 12)
    kept = FINE.remaining(pressure, 0.0, hardness=hardness)
    np.testing.assert_allclose(kept / pressure, kept[-1] / pressure[-1], rtol=1e-6)


def test_the_lift_grows_steadily_to_the_lightest_load():
    law = dataclasses.replace(FINE, rms=(0.9e-8, 1e-8))
    shares = np.array([1e-40, 1e-25, 1e-17, 1e-15])
    for lift in (partial(law.lift, 1e-9), law.bearing_lift):
        found = np.array([lift(share) for share in shares])
        assert 0.0 < found[-1] < found[0] < 2.0 * found[-1]
        assert (np.diff(found) < 0.0).all()


def test_contacts_that_overlap_beyond_the_map_leave_a_lift():
    """A search for a separation may pass through such states, which are refused."""
    law = dataclasses.replace(FINE, rms=(1e-8, 2e-8))
    assert law.bearing_lift(1.2) == law.bearing_lift(1.0) < law.bearing_lift(0.5) == 0.0
