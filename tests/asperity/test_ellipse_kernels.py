"""The compiled parts of the batched ellipse law beside slow and obvious twins."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from asperity.microcontact import _basin_kernels, _fit_kernels, _polynomial_kernels, _row_kernels
from asperity.microcontact._directions import place
from asperity.microcontact.ellipse_batch import _resampling, _rules, _stencils, levels_of
from asperity.microcontact.ellipse_tables import monomials
from asperity.microcontact.fit import fit_rules
from asperity.microcontact.ray_moments import edge_weights

RNG = np.random.default_rng(7)
POWERS = np.stack(monomials(6))


def test_place_of_a_direction_without_arctangent():
    angle = RNG.uniform(0, 2 * np.pi, 200)
    found = [place(3 * np.cos(a), 3 * np.sin(a), 16) for a in angle]
    np.testing.assert_allclose(found, angle * 16 / (2 * np.pi), atol=3e-4)


def test_polynomials_moved():
    """Values at points are those of the polynomial before, in the moved frame."""
    coefs, (x0, y0, turn) = RNG.normal(size=POWERS.shape[1]), (0.3, -0.2, 0.4)
    moved = coefs.copy()
    _polynomial_kernels.move(x0, y0, turn, moved)
    for x, y in RNG.normal(size=(5, 2)):
        u = x0 + np.cos(turn) * x - np.sin(turn) * y
        v = y0 + np.sin(turn) * x + np.cos(turn) * y
        assert moved @ (x ** POWERS[0] * y ** POWERS[1]) == pytest.approx(
            coefs @ (u ** POWERS[0] * v ** POWERS[1])
        )


def test_small_system():
    matrix = RNG.normal(size=(5, 9))
    matrix = matrix @ matrix.T
    right = RNG.normal(size=5)
    expected = np.linalg.solve(matrix, right)
    _polynomial_kernels.solve(np.triu(matrix), right)
    np.testing.assert_allclose(right, expected)


def test_nested_fits_find_a_polynomial():
    """f of degree 4 on stretched rays comes back from every nested fit."""
    rules, rays, nodes = fit_rules(16), 16, 17
    number, degree = 20, POWERS.sum(axis=0)
    coefs = np.where((degree >= 2) & (degree <= 4), RNG.normal(size=POWERS.shape[1]), 0.0)
    aspect = 0.7
    turn = 2 * np.pi * np.arange(rays) / rays
    direction = np.stack([np.cos(turn), aspect * np.sin(turn)])
    direction /= np.hypot(*direction)
    wide = np.array([1.0, aspect / rules.skew[number]])
    wide /= np.sqrt(wide.prod())
    reach = 0.9 / np.hypot(*(direction / wide[:, None]))
    edge = 1.2 * reach
    r = edge[:, None] * np.linspace(0, 1, nodes)
    x, y = direction[0, :, None], direction[1, :, None]
    q = sum(c * x**i * y**j * r ** (i + j - 2) for c, i, j in zip(coefs, *POWERS, strict=True) if c)
    found = np.zeros((_fit_kernels.FITS, POWERS.shape[1]))
    space = _fit_kernels.fit_space(
        rays, rules.radii.size, rules.matrices.shape[2], rules.matrices.shape[3]
    )
    _fit_kernels.fit_one(
        q, edge, 2.0, reach, wide, rules.radii, rules.rings, rules.image, rules.matrices[number],
        rules.members, rules.count, found, space,
    )  # fmt: skip
    length = 0.9
    expected = coefs * length**degree / 2.0
    np.testing.assert_allclose(found, np.tile(expected, (len(found), 1)), atol=1e-7)


def test_basins_fill_ray_by_ray():
    """Each ray stops where the root of its edge operator next reaches that of the approach."""
    rays, nodes, m = 16, 17, 0.0
    q = 0.5 + RNG.uniform(0, 1, (rays, 1)) * np.cos(np.linspace(0, 3, nodes)) ** 2
    edge = RNG.uniform(0.4, 1.0, rays)
    turn = 2 * np.pi * np.arange(rays) / rays
    direction = np.stack([np.cos(turn), np.sin(turn)])
    levels = levels_of(24)
    weights = np.ascontiguousarray(edge_weights(m, nodes, 0).T)
    *_, punch, _ = _rules(m, rays, nodes, 24)
    (_, start, inverse) = _rules(m, rays, nodes, 24)[2]
    out, shape = np.zeros((levels.size, 4)), np.zeros((levels.size, 33))
    space = _basin_kernels.basin_space(rays, weights.shape[1])
    weight = np.full(rays, 2 * np.pi / rays)
    _basin_kernels.fill_one(
        q, weights, weight, direction, edge, 0.3, shape, -1, levels, m, punch, start, inverse, out,
        space,
    )  # fmt: skip
    x = np.linspace(0, 1, weights.shape[1])
    fine = np.linspace(0, 1, 200_001)
    for level, row in zip(levels, out, strict=True):
        radius = np.empty(rays)
        for p in range(rays):
            root = x * edge[p] * np.sqrt(0.3 * (q[p] @ weights))
            beyond = np.interp(fine, x, root) >= level
            radius[p] = edge[p] * fine[np.argmax(beyond)] if beyond.any() else edge[p]
        hertz = np.minimum(level * np.sqrt(0.5 / (0.3 * q[:, 0])), edge)
        radius = np.maximum(radius, np.minimum(hertz, radius) if level > levels[0] else hertz)
        if level > levels[0]:
            assert row[0] == pytest.approx(0.5 * weight @ radius**2, rel=2e-2)
            centre = direction @ (weight * radius**3) / 3 / (0.5 * weight @ radius**2)
            np.testing.assert_allclose(row[2:], centre, atol=1e-2)
    assert out[-1, 0] == pytest.approx(0.5 * weight @ edge**2)
    assert (np.diff(out[:, 0]) >= 0).all()


def test_slopes_at_the_trusted_levels():
    """F = u^3 times a quartic: exact stiffness at every level, whatever levels are trusted."""
    levels, p = levels_of(24), 3.0
    poly = np.polynomial.Polynomial([1.0, -0.4, 0.3, 0.2, -0.1])
    state = np.zeros((levels.size, 10))
    state[:, 0] = levels**p * poly(levels)
    state[:, 3:5] = 1.0
    columns = np.zeros((5, levels.size))
    first, last = 2, 11
    _row_kernels.expanded_levels(state, first, last, levels, levels**p, _stencils(24), p, columns)
    exact = 0.5 * levels ** (p - 2) * (p * poly(levels) + levels * poly.deriv()(levels))
    inside = slice(first, last)
    np.testing.assert_allclose(columns[1, inside], exact[inside], rtol=1e-10)
    assert columns[1, last] == pytest.approx(exact[last], rel=2e-2)
    np.testing.assert_allclose(columns[0, first:last], state[first:last, 0])
    np.testing.assert_allclose(columns[0, 0] / columns[0, 1], (levels[0] / levels[1]) ** p)


def test_planforms_carry_the_contact_on():
    """Beyond the trusted levels: the filling, scaled where both meet, and its integral."""
    levels, p, last, basin = levels_of(24), 3.0, 6, 1.0
    n = levels.size
    columns = np.zeros((5, n))
    columns[0], columns[1], columns[2] = 0.6 * levels**3, 0.9 * levels, 0.9 * levels**2
    filling = np.zeros((n, 4))
    filling[:, 0], filling[:, 1] = np.minimum(1.1 * levels**2, basin), 0.8 * levels
    expected = columns.copy()
    fade = np.clip((basin - filling[:, 0]) / (basin - filling[last, 0]), 0, 1)
    stiff = columns[1, last] / filling[last, 1]
    spread = columns[2, last] / filling[last, 0]
    for i in range(last + 1, n):
        expected[1, i] = filling[i, 1] * stiff ** fade[i]
        expected[2, i] = min(filling[i, 0] * spread ** fade[i], basin)
        u = np.linspace(levels[i - 1], levels[i], 4001)
        k = np.interp(u, levels[i - 1 : i + 1], expected[1, i - 1 : i + 1])
        expected[0, i] = expected[0, i - 1] + np.trapezoid(k, u**2)
    _row_kernels.carried_on(filling, last, levels, basin, p, columns)
    np.testing.assert_allclose(columns[:3], expected[:3], rtol=1e-6)


def test_rows_are_hermite_and_convex():
    """Smooth convex input comes back as its Hermite spline; falling secants are lifted."""
    levels, p = levels_of(24), 3.0
    u, place_, hermite = _resampling(24)
    columns = np.zeros((5, levels.size))
    s = 1 + 0.2 * levels
    columns[0], columns[2] = levels**p * s, levels**2
    columns[1] = 0.5 * levels ** (p - 2) * (p * s + levels * 0.2)
    made = np.zeros((4, u.size))
    _row_kernels.resampled(columns, levels, levels**p, place_, hermite, u, p, made)
    spline = CubicHermiteSpline(levels, s, np.full(levels.size, 0.2))
    np.testing.assert_allclose(made[0], spline(u) * u**p, rtol=1e-10)
    np.testing.assert_allclose(made[2], u**2, rtol=1e-10)
    columns[0, -3] *= 0.8
    _row_kernels.resampled(columns, levels, levels**p, place_, hermite, u, p, made)
    secant = np.diff(made[0], prepend=0.0) / np.diff(u**2, prepend=0.0)
    assert (np.diff(secant) >= -1e-12).all()
    assert (made[1] >= secant - 1e-12).all()
