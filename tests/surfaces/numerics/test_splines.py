"""Quintic splines of a map: through every point, the tensor product, exact for a quadratic."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import BSpline

from surfaces.numerics import splines


@pytest.mark.parametrize("periodic", [True, False])
def test_spline_interpolates_every_point(periodic):
    h = np.random.default_rng(3).normal(size=(23, 31))
    spline = splines.coefficients(h, periodic)
    places = np.mgrid[:23, :31].reshape(2, -1).astype(float)
    values = [splines.expand(spline.ravel(), spline.shape[1], *place)[0] for place in places.T]
    assert_allclose(np.reshape(values, h.shape), h, atol=1e-8)


def test_spline_and_its_derivatives_are_those_of_the_tensor_product():
    h = np.random.default_rng(4).normal(size=(19, 27))
    spline = splines.coefficients(h, True)
    pad = splines.PAD
    basis = BSpline.basis_element(np.arange(-3.0, 4.0), extrapolate=False)
    y, x = 7.3, 11.85
    parts = []
    for at in (y, x):
        taps = np.floor(at) + np.arange(-2.0, 4.0)
        parts.append([np.nan_to_num(basis.derivative(k)(at - taps)) for k in range(3)])
    block = spline[pad + 5 : pad + 11, pad + 9 : pad + 15]
    orders = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    exact = [parts[0][a] @ block @ parts[1][b] for a, b in orders]
    found = splines.expand(spline.ravel(), spline.shape[1], y, x)
    assert_allclose(found, exact, rtol=1e-11, atol=1e-12)


def test_spline_is_exact_for_a_quadratic_up_to_the_border():
    y, x = np.mgrid[:20, :26].astype(float)

    def surface(y, x):
        return 1 + 0.3 * y - 0.2 * x + 0.01 * y * y - 0.03 * x * y + 0.02 * x * x

    spline = splines.coefficients(surface(y, x), False)
    for at in ((0.3, 0.2), (10.5, 12.25), (18.9, 24.7)):
        found = splines.expand(spline.ravel(), spline.shape[1], *at)
        assert found[0] == pytest.approx(surface(*at), abs=1e-8)
        assert_allclose(found[3:], [0.02, -0.03, 0.04], atol=1e-7)
