"""Elongated footprints: their compliance, their field, and radii of curvature along and across."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import free_interaction
from strategies import random_population

from asperity.halfspace.footprint import Footprints
from asperity.halfspace.material import HalfSpace
from asperity.interaction.elongation import Elongation
from asperity.interaction.ewald.near_pairs import CUT_OVER_SPLIT_LENGTH
from asperity.interaction.ewald.operator import Interaction
from asperity.interaction.newton.laws import Laws
from asperity.interaction.newton.solver import descent
from asperity.interaction.newton.state import CandidateValues, Problem
from asperity.microcontact.hertz import elliptic_contact
from asperity.parameters import DEFAULTS

EXPONENTS = (-0.3, 0.0, 0.5)
CELL = (1.0, 1.4)
BOUNDS = DEFAULTS.elongation


def principal(tensor):
    """Values and direction of the larger one of a tensor yy, xx, xy."""
    yy, xx, xy = tensor
    half = np.hypot(0.5 * (xx - yy), xy)
    return 0.5 * (xx + yy) + half, 0.5 * (xx + yy) - half, 0.5 * np.arctan2(2 * xy, xx - yy)


def of(ratio, angle, m=0.0):
    """Elongation of one summit."""
    return Elongation.of(np.array([[ratio, 1.0]]), np.array([angle]), Footprints(1.0, m), BOUNDS)


@pytest.mark.parametrize("m", EXPONENTS)
def test_round_summits_have_round_footprints(m):
    found = of(1.0, 0.7, m)
    np.testing.assert_allclose(found.moments, [[1, 1, 0]], atol=1e-6)
    np.testing.assert_allclose(found.radii, [[1, 1, 0]], atol=1e-4)


@pytest.mark.parametrize("m", EXPONENTS)
@pytest.mark.parametrize("ratio", [2.0, 9.0, 60.0])
def test_an_elongated_footprint_keeps_the_compliance_of_its_contact(m, ratio):
    """int Lambda(q) exp(-q C q) d^2q over all directions does not depend on the elongation."""
    large, small, angle = principal(of(ratio, 0.6, m).moments[0])
    assert angle == pytest.approx(0.6)
    hertz = elliptic_contact(ratio, 1.0, 1.0, HalfSpace.from_modulus(1.0, m=m))
    exact = min(float(hertz.semi_major / hertz.semi_minor), BOUNDS.aspect)
    assert np.sqrt(large / small) == pytest.approx(exact, rel=1e-5)
    theta = np.linspace(0, np.pi, 4001)[:-1]
    square = large * np.cos(theta) ** 2 + small * np.sin(theta) ** 2
    assert np.mean(square ** (-0.5 * (1 + m))) == pytest.approx(1.0, rel=2e-3)
    assert large + small > 2.0


def test_a_contact_leans_less_across_and_not_much_more_along():
    large, small, angle = principal(of(4.0, -0.4).radii[0])
    assert angle == pytest.approx(-0.4)
    assert large == BOUNDS.radius
    # Hertz: the radii of curvature have the ratio of the curvatures
    free = of(1.5, 0.0).radii[0]
    assert free[1] / free[0] == pytest.approx(1.5, rel=0.03)
    assert 0 < small < 1


@pytest.mark.parametrize("m", EXPONENTS)
@pytest.mark.parametrize("angle", [0.0, 0.5, np.pi / 2])
def test_field_of_a_long_pair_is_that_of_elliptic_gaussians(m, angle):
    """Gauss-Hermite average of round kernels over the long axis, with many nodes."""
    f, place = Footprints(2.0, m), np.array([[0.0, 0.0], [0.05, 0.12]])
    variance, form = np.full(2, 4e-4), of(4.0, angle, m).moments
    how = {"form": np.tile(form, (2, 1)), "widest": 1e-3}
    plan = Interaction(place[:, 0], place[:, 1], (1.0, 1.0), "free", f, **how)
    force = np.array([0.0, 1.0])[plan.order]
    field = plan.field(force, variance)
    here = int(np.flatnonzero(force == 0)[0])
    large, small, turn = principal(2 * 4e-4 * form[0])
    node, weight = np.polynomial.hermite_e.hermegauss(40)
    along = np.sqrt(large - small) * node
    dy, dx = place[1] - place[0]
    distance = np.hypot(dy + along * np.sin(turn), dx + along * np.cos(turn))
    exact = weight / weight.sum() @ free_interaction(f, distance, small)
    assert field.value[here] + field.longer[here] == pytest.approx(exact, rel=0.025)


@pytest.mark.parametrize("m", EXPONENTS)
def test_far_from_a_long_footprint_its_mean_moment_is_felt(m):
    """The mean over a circle of places beyond the near pairs, of long contacts as of elliptic
    Gaussians."""
    f, count, far, variance = Footprints(2.0, m), 480, 0.4, 1e-3
    turn = 2 * np.pi * np.arange(count) / count
    y, x = np.append(far * np.sin(turn), 0.0), np.append(far * np.cos(turn), 0.0)
    n, form = count + 1, of(6.0, 0.4, m).moments
    how = {"form": np.repeat(form, n, axis=0), "widest": variance}
    plan = Interaction(y, x, (1.0, 1.0), "free", f, **how)
    assert CUT_OVER_SPLIT_LENGTH * plan.eta < far
    force = (plan.order == count).astype(float)
    field = plan.field(force, np.full(n, variance))
    large, small, angle = principal(2 * variance * form[0])
    node, weight = np.polynomial.hermite_e.hermegauss(40)
    along = np.sqrt(large - small) * node
    apart = np.hypot(y[:-1, None] + along * np.sin(angle), x[:-1, None] + along * np.cos(angle))
    exact = np.mean(free_interaction(f, apart, small) @ weight / weight.sum())
    ring = (field.value + field.longer)[force == 0]
    lack = exact - float(free_interaction(f, far, 2 * variance))
    assert lack > 1e-3 * exact
    assert np.mean(ring) == pytest.approx(exact, abs=0.25 * lack)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_moments_are_the_adjoint_of_the_gradient(boundary):
    y, x, _, _ = random_population(80, CELL, 0)
    f, rng = Footprints(2.0), np.random.default_rng(0)
    n, variance = len(y), np.full(len(y), 2e-4)
    form = Elongation.of(
        np.stack((rng.uniform(1, 20, n), np.ones(n)), 1), rng.uniform(-1.5, 1.5, n), f, BOUNDS
    ).moments
    plan = Interaction(y, x, CELL, boundary, f, form=form, widest=2e-4)
    force, p = rng.uniform(0.2, 1.0, n), rng.normal(size=(n, 2))
    # beyond the cut-off the mesh knows moments of the variance that forces alone have
    field = plan.field(force, variance, np.zeros(n), p)
    left, right = force @ field.moved, np.sum(p * field.tilt)
    assert left == pytest.approx(right, abs=0.02 * np.abs(p * field.tilt).sum())


def test_a_turned_scene_carries_the_same():
    y, x, height, table = random_population(64, (1.0, 1.0), 3, apart=True)
    f = Footprints(1.0)
    loads = []
    for turned in (False, True):
        here, there = (x, 1.0 - y) if turned else (y, x)
        shape = np.tile([6.0, 1.0], (len(y), 1))
        angle = np.full(len(y), 0.3 - (np.pi / 2 if turned else 0.0))
        widest = f.variance(table.stiffness[:, -1]).max()
        long = Elongation.of(shape, angle, f, BOUNDS)
        how = {"form": long.moments, "widest": widest}
        plan = Interaction(here, there, (1.0, 1.0), "periodic", f, **how)
        problem = Problem(
            height[plan.order],
            Laws(table, f).rows(plan.order),
            plan,
            DEFAULTS.contact_shift,
            True,
            long.rows(plan.order),
        )
        solution = descent(problem, 0.01, CandidateValues.of(np.zeros(len(y))), tolerance=1e-4)
        assert not solution.reason
        loads.append(solution.laws.force.sum())
    assert loads[0] == pytest.approx(loads[1], rel=2e-3)
