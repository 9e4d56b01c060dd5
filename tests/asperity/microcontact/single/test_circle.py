"""The laws about the circle where their expansion has no meaning."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
from asperity import HalfSpace
from asperity.errors import Flag
from asperity.microcontact.single.basis import TableBasis, turning_radius
from surfaces import PolarProfile

R, PHI = np.linspace(0.0, 1.0, 17), np.pi / 16 * np.arange(32)
SHELF = np.where(R < 0.5, R**2, 0.25 + 0.02 * (R - 0.5) + 3 * np.maximum(R - 0.6, 0.0) ** 2)
ROUGH = 1 + 0.2 * np.cos(2 * PHI) + 0.1 * np.cos(3 * PHI)


def doubtful(one):
    return (one.flags & np.uint8(Flag.CONTOUR_DOUBTFUL)) > 0


@pytest.mark.parametrize("law", ["harmonic", "auto", "paper"])
@pytest.mark.parametrize("m", [-0.3, 0.0, 0.3])
def test_a_shelf_beside_the_contact_is_told(law, m):
    """It bears before the contact grows to it: boundary elements have 12 % more force at 0.44."""
    table = PolarProfile(R, PHI, np.outer(SHELF, ROUGH))
    basis = TableBasis(table, m)
    depth = basis.depth(np.array([0.3, 0.98 * turning_radius(basis)]))
    one = asperity.indent(table, HalfSpace.from_modulus(1.0, m), depth, law=law)
    assert doubtful(one).tolist() == [False, True]
    assert np.isnan(one.error_estimate).tolist() == [False, True]
    assert np.all(one.stiffness > 0)


def test_a_shelf_is_told_from_where_it_bears():
    """Boundary elements agree within 1e-5 up to 0.36, and have 8 % more force at 0.42."""
    table = PolarProfile(R, PHI, np.outer(SHELF, np.ones(32)))
    one = asperity.indent(table, HalfSpace.from_modulus(1.0), [0.36, 0.42])
    assert doubtful(one).tolist() == [False, True]


def test_the_second_order_is_bounded_and_told_beside_the_nodes_of_a_table():
    """There f'' jumps: stiffnesses were -3 times those of the circle."""
    table = PolarProfile(R, PHI, np.outer(SHELF, ROUGH))
    a = (R[1:10, None] * (1 + np.array([1e-6, 1e-4, 1e-3]))).ravel()
    one = asperity.indent(table, HalfSpace.from_modulus(1.0), TableBasis(table, 0.0).depth(a))
    known = np.isfinite(one.radius)
    for share in (one.contact_area / (np.pi * one.radius**2), one.stiffness / (2 * one.radius)):
        assert np.all((share[known] > 0.5 - 1e-12) & (share[known] < 2 + 1e-12))
        assert np.all(doubtful(one)[known] | (np.abs(share[known] - 1) < 0.3))
