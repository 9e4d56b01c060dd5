"""Thirty random contacts: any shape, pixel, boundary, grading, spectrum and load, all certified."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import periodic_displacement
from samples import displaced
from strategies import random_case

from asperity import bem_solve
from asperity.bem.operator import HalfSpaceOperator

TOLERANCE = 1e-7


@pytest.mark.parametrize("seed", range(30))
def test_random_contact_is_certified(seed):
    """Converged, and certified anew by an operator that the solver did not use."""
    hm, body, pressure, boundary = random_case(seed)
    solution = bem_solve(hm, body, pressure=pressure, boundary=boundary, tolerance=TOLERANCE)
    assert solution.converged, str(solution)
    assert solution.fft_pairs <= 10
    p = solution.pressure
    assert p.min() >= 0.0
    assert p.mean() == pytest.approx(pressure, rel=TOLERANCE)
    if boundary == "periodic":
        u = periodic_displacement(p, hm.spacing, body.modulus, body.m)
    else:
        u = displaced(HalfSpaceOperator(hm.shape, hm.spacing, body, "free"), p)
    gap = u - hm.heights
    scale = max(hm.rms_height, 1e-6 * np.abs(u).max())
    assert (p * (gap - gap.min())).sum() / p.sum() < 1.1 * TOLERANCE * scale
    assert gap[p > 0].mean() - gap.min() < 1.1 * TOLERANCE * scale
