"""The fourth-order expansion about an ellipse: its order, its operators, sharp tips and corners."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
from asperity import HalfSpace, indent, indent_bem
from asperity.microcontact.ellipse.ellipse_operator import LOG_RATIO, edge_slopes
from asperity.microcontact.hertz import elliptic_contact
from asperity.microcontact.single.ellipse_expansion import edge_of, fit_points, fitted
from asperity.microcontact.single.ellipse_series import expand
from surfaces import PolynomialProfile, PowerLawProfile, shapes


def test_edge_operator_of_the_circle_is_minus_half_the_order():
    """R = -n/2 and R' = n (n - 2)/8 on the circle, for every grading; a shift has R = -1/2 on every
    ellipse."""
    first, last, count = LOG_RATIO
    circle = round(-first / (last - first) * (count - 1))
    order = np.arange(7)
    exact = (-order / 2, order * (order - 2) / 8)
    for m in (-0.3, 0.5):
        rows = edge_slopes(m, 6)
        for which, values in enumerate(exact):
            found = [np.interp(0.0, np.linspace(first, last, count), rows[:, which, 0, n, n])
                     for n in range(7)]  # fmt: skip
            np.testing.assert_allclose(found, values, atol=2e-3 * which + 1e-9)
            assert np.abs(rows[circle, which, 0] - np.diag(values)).max() < 0.5
        np.testing.assert_allclose(rows[:, 0, 0, 1, 1], -0.5, rtol=1e-9)


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
@pytest.mark.parametrize("change", [(1, 0, 0, 0), (1, -1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)])
def test_expansion_about_a_wrong_ellipse_has_its_order(m, change):
    """Paraboloid of curvature ratio 7: the error is of fifth order in the force and of fourth in
    the area."""
    ratio = 7.0
    k1, k2 = np.sqrt(ratio), 1 / np.sqrt(ratio)
    exact = elliptic_contact(k1, k2, 1.0, HalfSpace.from_modulus(1.0, m))
    long, short = float(exact.semi_major), float(exact.semi_minor)
    xi, eta, _, _ = fit_points()
    errors = []
    for h in (0.05, 0.1):
        grow_a, grow_b, shift_x, shift_y = (h * c for c in change)
        a, b = long * np.exp(grow_a), short * np.exp(grow_b)
        x, y = shift_x * long + a * xi, shift_y * short + b * eta
        gap = fitted(0.5 * (k2 * x * x + k1 * y * y))
        one = expand(edge_of(gap, 1.0, a, b, m))
        force = one.lower + one.second + one.third + one.fourth
        errors.append((force / exact.force - 1, a * b * one.squared.mean() / (long * short) - 1))
    first, second = np.abs(errors)
    assert second[0] < 2e-5 and second[1] < 1e-3
    assert second[0] > 20 * first[0] or second[0] < 1e-6
    assert second[1] > 9 * first[1] or second[1] < 2e-5


@pytest.mark.parametrize(("sides", "k", "bound"), [(3, 1.0, 1.2), (3, 2.0, 1.8), (4, 1.0, 0.35)])
def test_corners_of_sharp_tips(sides, k, bound):
    """Sharp polygonal bodies: within the bound, in percent, and better than `harmonic`."""
    body, material = shapes.polygon(sides, k), HalfSpace.from_modulus(1.0)
    exact = indent_bem(body, material, 1.0, grid=96)
    error = {
        law: 100 * abs(float(indent(body, material, 1.0, law=law).force / exact.force) - 1)
        for law in ("harmonic", "ellipse")
    }
    assert error["ellipse"] < bound and error["ellipse"] < 0.5 * error["harmonic"]


@pytest.mark.parametrize("m", [-0.3, 0.0])
@pytest.mark.parametrize("n", [7, 8])
def test_high_harmonics(n, m):
    """Harmonics above the polynomial's: 10 % of n = 7 and 8 on a round tip."""
    body = PowerLawProfile(2.0, lambda p: 1 + 0.1 * np.cos(n * p))
    material = HalfSpace.from_modulus(1.0, m)
    exact = indent_bem(body, material, 1.0, grid=96)
    one = indent(body, material, 1.0, law="ellipse")
    assert float(one.force / exact.force) == pytest.approx(1, abs=2e-3)
    assert float(one.contact_area / exact.contact_area) == pytest.approx(1, abs=1e-2)
    assert one.flags == 0


def test_area_of_narrow_contacts_with_harmonics_for_negative_grading():
    """m = -0.3, curvature ratio 10, 15 % of the third harmonic: force to 0.3 %, area to 2 %."""
    material = HalfSpace.from_modulus(1.0, -0.3)
    k1, k2 = np.sqrt(10.0), 1 / np.sqrt(10.0)
    contact = elliptic_contact(k1, k2, 1.0, material)
    a, b = float(contact.semi_major), float(contact.semi_minor)
    e = 0.15 * 0.25 * (k2 * a * a + k1 * b * b)
    body = PolynomialProfile(
        {(2, 0): 0.5 * k2, (0, 2): 0.5 * k1, (3, 0): e / a**3, (1, 2): -3 * e / (a * b * b)}
        | {(4, 0): 0.3 * e / a**4, (2, 2): 0.6 * e / (a * b) ** 2, (0, 4): 0.3 * e / b**4}
    )
    exact = indent_bem(body, material, 1.0, grid=96, tolerance=1e-4)
    one = indent(body, material, 1.0, law="ellipse")
    assert float(one.contact_area / exact.contact_area) == pytest.approx(1, abs=0.02)
    assert float(one.force / exact.force) == pytest.approx(1, abs=3e-3)


@pytest.mark.parametrize("k", [1.0, 1.5])
def test_stiffness_and_round_tips(k):
    """Power laws of revolution, 1e-4 or better; the stiffness is the slope of the force."""
    material = HalfSpace.from_modulus(2.0, 0.2)
    body = PowerLawProfile(k, lambda p: 1 + 0.1 * np.cos(3 * p))
    round_one = asperity.indent(PowerLawProfile(k, 1.0), material, 0.01, law="ellipse")
    exact = asperity.indent(PowerLawProfile(k, 1.0), material, 0.01, law="paper")
    assert float(round_one.force) == pytest.approx(float(exact.force), rel=1e-4)
    d = 0.7 * np.exp([-2e-3, 0.0, 2e-3])
    one = asperity.indent(body, material, d, law="ellipse")
    power = np.log(one.force[2] / one.force[0]) / 4e-3
    assert power == pytest.approx(d[1] * one.stiffness[1] / one.force[1], rel=1e-6)
