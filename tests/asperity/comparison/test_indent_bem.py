"""`asperity.indent_bem`: the approximate start spares work and does not change the answer."""

from __future__ import annotations

import numpy as np
import pytest

from asperity import HalfSpace, InputError, indent_bem
from asperity.bem.single import FirstGuess
from asperity.bem.single import indent_bem as solve_bem
from asperity.indentation_bem import first_guess
from surfaces import PolynomialProfile, PowerLawProfile, shapes


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_the_start_does_not_change_the_answer(m):
    material, body = HalfSpace.from_modulus(3.0, m), shapes.polygon(4)
    started, plain = (f(body, material, 0.02, grid=72) for f in (indent_bem, solve_bem))
    assert started.valid and plain.valid
    assert started.force == pytest.approx(plain.force, rel=2e-5)
    assert started.contact_area == pytest.approx(plain.contact_area, rel=5e-3)


def test_a_wrong_start_does_no_harm():
    """A tenth of the approach and pressures on the wrong side: the certificate still decides."""
    material, body = HalfSpace.from_modulus(1.0), shapes.polygon(3)
    wrong = FirstGuess(0.1, lambda x, y: np.where(x > 0.5, 1.0, 0.0))
    plain = solve_bem(body, material, 1.0, grid=64)
    found = solve_bem(body, material, 1.0, grid=64, guesses=[wrong])
    assert found.valid and found.force == pytest.approx(plain.force, rel=1e-4)
    found = solve_bem(body, material, load=float(plain.force), grid=64, guesses=[wrong])
    assert found.valid and found.approach == pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize("m", [-0.3, 0.4])
def test_the_start_is_the_approximate_solution(m):
    """Pressure of the round paraboloid, exact up to the interpolation."""
    material, body = HalfSpace.from_modulus(1.0, m), PolynomialProfile({(2, 0): 1.0, (0, 2): 1.0})
    guess = first_guess(body, material, "approach", 2 / (1 + m))
    assert guess is not None
    x, y = np.array([0.1, -0.3, 0.5, 0.0]), np.array([0.2, 0.4, -0.6, 1.1])
    expected = guess.pressure(np.zeros(1), np.zeros(1)) * np.maximum(1 - x**2 - y**2, 0) ** (
        (1 + m) / 2
    )
    np.testing.assert_allclose(guess.pressure(x, y), expected, rtol=1e-3)
    assert first_guess(lambda r, phi: r**2, material, "approach", 1.0) is None


def test_load_control_starts_at_the_approach_of_the_law():
    material, body = HalfSpace.from_modulus(1.0, 0.2), shapes.rounded_polygon(4, 2.0)
    by_approach = indent_bem(body, material, 0.3, grid=64)
    by_load = indent_bem(body, material, load=float(by_approach.force), grid=64)
    assert by_load.valid and by_load.approach == pytest.approx(0.3, rel=1e-3)


def test_thin_corners_are_not_cut_off():
    """Corners that the coarse grid does not see: the fine grid is widened until it holds them."""
    body, material = shapes.random_polygon(1.0, sides=5, seed=11), HalfSpace.from_modulus(1.0)
    found = indent_bem(body, material, 1.0, grid=96)
    contact = found.solutions[-1].contact
    assert found.valid
    assert not contact[[0, -1]].any() and not contact[:, [0, -1]].any()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda m: indent_bem("cone", m, 1.0), "profile must be a gap"),
        (
            lambda m: indent_bem(PowerLawProfile(2, 1.0), 1e9, 1.0),
            "must be a half-space, got float",
        ),
        (lambda m: indent_bem(PowerLawProfile(2, 1.0), m, "deep"), "positive number or several"),
        (lambda m: indent_bem(PowerLawProfile(1, -1.0), m, 1.0), "does not rise to the approach"),
        (lambda m: indent_bem(PowerLawProfile(1, 0.0), m, 1.0), "does not rise to the approach"),
    ],
)
def test_what_is_no_contact_is_refused_in_one_sentence(call, words):
    with pytest.raises(InputError, match=words):
        call(HalfSpace.from_modulus(1.0))
