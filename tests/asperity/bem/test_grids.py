"""Nested grids, and pressures carried from one to the next."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from asperity import HalfSpace
from asperity.bem.correction import NestedGrid
from asperity.bem.grids import nested_shapes, prolong
from asperity.bem.operator import HalfSpaceOperator


@pytest.mark.parametrize("shape", [(4096, 4096), (97, 1000), (211, 197), (64, 64), (1, 300)])
def test_grids_end_small_and_hold_half_of_the_points_of_the_next_or_a_quarter_of_large_ones(shape):
    shapes = nested_shapes(shape)
    assert shapes[-1] == shape
    assert min(shapes[0]) <= 48
    for coarse, fine in itertools.pairwise(shapes):
        share = 0.25 if fine[0] * fine[1] > 1400**2 else 0.5
        for few, many in zip(coarse, fine, strict=True):
            assert share * many <= few <= 1.2 * share * many + 1


def grid_of(shape, pressure, boundary):
    """Grid of a pressure in an array that may be larger than the map."""
    material = HalfSpace.from_modulus(1.0)
    grid = NestedGrid(np.zeros(shape), HalfSpaceOperator(shape, (1.0, 1.0), material, boundary))
    grid.exact.pressure = pressure
    return grid


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("fine_shape", [(48, 80), (45, 77), (12, 20)])
def test_a_pressure_carried_to_a_finer_grid_has_the_mean_asked_for(boundary, fine_shape):
    """Whatever lies beside both grids in memory, and wherever the coarse one begins."""
    rng = np.random.default_rng(0)
    coarse, fine = rng.uniform(0.0, 1.0, (12, 24)), np.full((50, 90), np.nan)
    origin = (7, 3) if boundary == "periodic" else (0, 0)
    prolong(grid_of((12, 20), coarse, boundary), grid_of(fine_shape, fine, boundary), 0.3, origin)
    held = fine[: fine_shape[0], : fine_shape[1]]
    assert held.mean() == pytest.approx(0.3, rel=1e-12)
    assert held.min() >= 0.0
    if fine_shape == (12, 20):
        same = np.roll(coarse[:, :20], origin, (0, 1))
        assert held == pytest.approx(same * 0.3 / same.mean(), rel=1e-12)
