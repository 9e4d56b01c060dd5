"""A decomposition that serves several runs: its times, its plan, its hardness."""

from __future__ import annotations

from dataclasses import replace

import pytest

from asperity.curve import solve_loads
from asperity.errors import InputError
from asperity.halfspace.material import HalfSpace
from asperity.model.decomposition import Decomposition
from asperity.model.plan import make_plan
from asperity.parameters import DEFAULTS
from surfaces import self_affine

BODY = HalfSpace.from_modulus(1.0)
HILLS = self_affine((96, 96), (96.0, 96.0), hurst=0.8, rms_slope=0.1, cutoff=16.0, seed=2)


def test_no_stage_of_a_second_run_takes_negative_time():
    """The times of the first were taken off."""
    loads = {"pressures": [1e-4, 1e-3]}
    first, made, _ = solve_loads(HILLS, BODY, **loads)
    again, _, _ = solve_loads(HILLS, BODY, made.plan, **loads, decomposition=made)
    for curve in (first, again):
        assert min(curve.seconds.values()) >= 0.0


def test_a_plan_says_what_was_followed():
    """On few summits the whole map is segmented, whatever the loads; the reason told of its top."""
    always = replace(DEFAULTS, segmentation=replace(DEFAULTS.segmentation, whole_points=0))
    plan = make_plan(HILLS, BODY, pressures=[1e-6], parameters=always)
    assert plan.above is not None and "only the top" in str(plan)
    followed = Decomposition.of(HILLS, BODY, plan).plan
    assert followed.above is None and "only the top" not in str(followed)
    assert "segmentation: the whole map" in str(followed)


def test_a_hardness_needs_laws_that_were_made_for_one():
    """They hold the bearing areas; an assertion failed in their place."""
    made = Decomposition.of(HILLS, BODY, make_plan(HILLS, BODY, pressures=[1e-3]))
    with pytest.raises(InputError, match="without a hardness"):
        made.of_hardness(HalfSpace.from_modulus(1.0, hardness=0.05))
