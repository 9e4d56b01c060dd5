"""The two-level preconditioner must not change what is solved."""

from __future__ import annotations

import numpy as np
import pytest

from asperity.halfspace.footprint import Footprints
from asperity.interaction.ewald import two_level
from asperity.interaction.ewald.operator import Interaction
from asperity.interaction.ewald.tangent import Tangent
from asperity.interaction.newton.step import conjugate_gradients

CELL = (1.0, 1.7)
MANY = 5_000


def tangent(n, m, boundary, seed=0):
    """Tangent of n discs, crowded in the middle, that cover a fifth of the cell."""
    rng = np.random.default_rng(seed)
    y, x = (rng.beta(1.5, 1.5, n) * side for side in CELL)
    f = Footprints(2.0, m)
    k = f.punch(np.sqrt(0.2 * CELL[0] * CELL[1] / (np.pi * n)) * rng.uniform(0.5, 1.5, n))
    plan = Interaction(y, x, CELL, boundary, f, widest=float(f.variance(k).max()))
    closed = rng.uniform(size=n) < 0.9
    return Tangent(plan, closed, k[plan.order])


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_inverse_is_that_of_forces_which_share_a_displacement_in_each_cell(m, boundary):
    matrix = tangent(MANY, m, boundary)
    cells, stiffness = matrix.coupling.two_level, 1 / matrix.compliance
    correction, total = cells.inverse(matrix.cell, stiffness)
    np.testing.assert_allclose(total.sum(), stiffness.sum(), rtol=1e-12)
    np.testing.assert_allclose(correction, correction.T, atol=1e-9 * np.abs(correction).max())
    kernel = cells.kernel
    assert np.linalg.eigvalsh(kernel)[0] > -1e-9 * np.abs(kernel).max()
    coarse = np.diag(total) + total[:, None] * kernel * total
    inverse = np.linalg.inv(coarse)
    np.testing.assert_allclose(
        correction + np.diag(1 / total), inverse, atol=1e-9 * np.abs(inverse).max()
    )
    # the tangent itself, between the cells
    some = np.arange(len(total))[::17]
    own = np.array([stiffness * (matrix.cell == c) for c in some])
    found = np.array([own @ matrix(force) for force in own])
    wanted = coarse[np.ix_(some, some)]
    scale = np.sqrt(np.multiply.outer(wanted.diagonal(), wanted.diagonal()))
    # a half-space that repeats at twice the size is lower by a constant
    assert np.abs((found - wanted) / scale).max() < (0.15 if boundary == "periodic" else 0.6)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("held", [True, False])
def test_solves_the_same_in_fewer_products(held, boundary, monkeypatch):
    found = []
    for few in (MANY, MANY + 1):
        monkeypatch.setattr(two_level, "FEWEST_POINTS", few)
        matrix = tangent(MANY, 0.0, boundary)
        right = 1.0 + np.sin(3 * np.arange(len(matrix)))
        start = 1 / matrix.compliance if held else None
        solved = conjugate_gradients(matrix, right, tolerance=1e-4, start=start, held=held)
        left = right - matrix(solved.solution) - solved.residual
        assert np.abs(left).max() < 1e-4 * np.abs(right).max()
        if held:
            assert solved.solution.sum() == pytest.approx(start.sum(), rel=1e-9)
        found.append(solved)
    helped, plain = found
    assert helped.products < 0.8 * plain.products
    size = np.abs(plain.solution).max()
    np.testing.assert_allclose(helped.solution, plain.solution, atol=2e-3 * size)
