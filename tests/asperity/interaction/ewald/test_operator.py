"""The fast interaction against dense exact sums; symmetry, definiteness, self-images."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import dense_matrix, periodic_interaction, self_image

from asperity.halfspace.footprint import OUTSIDE_SHARE, Footprints
from asperity.interaction.ewald.mesh import Mesh
from asperity.interaction.ewald.near_pairs import CHEAP_PAIRS, CUT_OVER_SPLIT_LENGTH, CUT_RATIO
from asperity.interaction.ewald.operator import Interaction
from asperity.interaction.ewald.tangent import Tangent

CELL = (1.0, 1.7)


def scene(n, m, seed, filling=0.5):
    """Random overlapping discs: places, stiffness; radii fill `filling` of the cell on average."""
    rng = np.random.default_rng(seed)
    y, x = rng.uniform(0, CELL[0], n), rng.uniform(0, CELL[1], n)
    radius = rng.uniform(0.3, 1.0, n)
    radius *= np.sqrt(filling * CELL[0] * CELL[1] / (np.pi * np.sum(radius**2)))
    return y, x, 2 * radius ** (1 + m) / (1 + m)


def tangent_matrices(y, x, k, m, boundary):
    """Tangent of the fast plan column by column, and its exact twin, scaled by sqrt(k)."""
    f = Footprints(1.0, m)
    plan = Interaction(y, x, CELL, boundary, f, widest=f.variance(k).max())
    k, n = k[plan.order], len(k)
    tangent = Tangent(plan, np.ones(n, bool), k)
    fast = np.array([tangent(e) for e in np.eye(n)])
    v = f.variance(k)
    exact = dense_matrix(y[plan.order], x[plan.order], v, CELL, boundary, f)
    exact[np.diag_indices(n)] += OUTSIDE_SHARE / (1 + OUTSIDE_SHARE) / k
    scale = np.sqrt(k)
    return fast * scale * scale[:, None], exact * scale * scale[:, None]


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
@pytest.mark.parametrize("filling", [0.2, 0.6, 1.2])
def test_tangent_is_positive_definite_for_overlapping_discs(m, boundary, filling):
    y, x, k = scene(110, m, 3, filling)
    fast, exact = tangent_matrices(y, x, k, m, boundary)
    assert np.linalg.eigvalsh(exact)[0] >= OUTSIDE_SHARE / (1 + OUTSIDE_SHARE) * (1 - 1e-6)
    assert np.linalg.eigvalsh(0.5 * (fast + fast.T))[0] >= 0.98 * OUTSIDE_SHARE / (
        1 + OUTSIDE_SHARE
    )
    assert np.abs(fast - exact).max() < 5e-3
    assert np.abs(fast - fast.T).max() < 1e-6


@pytest.mark.parametrize("precision", [np.float32, np.float64])
@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("size", [(4.0, 4.0), (3.1, 7.9), (24.0, 20.0)])
def test_products_of_matrices_are_the_transforms(size, periodic, precision, monkeypatch):
    short = Mesh(Footprints(2.0, 0.3), size, periodic, 1.7, precision)
    monkeypatch.setattr("asperity.interaction.ewald.mesh._lengths", lambda *_: short.shape)
    monkeypatch.setattr("asperity.interaction.ewald.mesh.MATRIX_NODES", 0)
    transformed = Mesh(Footprints(2.0, 0.3), size, periodic, 1.7, precision)
    assert short.waves and not transformed.waves
    masses = np.random.default_rng(0).normal(size=short.shape).astype(precision)
    expected = transformed.convolve(masses)
    error = np.abs(short.convolve(masses) - expected).max() / np.abs(expected).max()
    assert error < 20 * np.finfo(precision).eps


@pytest.mark.parametrize("unit", [1.0, 1e-6])
def test_plans_of_one_cell_share_their_mesh(unit):
    """As loads grow, cut-offs near to each other, in any unit of length."""
    plans = []
    for n in (180, 200, 220):
        y, x = unit * np.random.default_rng(n).uniform(0, 1, (2, n))
        plans.append(Interaction(y, x, (unit, unit), "periodic", Footprints(1.0)))
    reach = np.array([plan.eta * CUT_OVER_SPLIT_LENGTH for plan in plans]) / unit
    assert len({id(plan.mesh) for plan in plans}) == len(set(reach)) < 3
    wanted = np.sqrt(CHEAP_PAIRS / np.pi) / np.array([180, 200, 220])
    assert (np.abs(np.log(reach / wanted)) <= 0.5 * np.log(CUT_RATIO) + 1e-12).all()


def test_shared_cut_offs_stay_above_the_widest_footprint():
    y, x = np.random.default_rng(1).uniform(0, 1, (2, 400))
    for root in np.linspace(0.01, 0.05, 9):
        plan = Interaction(y, x, (1.0, 1.0), "periodic", Footprints(1.0), widest=root**2)
        assert plan.eta >= 3.0 * root


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
@pytest.mark.parametrize("x", [(0.2, 1.4), (0.1, 0.7, 1.0, 1.6)])
def test_aligned_points_of_a_free_surface_do_not_act_on_themselves(x, m):
    """The rectangle about them has no area, from which a near distance could follow."""
    x, y = np.array(x), np.full(len(x), 0.3)
    f = Footprints(3.0, m)
    v = f.variance(f.punch(np.linspace(0.02, 0.08, len(x))))
    plan = Interaction(y, x, CELL, "free", f)
    field = np.array([plan.field(e, v[plan.order]).value for e in np.eye(len(x))])
    dense = dense_matrix(y, x, v, CELL, "free", f)[plan.order][:, plan.order]
    own = np.diag(dense).copy()
    np.fill_diagonal(dense, 0.0)
    assert np.abs(field - dense).max() < 2e-3 * own.min()


@pytest.mark.parametrize("m", [-0.4, 0.0, 0.4])
def test_few_points_of_a_free_surface_act_as_exactly_as_many(m):
    """Errors of the mesh, up to 1.9 % of two and 0.5 % of three, do not average out among few."""
    f = Footprints(1.0, m)
    for seed in range(40):
        y, x, k = scene(2 + seed % 4, m, seed, 0.001)
        plan = Interaction(y, x, CELL, "free", f, widest=f.variance(k).max())
        y, x, v = y[plan.order], x[plan.order], f.variance(k)[plan.order]
        apart = np.hypot(y - y[:, None], x - x[:, None])
        exact = dense_matrix(y, x, v, CELL, "free", f)
        exact[apart == 0.0] = 0.0
        found = plan.field(np.ones(len(y)), v).value
        np.testing.assert_allclose(found, exact.sum(axis=1), rtol=1.5e-3)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_moved_points_act_from_where_they_stand(boundary):
    """Also across the border of a cell that repeats."""
    y, x, k = scene(300, 0.0, 5)
    inner = (y > 0.1) & (y < 0.9) & (x > 0.1) & (x < 1.6)
    f = Footprints(1.0, 0.0)
    v = f.variance(k)
    plan = Interaction(y, x, CELL, boundary, f, widest=v.max())
    away = np.random.default_rng(6).uniform(-0.4, 0.4, (2, len(y))) * np.sqrt(v)
    if boundary == "free":
        away[:, ~inner] = 0.0
    moved = plan.moved(*away[:, plan.order])
    new = Interaction(y + away[0], x + away[1], CELL, boundary, f, widest=v.max())
    force = np.random.default_rng(7).uniform(0.0, 1.0, len(y))
    field, wanted = np.empty((2, len(y), 4))
    for found, p in ((field, moved), (wanted, new)):
        got = p.field(force[p.order], v[p.order], np.zeros(len(y)), np.zeros((len(y), 2)))
        found[p.order] = np.column_stack((got.value, got.slope, got.tilt))
    scale = wanted.std(axis=0)
    assert (np.abs(field - wanted) < 0.02 * scale).all()


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_field_is_the_dense_sum(m, boundary):
    y, x, k = scene(110, m, 5)
    f = Footprints(3.0, m)
    v = 0.6 * f.variance(3.0 * k)
    force = np.random.default_rng(1).uniform(0, 1, len(y))
    dense = dense_matrix(y, x, v, CELL, boundary, f)
    np.fill_diagonal(dense, dense.diagonal() - f.self_factor * v ** (-(1 + m) / 2))
    plan = Interaction(y, x, CELL, boundary, f)
    value = plan.field(force[plan.order], v[plan.order]).value
    size = np.abs(dense).sum(1).mean()
    assert np.abs(value - (dense @ force)[plan.order]).max() < 2e-3 * size
    step = 1e-3 * v.mean()
    wider = v.copy()
    wider[:50] += step
    moved = dense_matrix(y, x, wider, CELL, boundary, f) - dense_matrix(y, x, v, CELL, boundary, f)
    own = f.self_factor * (wider ** (-(1 + m) / 2) - v ** (-(1 + m) / 2))
    moved[np.diag_indices(len(v))] -= own
    moved[:50, :50] = np.nan
    rows = np.arange(50)
    wanted = moved[rows][:, 50:] @ force[50:] / step
    force[:50] = 0.0
    slope = plan.field(force[plan.order], v[plan.order]).slope
    back = np.empty(len(v))
    back[plan.order] = slope
    np.testing.assert_allclose(back[rows], wanted, atol=0.02 * np.abs(wanted).max())


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize(
    ("n", "widest"), [(5, 0.0), (40, 0.0), (150, 0.0), (700, 0.0), (700, 4e-4), (700, 2e-3)]
)
def test_near_pairs_are_all_pairs_within_the_cut_off(n, widest, boundary):
    y, x, _ = scene(n, 0.0, 4)
    plan = Interaction(y, x, CELL, boundary, Footprints(1.0), widest=widest)
    away = np.array([np.subtract.outer(place, place) for place in (plan.y, plan.x)])
    if boundary == "periodic":
        size = np.array(plan.size)[:, None, None]
        away -= size * np.round(away / size)
    i, j = np.nonzero(np.triu((away**2).sum(axis=0) < CUT_OVER_SPLIT_LENGTH**2, 1))
    runs = [np.arange(first, last) for first, last in plan.near.ptr]
    row, place = np.repeat(np.arange(n), [len(run) for run in runs]), np.concatenate(runs)
    order = np.lexsort((plan.near.col[place], row))
    row, place = row[order], place[order]
    assert plan.pairs == len(i)
    np.testing.assert_array_equal((row, plan.near.col[place]), (i, j))
    np.testing.assert_allclose(plan.near.pair[:, place], away[:, i, j], atol=1e-6)


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
@pytest.mark.parametrize(("n", "cell"), [(1, (1.0, 5.0)), (3, (4.0, 1.0)), (6, (1.0, 1.0))])
def test_wide_footprints_in_a_narrow_cell_act_as_all_their_images(n, cell, m):
    """Wider than a tenth of its short side, so that near pairs reach beyond the nearest image. Of
    the own displacement the field was off by 5 to 40 %."""
    f = Footprints(2.0, m)
    rng = np.random.default_rng(n)
    y, x = rng.uniform(0, 1, (2, n)) * np.array(cell)[:, None]
    v = rng.uniform(0.15, 0.3, n) ** 2
    plan = Interaction(y, x, cell, "periodic", f, widest=float(v.max()))
    dense = dense_matrix(y, x, v, cell, "periodic", f)[plan.order][:, plan.order]
    k = v ** ((1 + m) / 2) / f.rule[0]
    tangent = Tangent(plan, np.ones(n, bool), k[plan.order])
    found = np.array([tangent(e) for e in np.eye(n)])
    own = f.self_factor * v[plan.order] ** (-(1 + m) / 2)
    wanted = dense + np.diag(1 / k[plan.order] - own)
    scale = np.sqrt(np.multiply.outer(own, own))
    assert np.abs((found - wanted) / scale).max() < 0.02
    field = np.array([plan.field(e, v[plan.order]).value for e in np.eye(n)])
    assert np.abs((field - dense + np.diag(own)) / scale).max() < 0.02


def test_finer_settings_converge_to_the_dense_sum(monkeypatch):
    """A longer cut-off with more neighbors in it, and more nodes."""
    y, x, k = scene(120, 0.0, 8, 0.3)
    f = Footprints(1.0)
    v = 0.6 * f.variance(k)
    dense = dense_matrix(y, x, v, CELL, "periodic", f)
    np.fill_diagonal(dense, dense.diagonal() - f.self_factor / np.sqrt(v))
    errors = []
    for cut, nodes, pairs in ((2.0, 2.2, CHEAP_PAIRS), (3.5, 4.0, 60 * len(y))):
        monkeypatch.setattr("asperity.interaction.ewald.near_pairs.CUT_OVER_SPLIT_LENGTH", cut)
        monkeypatch.setattr("asperity.interaction.ewald.operator.CUT_OVER_SPLIT_LENGTH", cut)
        monkeypatch.setattr("asperity.interaction.ewald.near_pairs.CHEAP_PAIRS", pairs)
        monkeypatch.setattr("asperity.interaction.ewald.operator.NODES_PER_SPLIT_LENGTH", nodes)
        plan = Interaction(y, x, CELL, "periodic", f)
        value = plan.field(np.ones(len(y)), v[plan.order]).value
        errors.append(np.abs(value - dense.sum(1)[plan.order]).max())
    assert errors[1] < 0.2 * errors[0]


@settings(max_examples=8, deadline=None, derandomize=True)
@given(
    m=st.sampled_from([-0.4, 0.0, 0.6]),
    boundary=st.sampled_from(["periodic", "free"]),
    seed=st.integers(0, 99),
)
def test_reciprocity(m, boundary, seed):
    """<G p, q> = <p, G q>."""
    y, x, k = scene(90, m, seed)
    plan = Interaction(y, x, CELL, boundary, Footprints(1.0, m))
    v = Footprints(1.0, m).variance(k)[plan.order]
    p, q = np.random.default_rng(seed).normal(size=(2, len(y)))
    left, right = plan.field(p, v)[0] @ q, p @ plan.field(q, v)[0]
    assert left == pytest.approx(right, abs=1e-9 * np.linalg.norm(p) * np.linalg.norm(q))


@pytest.mark.parametrize(("ly", "lx", "value"), [(1.0, 1.0, -1.2414929), (2.0, 2.0, -0.62074644)])
def test_self_image_of_a_square_cell(ly, lx, value):
    assert self_image((ly, lx), Footprints(1.0)) == pytest.approx(value, rel=1e-7)


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_self_image_of_a_rectangle_is_that_of_two_squares(m):
    """A square cell with one force is a double cell with two."""
    f = Footprints(2.0, m)
    two = periodic_interaction(np.zeros(1), np.ones(1), np.full(1, 1e-12), (1.0, 2.0), f)[0]
    assert self_image((1.0, 2.0), f) + two == pytest.approx(self_image((1.0, 1.0), f), rel=1e-9)
    assert self_image((2.0, 1.0), f) == pytest.approx(self_image((1.0, 2.0), f), rel=1e-12)


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
@pytest.mark.parametrize("cell", [(1.0, 1.0), (1.0, 2.5)])
def test_lone_contact_feels_its_images(m, cell):
    f = Footprints(1.0, m)
    plan = Interaction(np.array([0.4]), np.array([0.3]), cell, "periodic", f)
    value = plan.field(np.ones(1), np.full(1, 1e-12)).value
    assert value[0] == pytest.approx(self_image(cell, f), rel=5e-3)


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_field_does_not_change_when_the_cell_moves(m):
    y, x, k = scene(150, m, 11)
    f = Footprints(1.0, m)
    v = 0.6 * f.variance(k)
    fields = []
    for shift in (0.0, 0.37):
        plan = Interaction(y + shift, x - shift, CELL, "periodic", f)
        back = np.empty(len(y))
        back[plan.order] = plan.field(k[plan.order], v[plan.order])[0]
        fields.append(back)
    size = np.ptp(fields[0])
    assert np.abs(fields[0] - fields[1]).max() < 5e-3 * size


@pytest.mark.parametrize("m", [0.0, 0.5])
def test_open_summits_at_one_place_have_a_field(m):
    y, x, k = scene(30, m, 2)
    y[3], x[3], k[3], k[7] = y[7], x[7], 0.0, 0.0
    f = Footprints(1.0, m)
    plan = Interaction(y, x, CELL, "periodic", f)
    k = k[plan.order]
    moment = np.zeros((len(k), 2))
    field = plan.field(k, f.variance(k), 0.4 * f.variance(k), moment)
    assert all(np.isfinite(part).all() for part in field)
    twins = plan.order.argsort()[[3, 7]]
    assert np.ptp(field.value[twins]) < 1e-12 * np.abs(field.value).max()


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_pairs_and_mesh_grow_with_the_points(boundary):
    """No faster than their number: a few points or very many."""
    for count in (4_000, 40_000, 160_000):
        rng = np.random.default_rng(count)
        y, x = (rng.uniform(0.0, side, count) for side in CELL)
        plan = Interaction(y, x, CELL, boundary, Footprints(1.0, 0.0))
        assert plan.pairs < 10 * count
        assert np.prod(plan.mesh.shape) < 16 * count


@pytest.mark.parametrize("seed", range(12))
def test_points_just_before_the_seam_stay_on_the_mesh(seed):
    """Their places were rounded to the end of the mesh: loops wrote beyond it."""
    rng = np.random.default_rng(seed)
    size = tuple((10.0 ** rng.uniform(-8, 3) * rng.uniform(0.7, 1.4, 2)).tolist())
    found = []
    for edge in (np.nextafter(size, 0.0), np.zeros(2)):
        y, x = (
            np.append(at, side * np.linspace(0.1, 0.9, 30))
            for at, side in zip(edge, size, strict=True)
        )
        plan = Interaction(y, x, size, "periodic", Footprints(1.0, 0.0))
        force = np.ones(len(y))
        value = plan.field(force, np.full(len(y), (0.01 * size[0]) ** 2)).value
        found.append(np.empty(len(y)))
        found[-1][plan.order] = value
    np.testing.assert_allclose(*found, rtol=1e-9)
