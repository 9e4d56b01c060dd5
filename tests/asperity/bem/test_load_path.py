"""Curves in chains of loads, side by side."""

from __future__ import annotations

import time

import numpy as np
import pytest
from strategies import rough

from asperity import HalfSpace, bem_curve
from asperity.bem import curve, load_path
from asperity.bem.correction import NestedGrid, PressureOrigin
from asperity.bem.problem import ContactProblem
from asperity.limits import set_threads

BODY = HalfSpace.from_modulus(1.0)


@pytest.mark.parametrize("n", [1, 7, 8, 24])
def test_chains_hold_every_load_once(n):
    """In ascending order; one chain if there are few loads or the grid is small."""
    shares = np.geomspace(0.02, 1.0, n)
    found = load_path.split_loads(shares, 10**6)
    assert [i for chain in found for i in chain] == list(range(n))
    assert len(found) == (2 if n >= 8 else 1)
    assert load_path.split_loads(shares, 100) == [range(n)]
    if len(found) == 2:
        cost = [sum(1 + 5 * shares[i] for i in chain) for chain in found]
        assert cost[0] == pytest.approx(cost[1] + 2.0, abs=6.0)


def test_result_does_not_depend_on_the_number_of_threads(monkeypatch):
    """One thread follows the chains in turn, two side by side: the same curve up to rounding."""
    monkeypatch.setattr(curve, "split_loads", lambda shares, points: [range(2), range(2, 4)])
    hm = rough((48, 60), seed=6)
    found = []
    for count in (1, 2):
        set_threads(count)
        try:
            found.append(bem_curve(hm, BODY, pressures=[0.1, 0.01, 0.03, 0.2], tolerance=1e-9))
        finally:
            set_threads(None)
    assert all(one.converged.all() for one in found)
    one, two = found
    np.testing.assert_allclose(one.separation, two.separation, rtol=1e-10)
    np.testing.assert_array_equal(one.area_fraction, two.area_fraction)


def test_a_failing_callback_ends_the_curve(monkeypatch):
    """The exception comes through, and the other chain neither goes on nor calls again: it did,
    once, even after the curve had been left."""
    monkeypatch.setattr(curve, "split_loads", lambda shares, points: [range(2), range(2, 4)])
    seen = []

    def progress(point):
        seen.append(point)
        time.sleep(0.2)  # the other chain waits for its turn
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        bem_curve(rough((30, 40)), BODY, pressures=[0.1, 0.2, 0.3, 0.4], progress=progress)
    time.sleep(0.3)
    assert len(seen) == 1


@pytest.mark.parametrize(("ratio", "cold"), [(1.1, (1, 2)), (3.2, (4, 5, 6))])
def test_a_load_starts_from_the_last_where_its_prediction_is_good(monkeypatch, ratio, cold):
    """All six loads, or nearly so, start from coarser grids where they are far apart."""
    starts = []
    start = load_path.ContactProblem.start
    monkeypatch.setattr(
        load_path.ContactProblem, "start", lambda *given: starts.append(given) or start(*given)
    )
    hm, loads = rough((128, 128), seed=6), 0.2 * ratio ** np.arange(-5.0, 1.0)
    found = bem_curve(hm, BODY, pressures=loads, tolerance=1e-7)
    assert found.converged.all() and len(starts) in cold
    alone = bem_curve(hm, BODY, pressures=loads[-1:], tolerance=1e-7)
    assert found.separation[-1] == pytest.approx(alone.separation[0], rel=1e-6)
    assert found.contact_area[-1] == pytest.approx(alone.contact_area[0], rel=1e-6)


def test_a_load_is_solved_further_from_where_it_stands():
    """Its displacement is known: one transform less than from its pressure alone, same answer."""
    found = []
    for origin in (PressureOrigin.GIVEN, PressureOrigin.SOLVED):
        problem = ContactProblem(rough((96, 128)), HalfSpace.from_modulus(1.0), tolerance=1e-2)
        goal = problem.prescribed("pressure", 2e-3)
        problem.start(goal)
        problem.finest.solve(goal, 1e-2, PressureOrigin.PROLONGED)
        pairs = problem.finest.exact.pairs
        solution = problem.finest.solve(goal, 1e-5, origin)
        found.append((problem.finest.exact.pairs - pairs, solution.reading.level))
    (given, level), (solved, same) = found
    assert given - solved == 1
    assert same == level


def test_a_load_begins_with_the_tolerance_that_the_one_before_or_the_coarser_grid_needs(
    monkeypatch,
):
    """Few loads are solved twice, the first one neither."""
    begun, solve = [], NestedGrid.solve

    def noted(level, goal, tolerance, origin=PressureOrigin.GIVEN):
        if origin is not PressureOrigin.GIVEN:
            begun.append((origin, tolerance))
        return solve(level, goal, tolerance, origin)

    monkeypatch.setattr(NestedGrid, "solve", noted)
    loads = np.geomspace(0.02, 0.2, 7)
    found = bem_curve(rough((128, 160)), BODY, pressures=loads, accuracy=0.02)
    assert (found.extra["area_error_estimate"] <= 0.02).all()
    (first, tolerance), (second, _), *rest = begun
    assert first is PressureOrigin.PROLONGED
    assert tolerance < 5e-3
    assert second is PressureOrigin.PREDICTED
    assert sum(origin is PressureOrigin.SOLVED for origin, _ in rest) <= 2
