"""Pressure fields: the history integral against the scaled field, tables against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from asperity import HalfSpace, InputError, indent
from surfaces import PolarProfile, PolynomialProfile, PowerLawProfile
from surfaces.shapes import bent_body

ANGLES = np.linspace(0, 6, 9)
SHARES = np.linspace(0.1, 0.99, 9)


@pytest.mark.parametrize("law", ["paper", "harmonic"])
@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
@pytest.mark.parametrize("k", [1, 2, 3])
def test_history_integral_equals_the_scaled_field_of_power_laws(law, m, k):
    profile = PowerLawProfile(k, lambda p: 1 + 0.1 * np.cos(2 * p) + 0.1 * np.cos(3 * p))
    one = indent(profile, HalfSpace.from_modulus(1.0, m), 0.1, law=law)
    r = one.contour(ANGLES) * SHARES
    x, y = r * np.cos(ANGLES), r * np.sin(ANGLES)
    tolerance = 1e-10 if law == "paper" else 1e-7
    np.testing.assert_allclose(one.pressure(x, y, history=True), one.pressure(x, y), rtol=tolerance)


def test_history_differs_to_second_order_where_the_section_changes():
    one = indent(bent_body(), HalfSpace.from_modulus(1.0), np.array([0.1, 1.0]), law="paper")
    x = one.radius[0] * np.linspace(-0.7, 0.7, 5)
    whole, scaled = (one.pressure(x, 0.1 * x, history=h) for h in (True, False))
    assert 1e-4 < np.max(np.abs(whole / scaled - 1)) < 0.05


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_elliptic_contact_has_the_exact_pressure_to_first_order(m):
    """One percent of ellipticity: the field errs by its square."""
    profile = PolynomialProfile({(2, 0): 0.505, (0, 2): 0.495})
    exact = indent(profile, HalfSpace.from_modulus(1.0, m), 0.1, law="hertz")
    one = indent(profile, HalfSpace.from_modulus(1.0, m), 0.1, law="paper")
    x = one.radius * np.array([-0.6, 0.0, 0.3, 0.8])
    np.testing.assert_allclose(one.pressure(x, 0.1 * x), exact.pressure(x, 0.1 * x), rtol=1e-3)


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_pressure_of_a_table_agrees_with_the_closed_form(m):
    r, turn = np.linspace(0, 2, 40), 2 * np.pi * np.arange(32) / 32
    body = bent_body()
    table = PolarProfile(r, turn, body(r[:, None], turn))
    closed, sampled = (indent(p, HalfSpace.from_modulus(1.0, m), 0.5) for p in (body, table))
    x = np.linspace(-0.6, 0.6, 13)
    for history in (False, True):
        np.testing.assert_allclose(
            sampled.pressure(x, 0.1, history=history),
            closed.pressure(x, 0.1, history=history),
            rtol=2e-3,
            atol=1e-4,
        )


def test_hertz_has_no_history_integral():
    one = indent(PowerLawProfile(2, 1.0), HalfSpace.from_modulus(1.0), 0.1, law="hertz")
    with pytest.raises(InputError, match="no history integral"):
        one.pressure(0.0, 0.0, history=True)


def test_table_of_many_points_agrees_with_the_integral_at_few():
    one = indent(bent_body(), HalfSpace.from_modulus(1.0, 0.2), 0.5)
    x = np.linspace(-0.7, 0.7, 30)
    field = one.pressure(x, x[:, None])
    rows = np.array([9, 14, 20])
    few = one.pressure(x[::3], x[rows, None])
    np.testing.assert_allclose(field[rows, ::3], few, rtol=2e-3, atol=2e-3 * few.max())
