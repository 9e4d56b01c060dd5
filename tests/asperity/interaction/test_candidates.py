"""Lists that move along with the contacts, and when they are made anew."""

from __future__ import annotations

import weakref
from dataclasses import replace

import numpy as np
import pytest

import asperity
import surfaces
from asperity.contacts.run import solve_contacts
from asperity.halfspace.scene import pressure_scale
from asperity.interaction import candidates as module
from asperity.interaction import population as population_module
from asperity.interaction.candidates import PAIR_LIST_SKIN
from asperity.interaction.ewald import near_pairs
from asperity.model.decomposition import Decomposition

BODY = asperity.HalfSpace.from_modulus(1.0)


@pytest.fixture(scope="module")
def light():
    """Population of a rough map, its list at a light load, not yet moved, and the places of its
    contacts; near pairs no more than of many contacts."""
    size = (96.0, 96.0)
    hm = surfaces.self_affine((96, 96), size, hurst=0.8, rms_slope=0.1, cutoff=3.0, seed=2)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(near_pairs, "CHEAP_PAIRS", 0)
        run = solve_contacts(hm, BODY, pressures=3e-3 * pressure_scale(hm, BODY))
    population = run.decomposition.population
    last = run.points[0].state.continuation
    listing = last.candidates
    still = replace(listing, paired=listing.offset, moved=np.zeros_like(listing.moved))
    return population, still, last.points[-1].values


@pytest.fixture
def narrow(monkeypatch):
    """The near pairs of a list serve contacts of all sizes."""
    monkeypatch.setattr(module, "WIDEST_SHARE", 0.0)
    monkeypatch.setattr(module, "WIDEST_NUMBER", 0.0)


def placed(population, listing, values):
    """Places of the contacts about their summits, shape (2, n)."""
    touches = values.interference > 0
    places = population.table.centre_at(listing.index[touches], values.interference[touches])
    return places, touches


def test_points_stand_at_the_centres_or_as_near_as_the_pairs_that_were_listed_allow(
    light, narrow, monkeypatch
):
    population, listing, values = light
    values = values._replace(interference=3.0 * values.interference)
    centre, touches = placed(population, listing, values)
    rows, skin = listing.index[touches], PAIR_LIST_SKIN * listing.problem.coupling.eta
    found = listing.recentred(listing.index, values, 1e-3)
    for new, place in zip(centre, found.offset, strict=True):
        np.testing.assert_allclose(place[rows], new, rtol=1e-12)
    assert found.paired is listing.paired
    lightest = rows[np.argmin(values.interference[touches])]
    elsewhere = listing.paired.copy()
    elsewhere[:, lightest] = found.offset[:, lightest] + 2.0 * skin
    leaping = replace(listing, paired=elsewhere)
    assert leaping.recentred(listing.index, values, 1e-3) is None  # among few it counts
    monkeypatch.setattr(module, "MANY_CONTACTS", 1)
    found = leaping.recentred(listing.index, values, 1e-3)
    np.testing.assert_allclose(found.offset[:, lightest], elsewhere[:, lightest] - skin)
    elsewhere = listing.paired + 2.0 * skin
    lost = replace(listing, paired=elsewhere).recentred(listing.index, values, 1e-3)
    assert lost is None


def test_points_that_are_moved_back_go_half_of_the_way(light, narrow):
    population, listing, values = light
    values = values._replace(interference=3.0 * values.interference)
    _, touches = placed(population, listing, values)
    rows = listing.index[touches]
    way = listing.recentred(listing.index, values, 1e-3).moved[:, rows]
    assert (np.abs(way).max(axis=0) > 0).any()
    for sign, share in ((1.0, 1.0), (-1.0, 0.5)):
        before = np.zeros_like(listing.moved)
        before[:, rows] = sign * way
        found = replace(listing, moved=before).recentred(listing.index, values, 1e-3)
        np.testing.assert_allclose(found.offset[:, rows] - listing.offset[:, rows], share * way)
        np.testing.assert_array_equal(found.moved[:, rows], share * way)


def test_more_contacts_may_stand_a_little_astray_under_a_wider_tolerance(
    light, narrow, monkeypatch
):
    _, listing, values = light
    values = values._replace(interference=2.0 * values.interference)
    assert listing.recentred(listing.index, values, 1.0) is not listing
    monkeypatch.setattr(module, "LARGEST_DISTANCE", 1.0)
    monkeypatch.setattr(module, "MANY_CONTACTS", 1)
    assert listing.recentred(listing.index, values, 1e-3) is not listing
    assert listing.recentred(listing.index, values, 1.0) is listing


def test_a_plan_holds_until_footprints_outgrow_it(light):
    plan = light[1].problem.coupling
    assert plan.holds((0.99 * plan.eta / 3) ** 2) and not plan.holds((1.01 * plan.eta / 3) ** 2)


def test_summits_of_a_free_body_sink_with_it():
    """Between two loads the whole body sinks by many times its roughness: what is listed is what
    may touch, not all summits over the last field; all that overlap are listed."""
    hm = surfaces.self_affine(
        (512, 640), (512.0, 640.0), hurst=0.8, rms_slope=0.1, rolloff=20.0, cutoff=5.0, seed=3
    )
    loads = pressure_scale(hm, BODY) * np.geomspace(1e-3, 4e-2, 8)
    plan = asperity.make_plan(hm, BODY, pressures=loads, boundary="free", scales="all")
    states = [point.state for point in solve_contacts(hm, BODY, plan, pressures=loads).points]
    assert states[-2].separation - states[-1].separation > 3.0 * hm.rms_height
    for state in states:
        assert state.active < len(state.rows) < 1.9 * state.active
        last = state.continuation
        found = last.field, state.separation, 1.0
        assert not last.candidates.lacks(*found, 0.01 * state.active)


def test_a_list_that_does_not_last_goes_before_the_next_is_made(monkeypatch):
    """What is handed on to the next load leads to the same point, and holds no list made before."""
    make, plans, found = module.CandidateList.of.__func__, [], []

    def listed(cls, *args, **settings):
        made = make(cls, *args, **settings)
        plans.append(weakref.ref(made.problem.coupling))
        return made

    monkeypatch.setattr(module.CandidateList, "of", classmethod(listed))
    monkeypatch.setattr(population_module, "LARGE_LIST", 0)
    size = (256.0, 320.0)
    hm = surfaces.self_affine(
        (256, 320), size, hurst=0.8, rms_slope=0.1, rolloff=20.0, cutoff=5.0, seed=3
    )
    scale = pressure_scale(hm, BODY)
    plan = asperity.make_plan(hm, BODY, pressures=0.03 * scale, scales="all")
    population = Decomposition.of(hm, BODY, plan).population
    for handing_on in (False, True):
        state, curve = None, []
        for share, lasts in ((3e-3, False), (3.001e-3, True), (3e-2, False)):
            if handing_on and state is not None:
                state = population_module.handed_on(state, pressure=share * scale)
                assert (state.continuation.candidates is not None) == lasts
                assert lasts or not any(made() for made in plans)
            state = population.solve(pressure=share * scale, state=state)
            curve.append((state.separation, state.contact_area, state.active))
        found.append(curve)
        plans.clear()
    np.testing.assert_array_equal(*found)
    failed = replace(state, converged=False)
    assert population_module.handed_on(failed, pressure=3e-2 * scale) is failed
