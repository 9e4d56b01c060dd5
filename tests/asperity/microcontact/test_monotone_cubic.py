"""Monotone cubics through many rows at once, against those of one row."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from asperity.microcontact.monotone_cubic import monotone


@settings(deadline=None, derandomize=True, max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(1, 8), st.booleans())
def test_rows_are_those_of_scipy(seed, rows, level):
    """With values that rise, fall and stand still, and rows of different lengths."""
    random = np.random.default_rng(seed)
    places = np.cumsum(random.integers(1, 5, (rows, 12)), axis=1)
    count = random.integers(3, 13, rows)
    values = random.normal(size=(rows, 12, 2))
    if level:
        values = np.round(values)
    at = np.arange(50.0)
    unknown = np.arange(12) >= count[:, None]
    found = monotone(
        np.where(unknown, -1, places), count, np.where(unknown[:, :, None], 0, values), at
    )
    for i, k in enumerate(count):
        inside = (at >= places[i, 0]) & (at <= places[i, k - 1])
        line = PchipInterpolator(places[i, :k], values[i, :k])(at[inside])
        np.testing.assert_allclose(found[i, inside], line, atol=1e-12)


def test_a_straight_line_goes_on():
    line = monotone(np.array([[0, 2, 5]]), np.array([3]), np.array([[[1.0], [5.0], [11.0]]]), [7.0])
    assert line[0, 0, 0] == pytest.approx(15.0)
