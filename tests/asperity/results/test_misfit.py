"""Interpolated misfit and its bound: exact cases."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from asperity.results.interpolation import halved_intervals, interpolated_misfit

POSITION = np.linspace(-3.0, 2.0, 11)
ANCHORS = np.array([0, 3, 5, 10])
FLOOR = np.full(11, 0.01)


@given(st.floats(-0.2, 0.2), st.floats(-0.1, 0.1))
def test_a_misfit_that_is_linear_is_found_exactly(start, slope):
    """What the interpolation misses is then nothing; half the difference of two anchors stays."""
    exact = start + slope * POSITION
    found, bound = interpolated_misfit(POSITION, ANCHORS, exact[ANCHORS], FLOOR)
    np.testing.assert_allclose(found, exact, atol=1e-12)
    step = 0.5 * np.abs(np.diff(exact[ANCHORS]))[np.searchsorted(ANCHORS, np.arange(11)) - 1]
    beside = np.setdiff1d(np.arange(11), ANCHORS)
    np.testing.assert_allclose(bound[beside], np.maximum(step, 0.01)[beside], atol=1e-12)
    assert (bound[ANCHORS] == 0.0).all()


@given(st.lists(st.floats(-0.3, 0.3), min_size=4, max_size=4))
def test_bound_covers_anchors_left_out(values):
    """An anchor that was not known would have been within the bounds beside it."""
    misfit = np.array(values)
    _, bound = interpolated_misfit(POSITION, ANCHORS, misfit, 0.0 * FLOOR)
    for j in (1, 2):
        others = np.delete(np.arange(4), j)
        told = np.interp(POSITION[ANCHORS[j]], POSITION[ANCHORS[others]], misfit[others])
        for beside in (ANCHORS[j] - 1, ANCHORS[j] + 1):
            if beside not in ANCHORS:
                assert abs(told - misfit[j]) <= bound[beside] + 1e-12


def test_new_anchor_halves_the_interval_of_the_worst_point():
    need = np.zeros(11)
    need[7] = 2.0
    np.testing.assert_array_equal(halved_intervals(ANCHORS, need), [0, 3, 5, 7, 10])


def test_anchors_end_where_all_are_taken():
    anchors = np.array([0, 4])
    while len(anchors) < 5:
        need = np.ones(5)
        need[anchors] = 0.0
        more = halved_intervals(anchors, need)
        assert len(more) == len(anchors) + 1
        anchors = more
