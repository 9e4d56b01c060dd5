"""Exact elliptic contacts: tables of closed values, elliptic integrals, limits."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipe, ellipk

from asperity import HalfSpace, InputError
from asperity.microcontact.hertz import elliptic_contact

GRADED = {
    (-0.3, 1.5): (1.4178640156, 0.2493620414, 0.4314402179, 3.4906585040),
    (-0.3, 2.0): (1.6794704167, 0.1792193700, 0.4587518116, 4.6542113387),
    (0.0, 1.5): (1.9042414169, 0.4656971609, 0.8564228048, 3.1415926536),
    (0.0, 2.0): (2.1565156475, 0.3151532066, 0.8959028209, 4.1887902048),
    (0.5, 1.5): (2.5876376024, 0.9058379268, 1.8433210683, 2.6927937031),
    (0.5, 2.0): (2.7404681726, 0.5571280017, 1.8821902521, 3.5903916041),
}


@pytest.mark.parametrize("key", GRADED)
def test_graded_ellipses_of_the_table(key):
    """Contacts with p0 = E* = b = 1: the half-axes and the force come back."""
    (m, a), (d, flat, steep, force) = key, GRADED[key]
    found = elliptic_contact(2 * steep, 2 * flat, d, HalfSpace.from_modulus(1.0, m))
    values = [found.semi_minor, found.semi_major, found.force, found.peak_pressure]
    np.testing.assert_allclose(values, [1.0, a, force, 1.0], rtol=1e-9)


@pytest.mark.parametrize("ratio", [1.01, 1.5, 3.0, 10.0, 50.0])
def test_homogeneous_contact_is_that_of_the_elliptic_integrals(ratio):
    a, b, p0, modulus = ratio, 1.0, 0.7, 3.0
    e2 = 1 - (b / a) ** 2
    k, e = ellipk(e2), ellipe(e2)
    scale = p0 * b / (modulus * e2 * a * a)
    flat, steep = scale * (k - e), scale * (a * a / (b * b) * e - k)
    body = HalfSpace.from_modulus(modulus)
    found = elliptic_contact(2 * flat, 2 * steep, p0 * b / modulus * k, body)
    values = [found.semi_major, found.semi_minor, found.force, found.peak_pressure]
    np.testing.assert_allclose(values, [a, b, 2 / 3 * np.pi * a * b * p0, p0], rtol=1e-10)


@pytest.mark.parametrize("m", [-0.5, -0.3, 0.3, 0.5, 0.8])
@pytest.mark.parametrize("beta", [0.9, 0.3, 0.05])
def test_graded_contact_satisfies_the_defining_integrals(m, beta):
    """Semi-axes a = 1, b = beta against numerical quadrature over the directions."""

    def alpha(t):
        return (np.cos(t) ** 2 + (np.sin(t) / beta) ** 2) ** -0.5

    def integral(f):
        ends = dict(epsabs=0, epsrel=1e-13, limit=400)
        return quad(f, 0, np.pi / 2, points=[0.05, 0.3], **ends)[0] * 2

    whole = integral(lambda t: alpha(t) ** (1 - m))
    flat = whole - (1 - m) * integral(lambda t: alpha(t) ** (3 - m) * np.cos(t) ** 2)
    steep = integral(lambda t: alpha(t) ** (3 - m) * np.sin(t) ** 2)
    steep = (whole - (1 - m) * steep / beta**2) / beta**2
    c = (1 + m) / 2
    found = elliptic_contact(2 * c * flat, 2 * c * steep, c * whole, HalfSpace.from_modulus(1.0, m))
    np.testing.assert_allclose(
        [found.semi_major, found.semi_minor, found.peak_pressure], [1.0, beta, 1.0], rtol=1e-9
    )


def test_no_contact_without_approach_and_no_negative_curvature():
    material = HalfSpace.from_modulus(1.0)
    assert elliptic_contact(2.0, 1.0, 0.0, material).force == 0
    with pytest.raises(InputError, match="curvatures must be positive"):
        elliptic_contact(2.0, -1.0, 0.1, material)
    with pytest.raises(InputError, match="too large for a point contact"):
        elliptic_contact(1e12, 1.0, 0.1, material)
