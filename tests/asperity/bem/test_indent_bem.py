"""`asperity.indent_bem`: load control, thin corners, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from asperity import HalfSpace, InputError, indent_bem
from surfaces import PowerLawProfile, shapes


def test_a_load_is_found_by_its_approach():
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


def _small(material):
    return indent_bem(PowerLawProfile(2, 1.0), material, 0.1, grid=16)


def _with_a_gap(r, phi):
    return np.where((phi > 1.0) & (phi < 1.2), np.nan, r**2)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda m: indent_bem("cone", m, 1.0), "profile must be a gap"),
        (
            lambda m: indent_bem(PowerLawProfile(2, 1.0), 1e9, 1.0),
            "HalfSpace is needed, not float",
        ),
        (lambda m: indent_bem(PowerLawProfile(2, 1.0), m, "deep"), "number or an array of numbers"),
        (lambda m: indent_bem(PowerLawProfile(1, -1.0), m, 1.0), "does not rise to the approach"),
        (lambda m: indent_bem(_with_a_gap, m, 1.0), "the gap .* of the profile is NaN at"),
        (lambda m: indent_bem(_with_a_gap, m, load=1.0), "the gap .* of the profile is NaN at"),
        (lambda m: indent_bem(lambda r, phi: [0.0] * 3, m, 1.0), r"profile has shape \(3,\)"),
        (lambda m: indent_bem(lambda r, phi: 1j * r, m, load=1.0), "array of numbers"),
        (lambda m: indent_bem(lambda r, phi: "deep", m, 1.0), "array of numbers"),
        (lambda m: indent_bem(PowerLawProfile(1, 0.0), m, 1.0), "does not rise to the approach"),
        (lambda m: _small(m).pressure(np.zeros(2), np.zeros(3)), r"shapes \(2,\) and \(3,\)"),
        (lambda m: _small(m).pressure("left", 0.0), "x is 'left'"),
        (lambda m: _small(m).contour("left"), "phi is 'left'"),
    ],
)
def test_what_is_no_contact_is_refused_in_one_sentence(call, words):
    with pytest.raises(InputError, match=words):
        call(HalfSpace.from_modulus(1.0))
