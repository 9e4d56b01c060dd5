"""Flat tops: found where there are some, in their middle, on any side of the seam."""

from __future__ import annotations

import numpy as np
import pytest

import surfaces
from surfaces.peaks.peaks import flat_tops
from surfaces.peaks.summits import locate_summits


def tables(periodic, shift=(0, 0)):
    """A disc and a rounded hill of other heights, the disc moved by `shift` pixels."""
    y, x = np.indices((50, 64)) * 1.0
    disc = 4.0 - 0.3 * np.maximum(np.hypot(y - 25, x - 20) - 6.0, 0.0)
    hill = 3.0 - 0.02 * ((y - 24.7) ** 2 + (x - 47.3) ** 2)
    heights = np.maximum(np.maximum(disc, hill), 0.5)
    return surfaces.HeightMap(np.roll(heights, shift, (0, 1)), (1.0, 2.0), periodic=periodic)


@pytest.mark.parametrize("shift", [(0, 0), (-25, -21), (24, 0)])
def test_the_middle_of_a_disc_is_found_across_the_seam(shift):
    hm = tables(True, shift)
    peaks = surfaces.segment(hm)
    rows, middle = flat_tops(hm, peaks)
    assert (np.add((25, 20), shift) % hm.shape).tolist() in middle.tolist()
    summits = locate_summits(hm, peaks)
    top = rows[summits.height[rows] == 4.0]
    assert len(top) == 1
    edges = summits.rows(top).edge
    assert edges.min() > 7.0  # beyond the flat part


@pytest.mark.parametrize("seed", [2, 5, 8])
def test_the_middle_of_a_top_round_a_period_moves_with_the_map(seed):
    """The flat top of half of the points is longer than half a period along both axes."""
    waves = surfaces.self_affine(
        (48, 60), (48.0, 60.0), hurst=0.8, rms_slope=0.1, cutoff=8.0, seed=seed
    )
    z = np.minimum(waves.heights, np.median(waves.heights))
    found = []
    for shift in ((0, 0), (11, 5), (31, 40), (7, 50)):
        hm = waves.replace(heights=np.roll(z, shift, (0, 1)))
        _, middle = flat_tops(hm, surfaces.segment(hm))
        found.append(((middle - shift) % hm.shape).tolist())
    assert found == found[:1] * 4 and len(found[0]) == 1


def test_of_two_highest_pixels_that_with_the_higher_neighbors_is_the_peak():
    heights = np.zeros((9, 12))
    heights[4, 5:7] = 3.0
    heights[3:6, 7] = 2.0  # beside the second
    for turned in (heights, heights[:, ::-1]):
        peaks = surfaces.segment(surfaces.HeightMap(turned, 1.0, periodic=True))
        assert turned[peaks.row[0], peaks.col[0] + np.array([-1, 1])].sum() == 5.0


def test_rounded_and_random_summits_are_none():
    hm = tables(False)
    peaks = surfaces.segment(hm)
    assert 3.0 not in np.round(peaks.height[flat_tops(hm, peaks)[0]], 1)
    rough = surfaces.self_affine((48, 60), (48.0, 60.0), hurst=0.8, rms_slope=0.1, seed=3)
    assert not flat_tops(rough, surfaces.segment(rough))[0].size
