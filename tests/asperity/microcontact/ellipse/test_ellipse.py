"""The law about the optimal ellipse, on exact ellipses and against its own identities."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import gamma

from asperity import HalfSpace
from asperity.microcontact.ellipse.batch import tabulate
from asperity.microcontact.ellipse.ellipse_operator import edge_operator, monomials
from asperity.microcontact.hertz import elliptic_contact
from asperity.microcontact.law_table import LazyTable
from asperity.microcontact.ray_laws import tabulate_ritz
from surfaces import Profiles


def summits(gap, ratio, angle, edge, rays=16, nodes=17) -> Profiles:
    """Profiles of gap(x, y), x along the long axis, on elliptic basins of mean radius `edge`."""
    n = len(ratio)
    ratio = np.asarray(ratio, dtype=float)
    turn = 2 * np.pi * np.arange(rays) / rays
    aspect = np.maximum(ratio ** (-1 / 3), np.sqrt(1 / 8))[:, None]
    u, v = np.cos(turn) * np.ones((n, 1)), aspect * np.sin(turn)
    local = np.arctan2(v, u)
    weight = aspect / (u**2 + v**2)
    beta = ratio[:, None] ** -0.63
    length = edge / np.sqrt(beta * np.cos(local) ** 2 + np.sin(local) ** 2 / beta)
    t = np.linspace(0, 1, nodes)
    r = length[:, :, None] * t
    x, y = r * np.cos(local)[:, :, None], r * np.sin(local)[:, :, None]
    with np.errstate(invalid="ignore"):
        q = gap(x, y) / r**2
    curvature = np.stack([np.sqrt(ratio), 1 / np.sqrt(ratio)], axis=1)
    q[:, :, 0] = 0.5 * (
        curvature[:, :1] * np.sin(local) ** 2 + curvature[:, 1:] * np.cos(local) ** 2
    )
    zero = np.zeros(n)
    return Profiles(
        x=zero, y=zero, height=zero, curvature=curvature, angle=np.full(n, angle),
        phi=local + angle, weight=2 * np.pi * weight / weight.sum(axis=1, keepdims=True),
        edge=length, t=t, q=q, pixels=np.full(n, 1000), border=np.zeros(n, bool),
        valid=np.ones(n, bool), owner=np.arange(n),
    )  # fmt: skip


def paraboloids(ratio, angle=0.3, edge=1.0) -> Profiles:
    root = np.sqrt(np.asarray(ratio, dtype=float))[:, None, None]
    return summits(lambda x, y: 0.5 * (x**2 / root + root * y**2), ratio, angle, edge)


@pytest.mark.parametrize("m", [-0.5, -0.3, 0.0, 0.5, 0.8])
def test_exact_ellipses(m):
    """Force, stiffness and area of paraboloids up to a curvature ratio of 30, any grading."""
    ratio = np.array([1.0, 1.3, 2.0, 5.0, 12.0, 30.0])
    material = HalfSpace.from_modulus(3.0, m)
    table = tabulate(paraboloids(ratio), material)
    rows = np.repeat(np.arange(ratio.size), 9)
    approach = (table.reach[:, None] * np.linspace(0.005, 0.08, 9)).ravel()
    force, stiffness, area = table.evaluate(rows, approach)
    exact = elliptic_contact(np.sqrt(ratio[rows]), 1 / np.sqrt(ratio[rows]), approach, material)
    np.testing.assert_allclose(force, exact.force, rtol=1e-6)
    np.testing.assert_allclose(stiffness, exact.stiffness, rtol=1e-6)
    np.testing.assert_allclose(area, np.pi * exact.semi_minor * exact.semi_major, rtol=2e-6)


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_edge_operator_of_the_circle(m):
    """On the circle r**k cos(n phi) leaves the amplitude kappa_m(k + n) / pi cos(n phi)."""
    i, j = monomials(6)
    index = {(int(p), int(q)): r for r, (p, q) in enumerate(zip(i, j, strict=True))}
    rows = edge_operator(m, np.array([1.0]))[0]
    t = np.linspace(0, np.pi / 2, 7)

    def kappa(k):
        return gamma(k / 2 + 1) * gamma((1 + m) / 2) / gamma((k + m + 1) / 2)

    np.testing.assert_allclose(rows[0], 1 / np.pi, rtol=1e-12)
    three = rows[index[3, 0]] - 3 * rows[index[1, 2]]
    np.testing.assert_allclose(three, kappa(6) / np.pi * np.cos(3 * t), atol=1e-11)
    four = rows[index[4, 0]] + 2 * rows[index[2, 2]] + rows[index[0, 4]]
    np.testing.assert_allclose(four, kappa(4) / np.pi, rtol=1e-11)


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_edge_operator_of_the_exact_ellipse(m):
    """A paraboloid with its own ellipse leaves no edge singularity."""
    ratio = 7.0
    contact = elliptic_contact(
        np.sqrt(ratio), 1 / np.sqrt(ratio), 1.0, HalfSpace.from_modulus(1, m)
    )
    a, b = float(contact.semi_major), float(contact.semi_minor)
    rows = edge_operator(m, np.array([b / a]))[0]
    rest = rows[0] - 0.5 * (a**2 / np.sqrt(ratio) * rows[3] + b**2 * np.sqrt(ratio) * rows[5])
    assert np.abs(rest).max() < 1e-11


def test_profiles_turned_and_scaled():
    """Turning a profile changes nothing; lengths times s and heights times z scale the law."""

    def gap(x, y):
        return 0.3 * x**2 + 0.7 * y**2 + 0.2 * x**3 - 0.1 * x * y**2 + 0.3 * y**4

    one = summits(gap, [2.3], 0.1, 0.5)
    turned = replace(one, phi=one.phi + 0.9, angle=one.angle + 0.9)
    wide = replace(one, edge=1e3 * one.edge, q=one.q * 1e-9, curvature=one.curvature * 1e-9)
    material = HalfSpace.from_modulus(1.0)
    table, other, scaled = (tabulate(p, material) for p in (one, turned, wide))
    np.testing.assert_allclose(other.force, table.force, rtol=1e-12)
    np.testing.assert_allclose(scaled.reach, table.reach * 1e-3)
    np.testing.assert_allclose(scaled.force, table.force, rtol=1e-9)
    np.testing.assert_allclose(scaled.area, table.area * 1e6, rtol=1e-9)


@pytest.mark.parametrize("m", [-0.8, -0.4, 0.0, 0.6])
@pytest.mark.parametrize("make", [tabulate, tabulate_ritz])
def test_a_paraboloid_fills_its_basin_in_any_grading(make, m):
    """Under a hardness the area of a law is its bearing area, which grows up to that of the basin:
    tables that ended at (1 + m) of it left much of the load of soft bodies out."""
    table = make(paraboloids([1.0, 10.0]), HalfSpace.from_modulus(1.0, m))
    assert table.area[0, -1] == pytest.approx(np.pi, rel=2e-3)
    assert table.area[1, -1] > 0.75 * np.pi


def test_table_is_monotone_and_fills_the_basin():
    """Force, stiffness and area rise with the approach; the area ends at the basin's."""
    profiles = paraboloids([1.0, 3.0, 10.0])
    table = tabulate(profiles, HalfSpace.from_modulus(1.0))
    for values in (table.force, table.stiffness, table.area):
        assert np.all(np.diff(values, axis=1) >= -1e-12 * values[:, -1:])
    basin = 0.5 * np.sum(profiles.weight * profiles.edge**2, axis=1)
    np.testing.assert_allclose(table.area[:, -1], basin, rtol=2e-3)
    assert np.all(table.area <= basin[:, None] * (1 + 1e-12))


def test_irregular_basins_keep_the_stiffness_rising():
    """Rays of random lengths: force convex, stiffness and area rising, at any filling."""
    rng = np.random.default_rng(4)
    one = paraboloids(rng.uniform(1, 8, 40))
    edge = one.edge * rng.uniform(0.3, 1.5, one.edge.shape)
    table = tabulate(replace(one, edge=edge), HalfSpace.from_modulus(1.0))
    for values in (table.force, table.stiffness, table.area):
        assert np.all(np.diff(values, axis=1) >= -1e-12 * values[:, -1:])
    secant = np.diff(table.force, axis=1) / np.diff(table.approach(), axis=1)
    assert np.all(table.stiffness[:, 1:] >= secant * (1 - 1e-12))


def test_centre_leaves_a_low_saddle():
    """A basin that ends near the summit on one side pushes the contact to the other side."""
    one = paraboloids([1.0], angle=0.7)
    edge = one.edge.copy()
    edge[0, :3] *= 0.3
    edge[0, -2:] *= 0.3
    table = tabulate(replace(one, edge=edge), HalfSpace.from_modulus(1.0))
    assert table.centre is not None
    along = table.centre[0] @ np.array([np.cos(0.7), np.sin(0.7)])
    across = table.centre[0] @ np.array([-np.sin(0.7), np.cos(0.7)])
    assert along[-1] < -0.1 and np.abs(across).max() < 0.02
    ends = table.reach[0] * np.array([0.0, 4.0])
    x, y = LazyTable.of(table).centre_at(np.array([0, 0]), ends)
    np.testing.assert_allclose([x, y], table.centre[0, [0, -1]].T, atol=1e-15)
