"""Lists that move along with the contacts, and when they are made anew."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
import surfaces
from asperity.curve import solve_contacts
from asperity.loadpoints import pressure_scale
from asperity.population.listing import SKIN

BODY = asperity.HalfSpace.from_modulus(1.0)


@pytest.fixture(scope="module")
def light():
    """Population of a rough map, its list at a light load, and the places of its contacts."""
    size = (96.0, 96.0)
    hm = surfaces.self_affine((96, 96), size, hurst=0.8, rms_slope=0.1, cutoff=3.0, seed=2)
    run = solve_contacts(hm, BODY, pressures=3e-3 * pressure_scale(hm, BODY))
    population = run.bodies.population
    trail = run.states[0]._trail
    return population, trail.listing, trail.points[-1].values


def placed(population, listing, values):
    """Places of the contacts about their summits, shape (2, n)."""
    touches = values[0] > 0
    return population.table.centre_at(listing.index[touches], values[0, touches]), touches


def test_points_stand_at_the_centres_until_these_are_far_from_where_pairs_were_listed(light):
    population, listing, values = light
    eta, far = listing.problem.plan.eta, []
    for share in np.geomspace(1.0, 30.0, 12):
        deeper = values.copy()
        deeper[0] *= share
        centre, touches = placed(population, listing, deeper)
        old = [place[listing.index[touches]] for place in listing.listed]
        far.append(max(np.abs(new - was).max() for new, was in zip(centre, old, strict=True)))
        found = listing.about(population, listing.index, deeper)
        if far[-1] > SKIN * eta:
            assert found is None
        elif found is not None and found is not listing:
            for new, place in zip(centre, found.offset, strict=True):
                np.testing.assert_array_equal(place[listing.index[touches]], new)
            assert found.listed is listing.listed
    assert far[0] < SKIN * eta < far[-1]


def test_a_plan_holds_until_footprints_outgrow_it(light):
    plan = light[1].problem.plan
    assert plan.holds((0.99 * plan.eta / 3) ** 2) and not plan.holds((1.01 * plan.eta / 3) ** 2)
