"""The compiled parts of the batched ellipse law against slow reference implementations."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from scipy.integrate import trapezoid
from scipy.interpolate import CubicHermiteSpline
from scipy.linalg import solve

from asperity.halfspace.influence import near_influence
from asperity.halfspace.transforms import edge_weights
from asperity.microcontact.ellipse import (
    _basin_kernels,
    _contour_kernels,
    _fit_kernels,
    _table_kernels,
)
from asperity.microcontact.ellipse._ellipse_kernels import SHAPE, STATES
from asperity.microcontact.ellipse.batch import (
    LEVELS,
    _along_rays,
    _fit_rules,
    _resampling,
    _rules,
    _stencils,
)
from asperity.microcontact.ellipse.ellipse_operator import monomials
from surfaces.numerics.lanes import LANES, groups, load, splat, store

RNG = np.random.default_rng(7)
POWERS = np.stack(monomials(6))


def lanes(values):
    """An array of one profile as groups of eight equal ones."""
    return np.repeat(np.asarray(values, dtype=float).ravel(), LANES)


@njit
def _places(x, y, out):
    store(out, 0, _contour_kernels.place(load(x, 0), load(y, 0), 16))


def test_place_of_a_direction_without_arctangent():
    for angle in RNG.uniform(0, 2 * np.pi, (25, LANES)):
        found = np.empty(LANES)
        _places(3 * np.cos(angle), 3 * np.sin(angle), found)
        np.testing.assert_allclose(found, angle * 16 / (2 * np.pi), atol=3e-4)


@njit
def _moved(x0, y0, turn, out):
    _fit_kernels.move(splat(x0), splat(y0), splat(np.sin(turn)), splat(np.tan(0.5 * turn)), out)


def test_polynomials_moved():
    """Values at points are those of the polynomial before, in the moved frame."""
    coefs, (x0, y0, turn) = RNG.normal(size=(LANES, POWERS.shape[1])), (0.3, -0.2, 0.4)
    out = coefs.T.copy().ravel()
    _moved(x0, y0, turn, out)
    moved = out.reshape(-1, LANES).T
    for x, y in RNG.normal(size=(5, 2)):
        u = x0 + np.cos(turn) * x - np.sin(turn) * y
        v = y0 + np.sin(turn) * x + np.cos(turn) * y
        expected = coefs @ (u ** POWERS[0] * v ** POWERS[1])
        np.testing.assert_allclose(moved @ (x ** POWERS[0] * y ** POWERS[1]), expected)


def test_small_systems():
    matrix = RNG.normal(size=(LANES, 5, 9))
    matrix = matrix @ np.swapaxes(matrix, 1, 2)
    right = RNG.normal(size=(LANES, 5))
    expected = np.linalg.solve(matrix, right[..., None])[..., 0]
    vector = right.T.copy().ravel()
    _contour_kernels.solve(np.triu(matrix).reshape(LANES, -1).T.copy().ravel(), vector)
    np.testing.assert_allclose(vector.reshape(5, LANES).T, expected)


@njit
def _fit(q, nodes, edge, height, reach, wide, rules, number, out):
    scale = splat(0.25 / height)
    _fit_kernels.fit(q, nodes, edge, scale, reach, wide, rules, number, out)


def test_nested_fits_find_a_polynomial():
    """f of degree 4 on stretched rays comes back from every nested fit."""
    (skews, fitting), rays, nodes = _fit_rules(16), 16, 17
    number, degree = 20, POWERS.sum(axis=0)
    coefs = np.where((degree >= 2) & (degree <= 4), RNG.normal(size=POWERS.shape[1]), 0.0)
    aspect = 0.7
    turn = 2 * np.pi * np.arange(rays) / rays
    direction = np.stack([np.cos(turn), aspect * np.sin(turn)])
    direction /= np.hypot(*direction)
    wide = np.array([1.0, aspect / skews[number]])
    wide /= np.sqrt(wide.prod())
    reach = 0.9 / np.hypot(*(direction / wide[:, None]))
    edge = 1.2 * reach
    r = edge[:, None] * np.linspace(0, 1, nodes)
    x, y = direction[0, :, None], direction[1, :, None]
    q = sum(c * x**i * y**j * r ** (i + j - 2) for c, i, j in zip(coefs, *POWERS, strict=True) if c)
    out = np.zeros(_fit_kernels.NESTED_FITS * POWERS.shape[1] * LANES)
    _fit(lanes(q), nodes, lanes(edge), 2.0, lanes(reach), lanes(1 / wide), fitting, number, out)
    found = out.reshape(_fit_kernels.NESTED_FITS, -1, LANES)[..., 6]
    length = 0.9
    expected = coefs * length**degree / 2.0
    np.testing.assert_allclose(found, np.tile(expected, (len(found), 1)), atol=1e-7)


@njit
def _fill(q, nodes, weights, weight, direction, edge, rays, scale, levels, m, punch, out, shape):
    _basin_kernels.fill(
        q, nodes, weights, weight, direction, edge, rays, splat(scale), shape, splat(-1.0), levels,
        m, punch, out,
    )  # fmt: skip


def _filled(q, weights, weight, direction, edge, levels, m):
    """Planforms of one profile without a trusted contour, unit of q 0.3."""
    rays, nodes = q.shape
    _, punch, _ = _rules(m, rays, nodes)[-1]
    out = np.zeros(levels.size * 4 * LANES)
    _fill(
        lanes(q), nodes, weights, lanes(weight), lanes(direction), lanes(edge), rays, 0.3, levels,
        m, punch, out, groups(SHAPE),
    )  # fmt: skip
    return out.reshape(levels.size, 4, LANES)[..., 3]


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_the_operator_along_rays_knows_paraboloids(m):
    """q = const gives the approach q a^2 2 / (1 + m), at every radius."""
    found = _along_rays(m, 17) @ np.full(17, 0.7)
    np.testing.assert_allclose(found, 0.7 * 2 / (1 + m), rtol=1e-10)


def test_basins_fill_ray_by_ray():
    """Each ray stops where the root of its edge operator next reaches that of the approach."""
    rays, nodes, m = 16, 17, 0.0
    q = 0.5 + RNG.uniform(0, 1, (rays, 1)) * np.cos(np.linspace(0, 3, nodes)) ** 2
    edge = RNG.uniform(0.4, 1.0, rays)
    turn = 2 * np.pi * np.arange(rays) / rays
    direction = np.stack([np.cos(turn), np.sin(turn)])
    levels = LEVELS
    weights = np.ascontiguousarray(edge_weights(m, nodes, 0).T)
    weight = np.full(rays, 2 * np.pi / rays)
    out = _filled(q, weights, weight, direction, edge, levels, m)
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


@njit
def _expanded(*given):
    _table_kernels.expanded_levels(*given)


def test_slopes_at_the_trusted_levels():
    """F = u^3 times a quartic: exact stiffness at every level, whatever levels are trusted."""
    levels, p = LEVELS, 3.0
    poly = np.polynomial.Polynomial([1.0, -0.4, 0.3, 0.2, -0.1])
    state = np.zeros((levels.size, STATES))
    state[:, 0] = levels**p * poly(levels)
    state[:, 3:5] = 1.0
    columns = np.zeros((5, levels.size))
    first, last = 2, 11
    _expanded(state, 2, 11, levels, levels**p, _stencils(), p, columns)
    exact = 0.5 * levels ** (p - 2) * (p * poly(levels) + levels * poly.deriv()(levels))
    inside = slice(first, last)
    np.testing.assert_allclose(columns[1, inside], exact[inside], rtol=1e-10)
    assert columns[1, last] == pytest.approx(exact[last], rel=2e-2)
    np.testing.assert_allclose(columns[0, first:last], state[first:last, 0])
    np.testing.assert_allclose(columns[0, 0] / columns[0, 1], (levels[0] / levels[1]) ** p)


@njit
def _planform(radius, weight, direction, rays, m, punch, out):
    _basin_kernels._planform(radius, weight, direction, rays, m, punch, out, 0)


def shape_on_rays(outline, ratio, m, rays=16):
    """Stiffness of a planform of modulus 1 over area^(p/2), from rays stretched along x."""
    t = np.arange(rays) * 2 * np.pi / rays
    x, y = ratio * np.cos(t) * outline(t), np.sin(t) * outline(t)
    weight = 2 * np.pi / rays * ratio / (ratio**2 * np.cos(t) ** 2 + np.sin(t) ** 2)
    radius = np.hypot(x, y)
    direction = np.concatenate((x / radius, y / radius))
    out = np.zeros(4 * LANES)
    punch = _rules(m, rays, 17)[-1][1]
    _planform(lanes(radius), lanes(weight), lanes(direction), rays, m, punch, out)
    area, stiffness = out.reshape(4, LANES)[:2, 0]
    return stiffness / area ** (0.5 + 0.5 * m)


def shape_of_elements(outline, ratio, m, cells=19):
    """`shape_on_rays` up to a factor, by elements about as long as wide once shrunk."""
    place = (np.arange(-2 * cells, 2 * cells + 1) + 0.13) / cells
    y, x = np.meshgrid(place, place, indexing="ij")
    inside = np.argwhere(np.hypot(x, y) < outline(np.arctan2(y, x)))
    influence = near_influence((place.size,) * 2, (1.0, ratio), m)
    far = np.abs(inside[:, None] - inside[None])
    pressure = solve(influence[far[..., 0], far[..., 1]], np.ones(len(inside)), assume_a="pos")
    return pressure.sum() / len(inside) ** (0.5 + 0.5 * m)


@pytest.mark.parametrize("m", [-0.3, 0.0])
@pytest.mark.parametrize(("ratio", "lobes"), [(1.0, 3), (1.0, 4), (2.0, 3)])
def test_lobes_stiffen_a_planform(m, ratio, lobes):
    """By (1 - m^2)/4 (n - 1) e^2 at equal area, to second order, on circles and on ellipses."""
    deep = 0.25
    ours, exact = (
        shape(lambda t: 1 + deep * np.cos(lobes * t), ratio, m) / shape(np.ones_like, ratio, m) - 1
        for shape in (shape_on_rays, shape_of_elements)
    )
    assert ours == pytest.approx((1 - m * m) / 4 * (lobes - 1) * deep**2, rel=0.1)
    assert ours == pytest.approx(exact, rel=0.25)


def test_ellipses_have_no_lobes():
    """Wherever the rays begin."""
    level = shape_on_rays(np.ones_like, 2.0, 0.0)
    assert level == pytest.approx(shape_on_rays(lambda t: 3.0 + 0 * t, 2.0, 0.0))
    assert shape_on_rays(np.ones_like, 1.0, 0.0) == pytest.approx(2 / np.sqrt(np.pi), rel=1e-4)

    def shifted(t):
        return np.sqrt(1 - (0.2 * np.sin(t)) ** 2) - 0.2 * np.cos(t)

    assert shape_on_rays(shifted, 2.0, 0.0) == pytest.approx(level, rel=2e-3)


@njit
def _carried(*given):
    _table_kernels.carried_on(*given)


def test_planforms_carry_the_contact_on():
    """Beyond the trusted levels: areas scaled where both meet, stiffness and its integral."""
    levels, p, last, basin = LEVELS, 3.0, 6, 1.0
    n = levels.size
    columns = np.zeros((5, n))
    columns[0], columns[1], columns[2] = 0.6 * levels**3, 0.9 * levels, 0.9 * levels**2
    filling = np.zeros((n, 4))
    filling[:, 0], filling[:, 1] = np.minimum(1.1 * levels**2, basin), 0.8 * levels
    expected = columns.copy()
    fade = np.clip((basin - filling[:, 0]) / (basin - filling[last, 0]), 0, 1)
    spread = columns[2, last] / filling[last, 0]
    for i in range(last + 1, n):
        expected[1, i] = max(filling[i, 1], expected[1, i - 1])
        expected[2, i] = min(filling[i, 0] * spread ** fade[i], basin)
        u = np.linspace(levels[i - 1], levels[i], 4001)
        k = np.interp(u, levels[i - 1 : i + 1], expected[1, i - 1 : i + 1])
        expected[0, i] = expected[0, i - 1] + trapezoid(k, u**2)
    _carried(filling, last, levels, basin, p, columns)
    np.testing.assert_allclose(columns[:3], expected[:3], rtol=1e-6)


def test_rows_are_hermite_and_convex():
    """Smooth convex input comes back as its Hermite spline; falling secants are lifted."""
    levels, p = LEVELS, 3.0
    rules = _resampling(p)
    u = rules[0]
    columns = np.zeros((5, levels.size))
    s = 1 + 0.2 * levels
    columns[0], columns[2] = levels**p * s, levels**2
    columns[1] = 0.5 * levels ** (p - 2) * (p * s + levels * 0.2)
    made = np.zeros((4, u.size))
    _table_kernels.resampled(columns, levels, levels**p, rules, p, made)
    spline = CubicHermiteSpline(levels, s, np.full(levels.size, 0.2))
    np.testing.assert_allclose(made[0], spline(u) * u**p, rtol=1e-10)
    np.testing.assert_allclose(made[2], u**2, rtol=1e-10)
    columns[0, -3] *= 0.8
    _table_kernels.resampled(columns, levels, levels**p, rules, p, made)
    secant = np.diff(made[0], prepend=0.0) / np.diff(u**2, prepend=0.0)
    assert (np.diff(secant) >= -1e-12).all()
    assert (made[1] >= secant - 1e-12).all()
