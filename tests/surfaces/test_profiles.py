"""Profiles: known summits come out, rays are monotone, symmetries."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import asperity
import surfaces
from surfaces.numerics import splines
from surfaces.peaks._climb import SUMMIT
from surfaces.peaks.summits import locate_summits


def rough(shape=(96, 80), size=(1.0, 1.25), **changes):
    options = {"hurst": 0.8, "rms_height": 0.01, "rolloff": 0.5, "cutoff": 0.12, "seed": 1}
    return surfaces.self_affine(shape, size, **(options | changes))


def fitted(hm, **options):
    peaks = surfaces.segment(hm)
    return peaks, surfaces.fit_profiles(hm, peaks, **options)


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.2, -0.7])
@pytest.mark.parametrize("spacing", [(1.0, 1.0), (0.7, 1.1)])
def test_single_paraboloid_comes_back(angle, spacing):
    k1, k2, y0, x0 = 0.05, 0.02, 20.23, 24.61
    y = (np.arange(40)[:, None] + 0.5) * spacing[0] - y0 * spacing[0]
    x = (np.arange(50)[None, :] + 0.5) * spacing[1] - x0 * spacing[1]
    along = x * np.cos(angle) + y * np.sin(angle)
    across = y * np.cos(angle) - x * np.sin(angle)
    hm = surfaces.HeightMap(7.0 - 0.5 * (k2 * along**2 + k1 * across**2), spacing)
    _, fit = fitted(hm)
    assert len(fit) == 1 and fit.valid[0] and fit.border[0]
    assert_allclose([fit.x[0], fit.y[0]], [x0 * spacing[1], y0 * spacing[0]], atol=1e-7)
    assert_allclose(fit.height, 7.0, atol=1e-9)
    assert_allclose(fit.curvature[0], [k1, k2], rtol=1e-7)
    assert_allclose(np.sin(fit.angle[0] - angle), 0.0, atol=1e-7)
    turn = fit.phi[0] - angle
    q = 0.5 * (k2 * np.cos(turn) ** 2 + k1 * np.sin(turn) ** 2)
    assert_allclose(fit.q[0], np.repeat(q[:, None], 17, axis=1), rtol=1e-6)
    profile = fit.profile(0)
    r = np.array([0.3, 1.0, 4.0])[:, None]
    around = np.linspace(0, 2 * np.pi, 9)[None, :]
    turn = around - angle
    exact = 0.5 * r**2 * (k2 * np.cos(turn) ** 2 + k1 * np.sin(turn) ** 2)
    assert_allclose(profile(r, around), exact, rtol=2e-3)


def test_a_tilted_summit_is_that_of_the_tilted_map():
    spacing, tilt = (0.7, 1.1), np.array([0.12, -0.2])
    y = (np.arange(60)[:, None] - 29.6) * spacing[0]
    x = (np.arange(48)[None, :] - 23.3) * spacing[1]
    hill = -0.01 * y**2 - 0.02 * x**2 - 0.004 * x * y - 1e-4 * (x**2 + y**2) ** 1.5 - 2e-5 * x**4
    plane = tilt[0] * y + tilt[1] * x
    level, tilted = (
        locate_summits(hm, surfaces.segment(hm))
        for hm in (surfaces.HeightMap(z, spacing) for z in (hill, hill - plane))
    )
    assert len(level) == len(tilted) == 1
    inclined = level.tilted(np.array([0]), tilt[None], np.zeros(1))
    assert np.hypot(inclined.x - level.x, inclined.y - level.y) > 3.0
    fallen = tilt @ ((inclined.places[0] - [29.6, 23.3]) * spacing)
    assert_allclose(inclined.height, tilted.height + fallen, atol=1e-9)
    first, second = (summits.rows(np.array([0])) for summits in (inclined, tilted))
    for name in ("x", "y", "curvature", "angle", "phi", "edge", "q"):
        assert_allclose(getattr(first, name), getattr(second, name), rtol=1e-6, err_msg=name)
    assert inclined.valid[0] and not level.tilt.any()


def test_rays_rise_and_weights_make_one_turn():
    peaks, fit = fitted(rough())
    assert_allclose(fit.weight.sum(axis=1), 2 * np.pi)
    assert (np.diff(fit.f(), axis=2) > -1e-15).all()
    assert (fit.q > 0).all() and (fit.edge > 0).all()
    assert (fit.curvature[:, 0] >= fit.curvature[:, 1]).all() and (fit.curvature > 0).all()
    assert (fit.height >= peaks.height - 1e-15).all()
    assert_allclose(fit.phi[:, 0], fit.angle)
    assert fit.valid.mean() > 0.9


def test_rays_cover_their_basins():
    peaks, fit = fitted(rough((256, 240), (1.0, 1.0), cutoff=0.06))
    covered = 0.5 * (fit.weight * fit.edge**2).sum(axis=1)
    inner = fit.valid
    assert_allclose(np.median(covered[inner] / peaks.basin_area[inner]), 1.05, atol=0.05)
    assert_allclose(covered.sum() / peaks.basin_area.sum(), 1.0, atol=0.08)


def test_flooding_the_top_only_changes_hardly_a_ray_above_that_height():
    hm = rough((128, 120), (1.0, 1.0), cutoff=0.06)
    level = 0.5 * hm.rms_height
    full, top = (
        surfaces.fit_profiles(hm, surfaces.segment(hm, above=above)) for above in (None, level)
    )
    n = len(top)
    assert 20 < n < len(full) and (top.valid == full.valid[:n]).all()
    assert_allclose(top.height, full.height[:n], rtol=1e-12)
    short = (full.f()[:n, :, -1] < full.height[:n, None] - level) & full.valid[:n, None]
    assert short.mean() > 0.1
    same = np.isclose(top.edge[short], full.edge[:n][short], rtol=1e-9)
    assert same.mean() > 0.98  # the rest meet the basin of a peak below that height
    assert_allclose(top.q[short][same], full.q[:n][short][same], rtol=1e-9)


def test_turning_the_map_turns_the_profiles():
    hm = rough()
    turned = surfaces.HeightMap(np.rot90(hm.heights), hm.spacing[::-1], periodic=True)
    (_, base), (_, other) = fitted(hm), fitted(turned)
    assert_allclose(other.x, base.y, atol=1e-9)
    assert_allclose(other.y, hm.size[1] - base.x, atol=1e-9)
    assert_allclose(other.curvature, base.curvature, rtol=1e-7)
    assert_allclose(np.sin(2 * (other.angle - base.angle - np.pi / 2)), 0.0, atol=1e-6)


@pytest.mark.parametrize("seed", [5, 6, 7])
def test_summits_of_a_mirrored_map_are_mirrored(seed):
    """Climbs along ridges between the pixels of a refined map pass from basin to basin."""
    hm = surfaces.self_affine(
        (192, 160), (192.0, 160.0), hurst=0.8, rms_slope=0.1, rolloff=40.0, cutoff=6.0, seed=seed,
        anisotropy=6.0, angle=0.3 * seed,
    )  # fmt: skip
    hm = surfaces.resample(hm, (0.5, 0.5))
    found = []
    for flip in (1, -1):
        heights = np.ascontiguousarray(hm.heights[::flip])
        turned = hm.replace(heights=heights)
        summits = locate_summits(turned, surfaces.segment(turned))
        row = summits.peaks.row if flip == 1 else hm.shape[0] - 1 - summits.peaks.row
        order = np.lexsort((summits.peaks.col, row))
        found.append((np.minimum(summits.kinds, 1)[order], summits.height[order]))
    np.testing.assert_array_equal(found[0][0], found[1][0])
    assert_allclose(found[0][1], found[1][1], rtol=1e-9, atol=1e-9 * hm.rms_height)


def test_ridge_cut_into_pieces_by_the_grid_is_one_peak():
    """Its pixels have several maxima, the surface through them has one; the rays pass them all."""
    k1, k2, angle = 1.2, 0.004, 0.4
    y, x = np.mgrid[:60, :80] - np.array([30.2, 40.3])[:, None, None]
    along = x * np.cos(angle) + y * np.sin(angle)
    across = y * np.cos(angle) - x * np.sin(angle)
    ridge = -0.5 * k2 * along**2 - (1 - np.cos(across * np.sqrt(k1)))
    hm = surfaces.HeightMap(np.where(np.abs(across) < 2.5, ridge, -2.0), 1.0)
    peaks, fit = fitted(hm)
    top = int(np.argmin(np.hypot(fit.x - 40.8, fit.y - 30.7)))
    pieces = np.flatnonzero(fit.owner == top)
    assert len(pieces) > 2 and fit.valid[top] and fit.valid[pieces].sum() == 1
    assert fit.pixels[top] == np.isin(peaks.labels, pieces).sum()
    assert_allclose([fit.x[top], fit.y[top]], [40.8, 30.7], atol=1.0)
    assert abs(np.sin(fit.angle[top] - angle)) < 0.01
    assert fit.edge[top].max() > 20


def test_peaks_without_a_summit_get_a_paraboloid_and_are_marked():
    hm = rough((96, 96), (1.0, 1.0), cutoff=0.04, anisotropy=4.0, angle=0.5)
    _, fit = fitted(hm)
    weak = ~fit.valid
    assert 0.2 < weak.mean() < 0.7
    turn = fit.phi[weak] - fit.angle[weak, None]
    k1, k2 = fit.curvature[weak].T[..., None]
    q = 0.5 * (k2 * np.cos(turn) ** 2 + k1 * np.sin(turn) ** 2)
    assert_allclose(fit.q[weak], np.repeat(q[:, :, None], 17, axis=2))
    assert fit.valid[fit.owner[weak]].all()
    assert fit.pixels[fit.valid].sum() == hm.heights.size


@pytest.mark.parametrize("turns", [0, 1, 2, 3])
def test_peak_cut_by_the_border_is_mirrored_and_compressed(turns):
    """Half a paraboloid whose highest point is its border."""
    y, x = np.mgrid[:40, :60] - np.array([-0.5, 30.2])[:, None, None]
    hm = surfaces.HeightMap(np.rot90(-0.01 * (x**2 + y**2), turns), 1.0)
    _, fit = fitted(hm)
    assert len(fit) == 1 and fit.valid[0] and fit.border[0]
    r = 10.0
    f = np.array([np.interp(r, fit.t * e, v) for e, v in zip(fit.edge[0], fit.f()[0], strict=True)])
    phi = fit.phi[0] - turns * np.pi / 2 * -1.0
    across = 1.7 * r * np.abs(np.sin(phi))
    along = r * np.cos(phi)
    assert_allclose(f, 0.01 * (along**2 + across**2), rtol=0.15)


def test_plateau_is_a_blunt_summit():
    h = -np.maximum(0.0, np.hypot(*np.mgrid[-9:10, -12:13]) - 4.0)
    _, fit = fitted(surfaces.HeightMap(h, 1.0))
    assert np.isfinite(fit.q).all() and (fit.q > 0).all() and fit.valid[0]
    assert_allclose([fit.x[0], fit.y[0], fit.height[0]], [12.5, 9.5, 0.0], atol=1e-12)
    r = fit.t * fit.edge[0][:, None]
    assert (fit.f()[0][r < 3.0] < 0.1).all() and (fit.f()[0][(r > 5.5) & (r < 8)] > 1.0).all()


@pytest.mark.parametrize("bend", [-1e-12, 0.0, 1e-12])
def test_a_level_ridge_has_a_summit_whatever_the_rounding_of_its_curvature(bend):
    y, x = np.mgrid[-9:10, -12:13]
    hm = surfaces.HeightMap(np.cos(x / 5.0) + bend * y**2, 1.0)
    peaks = surfaces.segment(hm.replace(heights=np.cos(x / 5.0) - 1e-12 * y**2))
    assert (peaks.row[0], peaks.col[0]) == (9, 12)
    assert locate_summits(hm, peaks).kinds[0] == SUMMIT


@pytest.mark.parametrize("periodic", [True, False])
def test_pruning_to_one_peak_ends_the_rays_at_the_cell(periodic):
    hm = rough((40, 60), (1.0, 2.0)).replace(periodic=periodic)
    peaks = surfaces.segment(hm, min_prominence=0.99 * float(np.ptp(hm.heights)))
    fit = surfaces.fit_profiles(hm, peaks)
    assert len(fit) == 1
    assert (fit.edge * np.abs(np.sin(fit.phi)) <= (0.501 if periodic else 1.0)).all()
    assert (fit.edge * np.abs(np.cos(fit.phi)) <= (1.001 if periodic else 2.0)).all()
    assert fit.edge.max() > 0.4


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10**6),
    shape=st.tuples(st.integers(3, 24), st.integers(3, 24)),
    levels=st.sampled_from([2, 4, 0]),
    scale=st.sampled_from([1e-12, 1.0, 1e6]),
    periodic=st.booleans(),
    top=st.one_of(st.none(), st.floats(0.0, 1.0)),
    limit=st.sampled_from([0.0, 0.1, 2.0]),
)
def test_profiles_of_any_map_are_finite_and_rise(seed, shape, levels, scale, periodic, top, limit):
    rng = np.random.default_rng(seed)
    h = scale * (rng.integers(0, levels, shape) if levels else rng.normal(size=shape))
    h[0, 0] += scale
    hm = surfaces.HeightMap(h, (1.0, 0.3), periodic=periodic)
    above = None if top is None else float(np.quantile(h, top))
    peaks = surfaces.segment(hm, above=above, min_prominence=limit * scale)
    fit = surfaces.fit_profiles(hm, peaks, rays=8, nodes=6)
    for values in (fit.q, fit.edge, fit.curvature):
        assert np.isfinite(values).all() and (values > 0).all()
    f = fit.f()
    assert (np.diff(f, axis=2) >= -1e-12 * np.abs(f).max(initial=1e-300)).all()
    assert (fit.valid[fit.owner] | (fit.owner == np.arange(len(fit)))).all()


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("rays, nodes", [(5, 7), (16, 17), (70, 20)])
def test_nodes_lie_on_the_surface_unless_it_rises(periodic, rays, nodes):
    hm = rough().replace(periodic=periodic)
    _, fit = fitted(hm, rays=rays, nodes=nodes)
    spline = splines.coefficients(hm.heights, periodic)
    some = np.flatnonzero(fit.valid & ~fit.border)[::9]
    for n in some:
        r = fit.t * fit.edge[n][:, None]
        y = (fit.y[n] + r * np.sin(fit.phi[n])[:, None]) / hm.spacing[0] - 0.5
        x = (fit.x[n] + r * np.cos(fit.phi[n])[:, None]) / hm.spacing[1] - 0.5
        if periodic:
            y, x = y % hm.shape[0], x % hm.shape[1]
        places = zip(y.ravel(), x.ravel(), strict=True)
        z = [splines.expand(spline.ravel(), spline.shape[1], *place)[0] for place in places]
        f = np.maximum.accumulate(fit.height[n] - np.reshape(z, r.shape), axis=1)
        f = np.maximum(f, 1e-3 * fit.q[n, :, :1] * r**2)
        assert_allclose(fit.f()[n], f, rtol=1e-9, atol=1e-12 * np.abs(fit.height[n]))


def test_a_single_profile_returns_the_nodes_of_all_rays():
    """Rays of one peak differ in length by a factor of three (median)."""
    _, fit = fitted(rough((80, 96), (1.0, 1.5)))
    chosen = np.flatnonzero(fit.valid)[:12]
    f = fit.f()
    misses = []
    for i in chosen:
        r = fit.edge[i][:, None] * fit.t
        given = fit.profile(int(i))(r, np.broadcast_to(fit.phi[i][:, None], r.shape))
        misses.append(np.abs(given - f[i])[:, 1:] / f[i][:, 1:])
    assert np.max(misses) < 0.01
    assert np.quantile(misses, 0.99) < 1e-3


def test_the_rows_asked_for_are_those_of_the_whole_batch():
    hm = rough()
    peaks, fit = fitted(hm, nodes=9)
    summits = locate_summits(hm, peaks)
    index = np.random.default_rng(0).permutation(len(peaks))[:7]
    some = summits.rows(index, nodes=9)
    for name, value in vars(fit.rows(index)).items():
        np.testing.assert_array_equal(getattr(some, name), value)
    np.testing.assert_array_equal(summits.height, fit.height)


def test_no_peaks_give_no_profiles():
    hm = rough()
    peaks = surfaces.segment(hm, above=1.0)
    assert len(surfaces.fit_profiles(hm, peaks)) == 0


def test_refusals():
    hm = rough()
    peaks = surfaces.segment(hm)
    with pytest.raises(surfaces.InputError, match="rays is 2; give a whole number, at least 4"):
        surfaces.fit_profiles(hm, peaks, rays=2)
    flat = surfaces.HeightMap(np.ones((5, 6)), 1.0)
    with pytest.raises(surfaces.SurfaceError, match="map is constant"):
        surfaces.fit_profiles(flat, surfaces.segment(flat))
    with pytest.raises(surfaces.SurfaceError, match="segment this map first"):
        surfaces.fit_profiles(rough((64, 80)), peaks)


def test_straight_ridges_round_a_periodic_cell_end_in_a_curve():
    hm = surfaces.HeightMap(np.tile(np.arange(32) % 16, (32, 1)) * 1e-8, 1e-6, periodic=True)
    body = asperity.HalfSpace.from_modulus(1e9)
    assert (asperity.contact_curve(hm, body, pressures=[1e3, 1e4]).load > 0).all()


def test_a_tilt_along_a_level_ridge_of_a_periodic_map_comes_to_an_end():
    """Uphill leads round the cell for ever."""
    hm = surfaces.HeightMap(np.tile(np.arange(32) % 16, (32, 1)) * 1e-8, 1e-6, periodic=True)
    summits = locate_summits(hm, surfaces.segment(hm))
    rows = np.arange(len(summits))
    tilted = summits.tilted(rows, np.tile([-1e-3, 0.0], (len(rows), 1)), np.zeros(len(rows)))
    assert np.isfinite(tilted.height).all()


def test_of_flat_tops_of_one_height_none_is_the_parent_of_the_others():
    """Which of equal peaks is named the parent is a matter of order: their profiles are alike."""
    y, x = np.mgrid[:48, :96]
    hills = np.cos(2 * np.pi * x / 48) * np.cos(2 * np.pi * y / 48)
    heights = np.minimum(hills, 0.7)
    for map_of in (heights, heights[::-1, ::-1]):
        hm = surfaces.HeightMap(map_of, 1.0, periodic=True)
        peaks = surfaces.segment(hm)
        assert len(peaks) == 4 and len(np.unique(peaks.prominence.round(9))) == 2
        curvature = surfaces.fit_profiles(hm, peaks).curvature
        np.testing.assert_allclose(curvature, curvature[0, 0], rtol=0.1)


def test_rays_of_a_mirrored_map_are_as_long():
    """Rays of summits in the middle of a pixel pass halfway between two others."""
    hm = rough((48, 60), (60.0, 48.0), rolloff=20.0, cutoff=5.0, anisotropy=2.0, angle=0.5, seed=3)
    hm = hm.replace(periodic=False)
    _, one = fitted(hm)
    _, other = fitted(hm.replace(heights=hm.heights[:, ::-1]))
    edges = (np.sort(np.sort(each.edge, axis=1), axis=0) for each in (one, other))
    assert_allclose(*edges, rtol=1e-6)
