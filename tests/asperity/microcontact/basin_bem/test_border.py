"""Basins that the border of a free map cuts: nothing is there beyond it."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
from asperity.microcontact.basin_bem import press
from surfaces import HeightMap, segment
from surfaces.peaks.summits import locate_summits

BODY = asperity.HalfSpace.from_modulus(2.0)

SUMMITS = [(1.3, 30.2), (0.0, 30.2), (-5.0, 30.2), (20.0, -0.4), (-3.0, -4.0), (46.2, 63.0)]
"""Rows and columns about the border of `cut`: on both sides, and at corners."""


def cut(row: float, col: float) -> HeightMap:
    """A paraboloid that the border of the map cuts."""
    ny, nx, dy, dx = 48, 64, 1.3, 0.9
    y, x = (np.arange(ny) - row)[:, None] * dy, (np.arange(nx) - col) * dx
    return HeightMap(-0.015 * y**2 - 0.005 * x**2, (dy, dx))


@pytest.mark.parametrize(("row", "col"), SUMMITS)
def test_a_basin_that_the_border_cuts_is_pressed_as_far_as_it_goes(row, col):
    """A finite punch has nothing beyond its border: boundary elements on the map tell the same."""
    hm, depth = cut(row, col), np.array([1.0, 5.0])
    summits = locate_summits(hm, segment(hm))
    exact = asperity.bem_curve(
        hm, BODY, separations=summits.height[0] - depth - hm.heights.mean(), tolerance=1e-6
    )
    found = press.press(summits, np.zeros(1, np.int64), depth[None], BODY)[0]
    np.testing.assert_allclose(found[:, 0], exact.load, rtol=0.05)
    np.testing.assert_allclose(found[:, 1], exact.contact_area, rtol=0.1)  # 20 to 500 pixels
    curve = asperity.contact_curve(hm, BODY, separations=exact.separation)
    np.testing.assert_allclose(curve.load, exact.load, rtol=0.05)
    np.testing.assert_allclose(curve.contact_area, exact.contact_area, rtol=0.1)


@pytest.mark.parametrize(("row", "col"), SUMMITS)
def test_a_soft_summit_that_the_border_cuts_bears_what_is_there_of_it(row, col):
    hm, height = cut(row, col), 5.0
    body = asperity.HalfSpace.from_modulus(2.0, hardness=1e-3)
    pixels = np.count_nonzero(hm.heights > hm.heights.max() - height)
    pressure = pixels / hm.heights.size * body.hardness
    curve = asperity.contact_curve(hm, body, pressures=[pressure])
    level = curve.separation[0] + hm.heights.mean()
    assert hm.heights.max() - level == pytest.approx(height, rel=0.1)
