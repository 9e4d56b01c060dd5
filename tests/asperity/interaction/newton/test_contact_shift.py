"""Contacts that move aside: gradients, moments, and the energy behind both."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import HertzTable, free_interaction, periodic_interaction
from strategies import random_population

from asperity.halfspace.footprint import Footprints
from asperity.interaction.ewald.operator import Interaction
from asperity.interaction.newton.contact_shift import contact_shifts, widened
from asperity.interaction.newton.laws import Laws
from asperity.interaction.newton.solver import descent
from asperity.interaction.newton.state import CandidateValues, Problem, State
from asperity.parameters import DEFAULTS

CELL = (1.0, 1.4)
EXPONENTS = (-0.3, 0.0, 0.5)
FITTED = DEFAULTS.contact_shift


def scene(m, boundary, n=120, seed=0):
    y, x, _, _ = random_population(n, CELL, seed)
    f = Footprints(2.0, m)
    force = np.random.default_rng(seed).uniform(0.2, 1.0, n)
    moment = np.full(n, 2e-4)
    plan = Interaction(y, x, CELL, boundary, f, widest=2e-4)
    return plan, y[plan.order], x[plan.order], force, moment, f


def differences(y, x, boundary):
    dy, dx = y[:, None] - y, x[:, None] - x
    if boundary == "periodic":
        dy, dx = dy - CELL[0] * np.round(dy / CELL[0]), dx - CELL[1] * np.round(dx / CELL[1])
    return dy, dx


@pytest.mark.parametrize("m", EXPONENTS)
def test_gradient_is_the_dense_sum(m):
    plan, y, x, force, moment, f = scene(m, "free")
    growth = 0.5 * moment
    fast = plan.field(force, moment, growth, np.zeros((len(y), 2))).tilt
    dy, dx = differences(y, x, "free")
    spread = moment + growth + moment
    h = 1e-4
    exact = [
        (free_interaction(f, np.hypot(dy + a, dx + b), spread) @ force
         - free_interaction(f, np.hypot(dy - a, dx - b), spread) @ force) / (2 * h)
        for a, b in ((h, 0), (0, h))
    ]  # fmt: skip
    size = np.abs(exact).max()
    assert np.abs(fast - np.transpose(exact)).max() < 0.01 * size


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("m", EXPONENTS)
def test_field_of_moments_is_that_of_moved_forces(m, boundary):
    plan, y, x, force, moment, f = scene(m, boundary)
    shift = np.random.default_rng(1).normal(size=(len(y), 2)) * 1e-4
    fast = plan.field(force, moment, np.zeros(len(y)), force[:, None] * shift).moved
    dy, dx = differences(y, x, boundary)
    moved = []
    for sign in (1, -1):
        by, bx = dy - sign * shift[:, 0], dx - sign * shift[:, 1]
        if boundary == "free":
            kernel = free_interaction(f, np.hypot(by, bx), 2 * moment)
        else:
            kernel = periodic_interaction(by, bx, 2 * moment, CELL, f)
        moved.append(kernel @ force)
    wanted = 0.5 * (moved[0] - moved[1])
    assert np.abs(fast - wanted).max() < 5e-3 * np.abs(fast).max()


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_moments_are_the_adjoint_of_the_gradient(boundary):
    """sum F_i (dipole field at i) = sum p_j . (gradient at j): one energy has both slopes."""
    plan, y, _, force, _, _ = scene(0.0, boundary)
    p = np.random.default_rng(2).normal(size=(len(y), 2))
    field = plan.field(force, np.zeros(len(y)), np.zeros(len(y)), p)
    left, right = force @ field.moved, np.sum(p * field.tilt)
    assert left == pytest.approx(right, abs=1e-6 * np.abs(p).sum() * np.abs(field.tilt).max())


@pytest.mark.parametrize("m", EXPONENTS)
def test_gain_of_a_sphere_on_a_slope(m):
    """R g^2 / 2 for a paraboloid, from the field of one distant force."""
    radius, f = 30.0, Footprints(1.0, m)
    table = HertzTable(np.array([radius, 1e-3]), np.array([1.0, 1.0]), 1.0, m)
    y, x = np.array([0.0, 30.0]), np.array([0.0, 40.0])
    plan = Interaction(y, x, (100.0, 120.0), "free", f, widest=1.0)
    laws = Laws(table, f)
    problem = Problem(np.zeros(2), laws.rows(plan.order), plan, FITTED, contact_shift=True)
    state = State(problem, np.array([0.05, 0.5])[plan.order], np.zeros((2, 2)))
    gained = np.empty(2)
    gained[plan.order] = state.gain - state.field.moved - state.field.longer
    source = laws(np.array([0.05, 0.5])).force[1]
    slope = f.point * (1 + m) * source / 50.0 ** (2 + m)
    bounded = 1 + radius * slope**2 / (FITTED.largest**2 * (1 + m) * 0.05)
    assert gained[0] == pytest.approx(0.5 * radius * slope**2 / bounded, rel=0.02)


def test_a_lone_contact_does_not_move():
    f = Footprints(1.0)
    table = HertzTable(np.array([1.0]), np.array([1.0]))
    plan = Interaction(np.array([0.3]), np.array([0.4]), CELL, "periodic", f)
    problem = Problem(
        np.zeros(1), Laws(table, f).rows(plan.order), plan, FITTED, contact_shift=True
    )
    state = State(problem, np.array([1e-3]), np.zeros((1, 2)))
    assert abs((state.gain - state.field.moved)[0]) < 1e-6 * 1e-3


@pytest.mark.parametrize("m", EXPONENTS)
def test_deflection_raises_the_load(m):
    """More freedom lowers the energy at every separation."""
    y, x, height, table = random_population(196, CELL, 1, m=m, apart=True)
    f = Footprints(1.0, m)
    plan = Interaction(y, x, CELL, "periodic", f, widest=f.variance(table.stiffness[:, -1]).max())
    laws = Laws(table, f).rows(plan.order)
    still, moving = (
        descent(
            Problem(height[plan.order], laws, plan, FITTED, contact_shift),
            0.01,
            CandidateValues.of(np.zeros(196)),
            tolerance=1e-4,
        )
        for contact_shift in (False, True)
    )
    assert not still.reason and not moving.reason and moving.residual <= 1e-4
    assert 1.0 < moving.laws.force.sum() / still.laws.force.sum() < 1.3


@pytest.mark.parametrize("m", EXPONENTS)
def test_contacts_beside_rough_summits_are_wider(m):
    table = HertzTable(np.full(4, 0.1), np.full(4, 0.01), m=m)
    body, approach, radii = Footprints(1.0, m), np.full(4, 1e-3), np.tile([1.0, 1.0, 0.0], (4, 1))
    laws = Laws(table, body)(approach)
    radius = np.sqrt(laws.area / np.pi)
    # a paraboloid moves by R times the gradient, and less near the largest shift
    free = np.array([0.2, 0.2, 0.1, 3.0])
    tilt = np.outer(free, [0.6, 0.8]) * radius[:, None] / 0.1
    rough = np.array([False, True, True, True])
    area = widened(body, laws, approach, tilt, radii, rough, FITTED)
    aside = free / (1 + (free / FITTED.largest) ** 2)
    np.testing.assert_allclose(
        contact_shifts(body, laws, approach, tilt, radii, FITTED.largest)[1],
        -tilt * (0.1 * aside / free)[:, None],
        rtol=1e-6,
    )
    grown = 1 + FITTED.growth * ((1 + m) * aside) ** 2 * rough
    np.testing.assert_allclose(area, laws.area * grown, rtol=1e-6)
    assert (widened(body, laws, approach, 0 * tilt, radii, rough, FITTED) == laws.area).all()
