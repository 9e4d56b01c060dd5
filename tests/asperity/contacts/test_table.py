"""Outlines of contacts whose shape changes with depth, against the law of the single contact."""

from __future__ import annotations

import numpy as np
import pytest

import surfaces
from asperity import HalfSpace, indent
from asperity.contacts.table import DIRECTIONS, outlines
from asperity.interaction.elongation import aspect_ratio
from surfaces.shapes import bent_body

SPACING = (0.012, 0.01)


@pytest.mark.parametrize(("m", "error"), [(-0.3, 0.025), (0.0, 0.015), (0.3, 0.012)])
def test_outlines_follow_the_shape_at_their_depth(m, error):
    """An ellipse at the summit, a triangle further out: ellipses err by up to 4 %."""
    body = bent_body()
    y, x = ((np.arange(n) - n // 2) * step for n, step in zip((121, 151), SPACING, strict=True))
    heights = -body(np.hypot(y[:, None], x), np.arctan2(y[:, None], x))
    hm = surfaces.HeightMap(heights, SPACING)
    summit = surfaces.fit_profiles(hm, surfaces.segment(hm)).rows(np.zeros(1, np.int64))
    turn = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    for depth in (0.005, 0.02, 0.06):
        one = indent(body, HalfSpace.from_modulus(1.0, m=m), depth, law="ellipse")
        radii, filled = outlines(
            summit,
            np.array([depth]),
            np.array([float(one.contact_area)]),
            aspect_ratio(summit.curvature),
            m,
        )
        assert np.sqrt(np.mean((radii[0] / one.contour(turn) - 1) ** 2)) < error
        assert filled[0] == 0.0
