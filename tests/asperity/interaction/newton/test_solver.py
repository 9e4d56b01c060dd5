"""The coupled solve: gradient, descent, complementarity, two spheres."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import HertzTable
from strategies import random_population

from asperity.halfspace.footprint import Footprints
from asperity.interaction.ewald.operator import Interaction
from asperity.interaction.ewald.tangent import Tangent
from asperity.interaction.newton import solver
from asperity.interaction.newton.laws import Laws
from asperity.interaction.newton.solver import descent
from asperity.interaction.newton.state import CandidateValues, Problem, State
from asperity.interaction.newton.step import conjugate_gradients
from asperity.parameters import DEFAULTS

CELL = (1.0, 1.4)


def make(n, *, m=0.0, boundary="periodic", seed=0, filling=0.3, apart=False):
    y, x, height, table = random_population(n, CELL, seed, m=m, filling=filling, apart=apart)
    f = Footprints(1.0, m)
    widest = f.variance(table.stiffness[:, -1]).max()
    plan = Interaction(y, x, CELL, boundary, f, widest=widest)
    return Problem(
        height[plan.order], Laws(table, f).rows(plan.order), plan, DEFAULTS.contact_shift
    )


def reach(laws):
    """Approach [m] of the last node of each contact."""
    return laws.store.reach[laws.index]


def energy(state, gap):
    """E = sum F (d + v0/2 - gap) - U, with held contact shifts."""
    law = state.laws
    return (law.force * (state.approach + 0.5 * state.field.value - gap) - law.energy).sum()


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_residual_is_the_gradient_of_the_energy(m, boundary):
    problem = make(40, m=m, boundary=boundary)
    rng = np.random.default_rng(2)
    d = reach(problem.laws) * rng.uniform(0.1, 2.0, 40)
    gap, still = problem.height + 0.1, np.zeros((40, 2))
    state = State(problem, d, still)
    gradient = d + state.field.value + state.laws.growth * state.field.slope - gap
    h = 1e-6 * d
    way = rng.normal(size=40) * h
    up, down = State(problem, d + way, still), State(problem, d - way, still)
    fall = energy(up, gap) - energy(down, gap)
    down.balance(-0.1, balanced=False)
    assert down.energy_change(up)[0] == pytest.approx(fall, rel=1e-6)
    assert fall == pytest.approx(gradient @ (up.laws.force - down.laws.force), rel=1e-5)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_solution_obeys_the_contact_conditions(m, boundary):
    """d = z - s - u where closed, no overlap where open, to the tolerance asked."""
    problem = make(300, m=m, boundary=boundary)
    s = -0.01
    solution = descent(problem, s, CandidateValues.of(np.zeros(300)), tolerance=1e-7)
    assert not solution.reason
    closed = solution.approach > 0
    assert 20 < closed.sum() < 290
    error = np.abs(solution.approach - solution.interference)[closed]
    assert error.max() < 1e-4 * solution.approach.max()
    assert solution.interference[~closed].max() <= 1e-4 * solution.approach.max()


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_solution_does_not_depend_on_the_start(boundary):
    problem = make(225, boundary=boundary, filling=0.2, apart=True)
    loads = []
    for share in (0.0, 1.0, 30.0):
        start = CandidateValues.of(share * reach(problem.laws))
        solution = descent(problem, -0.03, start, tolerance=1e-7)
        assert not solution.reason
        loads.append(solution.laws.force)
    for other in loads[1:]:
        np.testing.assert_allclose(other, loads[0], atol=1e-5 * loads[0].max())


def test_energy_falls_at_every_step(monkeypatch):
    problem = make(300, filling=0.2)
    s = -0.08
    energies = []

    class Recorded(State):
        def __init__(self, problem, approach, tilt):
            super().__init__(problem, approach, tilt)
            energies.append(energy(self, problem.height - s))

    monkeypatch.setattr(solver, "State", Recorded)
    solution = descent(problem, s, CandidateValues.of(3 * reach(problem.laws)), tolerance=1e-6)
    assert not solution.reason
    # trial points that were refused may lie above; the running minimum is what was accepted
    lowest = np.minimum.accumulate(energies)
    assert lowest[-1] < energies[0]
    assert energies[-1] == pytest.approx(lowest[-1], rel=1e-9)


@pytest.mark.parametrize("distance", [3.0, 5.0, 9.0])
def test_two_spheres_follow_the_interacting_hertz_expansion(distance):
    """d0 = d + F/(pi E D) [1 + (1/10 + 1/6) (a/D)^2], up to (a/D)^4 (moments of the pressure of
    the source and of the punch that receives)."""
    radius, d0 = 50.0, 0.02
    table = HertzTable(np.full(2, radius), np.full(2, 1.0))
    a0 = np.sqrt(radius * d0)
    y, x = np.array([0.0, 0.6 * distance * a0]), np.array([0.0, 0.8 * distance * a0])
    f = Footprints(1.0)
    plan = Interaction(y, x, (50.0, 60.0), "free", f, widest=f.variance(2 * a0))
    problem = Problem(np.full(2, d0), Laws(table, f), plan, DEFAULTS.contact_shift)
    solution = descent(problem, 0.0, CandidateValues.of(np.full(2, 0.5 * d0)), tolerance=1e-9)
    d = d0
    for _ in range(200):
        a = np.sqrt(radius * d)
        ratio = a / (distance * a0)
        force = 4 / 3 * a * d
        d = 0.5 * (d + d0 - force / (np.pi * distance * a0) * (1 + (1 / 10 + 1 / 6) * ratio**2))
    np.testing.assert_allclose(solution.laws.force, force, rtol=2e-3 * (3 / distance) ** 2)


def test_conjugate_gradients_solve_the_tangent_system():
    problem = make(200)
    stiffness = problem.laws(1.5 * reach(problem.laws)).stiffness
    tangent = Tangent(problem.coupling, np.ones(200, bool), stiffness)
    right = np.random.default_rng(0).normal(size=200)
    solved = conjugate_gradients(tangent, right, tolerance=1e-9)
    assert solved.products < 200 and solved.constant == 0
    assert np.abs(tangent(solved.solution) - right).max() < 1e-5


class Thin:
    """A diagonal matrix of unit springs, of which the last meets hardly any resistance."""

    compliance, cell = np.ones(3), np.zeros(3, np.int64)
    coarse = np.zeros((1, 1)), np.array([3.0])

    def __call__(self, change):
        return change * [1.0, 1.0, 1e-4]


@pytest.mark.parametrize("right", [[0.0, 0.0, 1.0], [1.0, 2.0, 3.0]])
def test_conjugate_gradients_do_not_run_away_where_the_matrix_is_nearly_singular(right):
    solved = conjugate_gradients(Thin(), np.array(right), tolerance=1e-6)
    assert 0.0 < np.abs(solved.solution).max() <= 3.0 * max(right)


def test_conjugate_gradients_go_on_from_a_start_of_rounding():
    """Where nothing resists, the first direction is a step: that of the start is none."""
    start = 1e-18 * np.array([1.0, -2.0, 1.0])
    solved = conjugate_gradients(Thin(), np.array([0.0, 0.0, 1.0]), tolerance=1e-6, start=start)
    assert np.abs(solved.solution).max() > 0.1


def test_conjugate_gradients_hold_the_sum():
    """T x + c = r with a given sum of x, from any start that has it."""
    problem = make(200)
    stiffness = problem.laws(1.5 * reach(problem.laws)).stiffness
    tangent = Tangent(problem.coupling, np.ones(200, bool), stiffness)
    right, start = np.random.default_rng(0).normal(size=(2, 200))
    # a sum in single precision stalls below 3e-9
    solved = conjugate_gradients(tangent, right, tolerance=1e-7, start=start, held=True)
    assert solved.products < 200
    assert solved.solution.sum() == pytest.approx(start.sum(), abs=1e-9 * np.abs(start).sum())
    # single precision: up to 1.2e-5 among 60 seeds
    assert np.abs(tangent(solved.solution) + solved.constant - right).max() < 2e-5


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_a_load_is_met_in_one_descent(m):
    """The separation is one more unknown: load, contacts and separation fit together."""
    problem = make(225, m=m, filling=0.2, apart=True)
    load = 0.3 * problem.laws(reach(problem.laws)).force.sum()
    start = CandidateValues.of(0.2 * reach(problem.laws))
    found = descent(problem, 0.05, start, load=load, tolerance=1e-6)
    assert not found.reason
    assert found.laws.force.sum() == pytest.approx(load, rel=1e-6)
    start = CandidateValues.of(0 * problem.height)
    again = descent(problem, found.separation, start, tolerance=1e-6)
    np.testing.assert_allclose(again.laws.force, found.laws.force, atol=1e-4 * load / 225)
