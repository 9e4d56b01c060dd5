"""Loads on contacts under which few fine waves lie: more of these are contacts there."""

from __future__ import annotations

import pickle
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import FINE, STEEL, broad

import asperity
import surfaces
from asperity.curve import solve_contacts
from asperity.halfspace.load_points import pressure_scale
from asperity.model.plan import finer_plan, make_plan
from asperity.multiscale.surface_point import particular, spread_over
from surfaces import HeightMap


@pytest.fixture(scope="module")
def one_hill() -> HeightMap:
    return broad(rolloff=None, seed=12)


def test_where_few_fine_waves_lie_under_the_contacts_more_of_them_are_contacts(
    one_hill, monkeypatch
):
    """A mean tells little of the few waves that happen to be there."""
    loads = np.array([1.2e-3, 2e-3]) * pressure_scale(one_hill, STEEL)
    refined = surfaces.resample(one_hill, np.asarray(one_hill.spacing) / 2)
    exact = asperity.bem_curve(refined, STEEL, pressures=loads, tolerance=1e-4)
    slope = np.log(loads[1] / loads[0]) / (exact.separation[0] - exact.separation[1])

    def errors():
        curve = asperity.contact_curve(one_hill, STEEL, pressures=loads)
        return slope * (curve.separation - exact.separation), curve.error_estimate

    found, stated = errors()
    assert (np.abs(found) < np.minimum(stated, 0.03)).all()
    monkeypatch.setattr("asperity.model.decomposition.particular", lambda *_: 0.0)
    mean, wider = errors()
    assert np.linalg.norm(found) < 0.5 * np.linalg.norm(mean) and (wider > stated).all()


def test_their_table_has_the_area_of_the_curve(one_hill):
    """From one load to the next less and less of the finer contacts counts, at last nothing."""
    loads = np.array([4e-4, 4e-3, 1.2e-2, 6e-2]) * pressure_scale(one_hill, STEEL)
    run = solve_contacts(one_hill, STEEL, pressures=loads)
    looks = [run.bodies.closer_look(state) for state in run.states]
    parts = [look.part if look else 0.0 for look in looks]
    assert parts[0] == 1.0 > parts[1] > parts[2] > parts[3] == 0.0
    assert (np.diff(run.curve.separation) < 0).all() and (np.diff(run.curve.contact_area) > 0).all()
    for point, look in enumerate(looks):
        closed = run.microcontacts(point)["closed_area"]
        assert closed.sum() == pytest.approx(run.curve.contact_area[point], rel=1e-9)
        if look:
            assert look.state.mean_pressure == pytest.approx(loads[point], rel=1e-6)


def test_where_hardly_more_waves_can_be_kept_there_is_no_closer_look(one_hill):
    kept = make_plan(one_hill, STEEL).fine.shortest
    assert finer_plan(make_plan(one_hill, STEEL)).fine.shortest < 0.75 * kept
    assert finer_plan(make_plan(broad((120, 144), rolloff=None), STEEL)) is None
    assert finer_plan(make_plan(broad(), STEEL, scales="all")) is None


def test_where_many_waves_are_kept_a_closer_look_keeps_a_third_more():
    """On a map of many hills the fewest waves of a closer look would be hardly more."""
    hm = broad((720, 900), rolloff=9e-5)
    plan = make_plan(hm, STEEL)
    assert np.sqrt(hm.area) / plan.fine.shortest > 92
    finer = finer_plan(plan)
    assert 1.30 < plan.fine.shortest / finer.fine.shortest < 1.37
    assert finer.above is not None and finer_plan(finer) is None


def test_a_closer_look_takes_the_whole_map_where_contacts_come_near_its_cut(one_hill, monkeypatch):
    load = 1.2e-3 * pressure_scale(one_hill, STEEL)
    whole = asperity.contact_curve(one_hill, STEEL, pressures=load)
    for name, value in (("_QUICK", 0), ("_SPARE_SHARE", 0.02), ("_DEPTH", 0.0)):
        monkeypatch.setattr(f"asperity.model.plan.{name}", value)
    plan = make_plan(one_hill, STEEL)
    assert finer_plan(plan).above is not None
    run = solve_contacts(one_hill, STEEL, plan, pressures=load)
    assert run.bodies.closer_look(run.states[0]).bodies.plan.above is None
    assert run.curve.separation == pytest.approx(whole.separation, rel=1e-9)


def test_closer_looks_are_kept_with_a_run(one_hill):
    """Taken anew they would start from other contacts, and differ within the tolerance."""
    loads = np.array([4e-4, 1.2e-3]) * pressure_scale(one_hill, STEEL)
    run = solve_contacts(one_hill, STEEL, pressures=loads)
    kept = pickle.loads(pickle.dumps(run))
    for state, again in reversed(list(zip(run.states, kept.states, strict=True))):
        assert kept.bodies.point(again) == run.bodies.point(state)


@settings(deadline=None, derandomize=True, max_examples=20)
@given(st.lists(st.tuples(st.floats(1e-3, 1.0), st.floats(0.1, 0.9)), min_size=1, max_size=5))
def test_another_sum_of_closed_areas_is_spread_over_all(contacts):
    whole, share = np.array(contacts).T
    area = whole * share
    for total in (0.3 * area.sum(), area.sum(), 0.5 * (area.sum() + whole.sum())):
        found = spread_over(total, area, whole)
        assert found.sum() == pytest.approx(total)
        assert (found > 0).all() and (found < whole).all()
    for some in (area, whole):  # small contacts are closed as a whole
        np.testing.assert_allclose(spread_over(2 * whole.sum(), some, whole), 2 * whole)


def test_fine_waves_under_contacts_are_counted():
    """One contact, or many; a wide one has many waves; forces count, not their unit."""

    def part(force, area):
        state = SimpleNamespace(force=np.array(force), area=np.array(area) * FINE.shortest**2)
        return particular(FINE, state)

    assert part([0.0, 0.0], [0.0, 0.0]) == 0.0
    assert part([1.0], [0.5]) == part([1.0, 1.0, 0.0], [0.5, 0.5, 0.0]) == 1.0
    assert part([1.0], [500.0]) == part(np.ones(300), 0.1 * np.ones(300)) == 0.0
    assert 0.0 < part([1.0], [60.0]) == part([7.0], [60.0]) < part([1.0, 0.1], [40.0, 20.0]) < 1.0
