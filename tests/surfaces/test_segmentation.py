"""Segmentation: a slow exact flood as reference, symmetries, plateaus, pruning, borders."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from oracles import flood, neighbors_of

import surfaces
from surfaces.numerics import parallel


def rough(shape=(48, 60), size=(1.0, 1.5), **changes):
    options = {"hurst": 0.7, "rms_height": 1.0, "rolloff": 0.5, "cutoff": 0.12, "seed": 1}
    return surfaces.self_affine(shape, size, **(options | changes))


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("above", [None, 0.6])
def test_equals_the_slow_flood(periodic, above):
    for seed in range(3):
        hm = rough(seed=seed).replace(periodic=periodic)
        peaks = surfaces.segment(hm, above=above)
        summits, labels, saddle, parent = flood(hm, -np.inf if above is None else above)
        assert_array_equal(np.stack([peaks.row, peaks.col], axis=1), summits)
        assert_array_equal(peaks.labels, labels)
        assert_array_equal(peaks.saddle, saddle)
        assert_array_equal(peaks.parent, parent)
        assert_array_equal(peaks.height, hm.heights[peaks.row, peaks.col])
        assert_allclose(peaks.prominence, peaks.height - peaks.saddle)
        assert_allclose(peaks.basin_area, np.bincount(labels[labels >= 0]) * np.prod(hm.spacing))


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.integers(0, 10**6), st.booleans(), st.integers(2, 6))
def test_plateaus_count_once(seed, periodic, levels):
    """On maps of few levels: one peak per connected level set without a higher neighbor."""
    rng = np.random.default_rng(seed)
    h = rng.integers(0, levels, (9, 11)).astype(float)
    peaks = surfaces.segment(surfaces.HeightMap(h, (1.0, 2.0), periodic=periodic))
    seen = np.zeros(h.shape, bool)
    tops = set()
    for start in np.ndindex(h.shape):
        if seen[start]:
            continue
        stack, members, is_peak = [start], [], True
        seen[start] = True
        while stack:
            here = stack.pop()
            members.append(here)
            for row, col, _, _ in neighbors_of(*here, h.shape, periodic):
                if h[row, col] > h[here]:
                    is_peak = False
                elif h[row, col] == h[here] and not seen[row, col]:
                    seen[row, col] = True
                    stack.append((row, col))
        if is_peak:
            tops.add(frozenset(members))
    assert len(peaks) == len(tops)
    for row, col in zip(peaks.row, peaks.col, strict=True):
        top = next(members for members in tops if (row, col) in members)
        assert len({peaks.labels[pixel] for pixel in top}) == 1
    assert (peaks.prominence > 0).all() or len(peaks) == 1
    assert (peaks.labels >= 0).all()


def test_rotation_mirror_and_shift_move_the_peaks_only():
    hm = rough()
    base = surfaces.segment(hm)
    maps = {
        "turned": (lambda a: np.rot90(a), hm.spacing[::-1]),
        "mirrored": (lambda a: a[:, ::-1], hm.spacing),
        "shifted": (lambda a: np.roll(a, (17, -23), axis=(0, 1)), hm.spacing),
    }
    for move, spacing in maps.values():
        other = surfaces.segment(surfaces.HeightMap(move(hm.heights), spacing, periodic=True))
        assert_array_equal(other.height, base.height)
        assert_array_equal(other.saddle, base.saddle)
        assert_array_equal(other.parent, base.parent)
        assert_array_equal(other.labels, move(base.labels))
        assert_array_equal(other.neighbors, base.neighbors)
        assert_array_equal(other.passes, base.passes)


def test_adding_a_constant_changes_nothing_else():
    hm = rough()
    hm = hm.replace(heights=np.round(hm.heights * 2.0**30) / 2.0**30)
    base, high = surfaces.segment(hm), surfaces.segment(hm.replace(heights=hm.heights + 1024.0))
    assert_array_equal(high.labels, base.labels)
    assert_array_equal(high.prominence, base.prominence)
    assert_array_equal(high.height, base.height + 1024.0)


def test_flooding_the_top_only_leaves_the_top_unchanged():
    hm = rough((80, 64))
    level = float(np.quantile(hm.heights, 0.8))
    full, top = surfaces.segment(hm), surfaces.segment(hm, above=level)
    n = len(top)
    assert n == np.count_nonzero(full.height >= level)
    assert_array_equal(top.row, full.row[:n])
    assert_array_equal(top.labels, np.where(hm.heights >= level, full.labels, -1))
    joined = full.saddle[:n] >= level
    assert_array_equal(top.saddle[joined], full.saddle[:n][joined])
    assert_array_equal(top.parent, np.where(joined, full.parent[:n], -1))


def test_pruning_keeps_the_prominent_and_connects_their_basins():
    hm = rough((96, 80), (1.0, 1.0), cutoff=0.05)
    full = surfaces.segment(hm)
    limit = float(np.median(full.prominence))
    pruned = surfaces.segment(hm, min_prominence=limit)
    kept = np.flatnonzero(full.prominence >= limit)
    assert_array_equal(pruned.row, full.row[kept])
    assert_array_equal(pruned.prominence, full.prominence[kept])
    rank = np.full(len(full), -1)
    rank[kept] = np.arange(kept.size)
    assert_array_equal(pruned.parent, np.where(full.parent >= 0, rank[full.parent], -1)[kept])
    assert_array_equal(pruned.labels[hm.heights > full.saddle.max()],
                       rank[full.labels[hm.heights > full.saddle.max()]])  # fmt: skip
    assert_allclose(pruned.basin_area.sum(), hm.area)
    for k in range(len(pruned)):
        assert _pieces(pruned.labels == k) == 1
    percent = 100 * limit / np.ptp(hm.heights)
    assert len(surfaces.segment(hm, wolf=percent * 1.0000001)) in (kept.size, kept.size - 1)


def _pieces(mask):
    """Number of 8-connected pieces of a mask on a periodic grid."""
    left, pieces = {tuple(p) for p in np.argwhere(mask)}, 0
    while left:
        stack, pieces = [left.pop()], pieces + 1
        while stack:
            for row, col, _, _ in neighbors_of(*stack.pop(), mask.shape, True):
                if (row, col) in left:
                    left.remove((row, col))
                    stack.append((row, col))
    return pieces


def test_neighbors_hold_the_highest_pass_of_each_touching_pair():
    hm = rough((40, 48)).replace(periodic=False)
    peaks = surfaces.segment(hm)
    passes = {}
    for i, j in np.ndindex(hm.shape):
        for row, col, _, _ in neighbors_of(i, j, hm.shape, False):
            pair = tuple(sorted((int(peaks.labels[i, j]), int(peaks.labels[row, col]))))
            if pair[0] != pair[1]:
                z = min(hm.heights[i, j], hm.heights[row, col])
                passes[pair] = max(passes.get(pair, -np.inf), z)
    assert sorted(passes) == [tuple(p) for p in peaks.neighbors.tolist()]
    assert_array_equal(peaks.passes, [passes[p] for p in sorted(passes)])


@pytest.mark.parametrize("decimals", [None, 1])
def test_prominences_agree_with_the_max_tree_of_higra(decimals):
    """Dynamics of the leaves of an independent max-tree, plateaus included."""
    higra = pytest.importorskip("higra")
    hm = rough((60, 50)).replace(periodic=False)
    if decimals is not None:
        hm = hm.replace(heights=np.round(hm.heights, decimals))
    graph = higra.get_8_adjacency_graph(hm.shape)
    tree, altitudes = higra.component_tree_max_tree(graph, hm.heights)
    dynamics = higra.attribute_dynamics(tree, altitudes, increasing_altitudes=False)
    leaves = np.flatnonzero(higra.attribute_extrema(tree, altitudes))
    peaks = surfaces.segment(hm)
    order = np.lexsort((dynamics[leaves], altitudes[leaves]))
    mine = np.lexsort((peaks.prominence, peaks.height))
    assert_array_equal(peaks.height[mine], altitudes[leaves][order])
    if decimals is None:
        assert_allclose(peaks.prominence[mine], dynamics[leaves][order])
    else:  # of two equally high peaks either may be the one that ends at the saddle
        assert_allclose(np.sort(peaks.prominence), np.sort(dynamics[leaves]), atol=1e-12)


def test_border_flag():
    hm = rough()
    assert not surfaces.segment(hm).border.any()
    peaks = surfaces.segment(hm.replace(periodic=False))
    rim = np.zeros(hm.shape, bool)
    rim[[0, -1], :] = rim[:, [0, -1]] = True
    assert_array_equal(np.flatnonzero(peaks.border), np.unique(peaks.labels[rim]))


def test_constant_map_is_one_plateau_and_nothing_above_gives_no_peaks():
    flat = surfaces.HeightMap(np.zeros((4, 5)), 1.0)
    assert len(surfaces.segment(flat)) == 1
    none = surfaces.segment(flat, above=1.0)
    assert len(none) == 0 and (none.labels == -1).all() and none.neighbors.shape == (0, 2)


def test_what_is_as_high_as_asked_is_kept():
    """Heights from `above` on are flooded, and peaks of `min_prominence` stay."""
    row = np.array([0.0, 1.5, 3.0, 1.0, 2.0, 1.5, 2.5, 0.0])
    hm = surfaces.HeightMap(np.tile(row, (3, 1)) - [[1.0], [0.0], [1.0]], 1.0)
    peaks = surfaces.segment(hm, above=1.5)
    assert_array_equal(peaks.labels[1] >= 0, row >= 1.5)
    assert_array_equal(surfaces.segment(hm, min_prominence=1.5).height, [3.0, 2.5])
    assert_array_equal(surfaces.segment(hm, min_prominence=0.5).height, [3.0, 2.5, 2.0])


@pytest.mark.parametrize("flip", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_a_plateau_has_its_peak_at_the_member_nearest_its_centroid(flip):
    """Each member counts once, wherever the search begins."""
    top = np.zeros((6, 9))
    top[2, 2:6] = top[3, 4] = 1.0  # centroid at row 2.2, column 3.6
    peaks = surfaces.segment(surfaces.HeightMap(top[:: flip[0], :: flip[1]], 1.0))
    row, col = peaks.row[0], peaks.col[0]
    assert (row if flip[0] > 0 else 5 - row, col if flip[1] > 0 else 8 - col) == (2, 4)


def test_refusals():
    gap = np.zeros((4, 5))
    gap[1, 2] = np.nan
    with pytest.raises(surfaces.SurfaceError, match="1 of 20 points"):
        surfaces.segment(surfaces.HeightMap(gap, 1.0))
    with pytest.raises(surfaces.InputError, match="min_prominence is -1"):
        surfaces.segment(rough(), min_prominence=-1.0)
    with pytest.raises(surfaces.InputError, match="wolf is 120"):
        surfaces.segment(rough(), wolf=120.0)
    with pytest.raises(surfaces.InputError, match="above is not a number"):
        surfaces.segment(rough(), above=float("nan"))


def test_the_number_of_threads_changes_nothing_even_between_equal_heights(monkeypatch):
    """Passes that are equally high are joined by the pair, however the map was shared out."""
    monkeypatch.setattr(parallel, "_POINTS", 64)
    rng = np.random.default_rng(8)
    heights = np.round(rng.normal(size=(192, 150)) * 2)
    hm = surfaces.HeightMap(heights, (1.0, 0.7), periodic=True)
    try:
        found = []
        for count in (1, None):
            parallel.set_threads(count)
            found.append(surfaces.segment(hm, min_prominence=1.0))
    finally:
        parallel.set_threads(None)
    for name, one in vars(found[0]).items():
        assert_array_equal(one, getattr(found[1], name), err_msg=name)
