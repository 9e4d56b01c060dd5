"""The curve of the model, checked by boundary elements where it is asked to be."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import asperity
import surfaces
from asperity.errors import InputError
from asperity.parameters import DEFAULTS
from asperity.trust.verified import Accuracy, verified

STEEL = asperity.HalfSpace(210e9, 0.3)
LOADS = np.geomspace(3e7, 2e9, 7)


@pytest.fixture(scope="module")
def rough():
    return surfaces.self_affine(
        (64, 64), (64e-6, 64e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6, seed=2
    )


def test_the_verified_curve_is_within_its_bounds(rough):
    """Without interaction the model alone is far off."""
    settings = {"pressures": LOADS, "interaction": False}
    model = asperity.contact_curve(rough, STEEL, **settings)
    curve = asperity.contact_curve(rough, STEEL, **settings, verify=asperity.bem_curve)
    tight = asperity.bem_curve(rough, STEEL, pressures=LOADS, accuracy=1e-3)

    def off(found):
        rate = tight.stiffness / tight.mean_pressure
        return np.abs(rate * (found.separation - tight.separation))

    assert off(model).max() > 0.1
    assert (off(curve) <= curve.error_estimate + tight.error_estimate).all()
    assert curve.extra["anchor"][[0, -1]].all()
    np.testing.assert_array_equal(curve.extra["prior_error_estimate"], model.error_estimate)


def test_boundary_elements_correct_what_has_yielded(rough):
    """Between the anchors too: a conductance follows from the stiffness of unloading."""
    soft = asperity.HalfSpace(210e9, 0.3, hardness=1.2e10)
    exact = asperity.bem_curve(rough, soft, pressures=LOADS, tolerance=1e-4)
    plan = asperity.make_plan(rough, soft, pressures=LOADS)
    model = asperity.contact_curve(rough, soft, pressures=LOADS, plan=plan)
    off = {"plastic_share": 1.4, "unloading_stiffness": 0.9}
    model = dataclasses.replace(
        model, extra={**model.extra, **{name: k * exact.extra[name] for name, k in off.items()}}
    )

    def judge(values, share):
        return exact.select(np.searchsorted(LOADS, values))

    found = verified(rough, plan, model, judge, Accuracy(1.0, 1.0))
    between = ~found.extra["anchor"]
    assert between.any()
    stiffness = found.extra["unloading_stiffness"] / exact.extra["unloading_stiffness"]
    np.testing.assert_allclose(stiffness[between], 1.0, rtol=1e-9)
    share = found.extra["plastic_share"]
    np.testing.assert_allclose(share[between], exact.extra["plastic_share"][between], rtol=1e-9)
    assert (share <= 1.0).all()


def test_a_correction_beyond_the_estimate_is_not_trusted(rough):
    """The area of a contact that has yielded is known from its load, whatever it was before."""
    exact = asperity.bem_curve(rough, STEEL, pressures=LOADS, tolerance=1e-4)
    plan = asperity.make_plan(rough, STEEL, pressures=LOADS)
    model = asperity.contact_curve(rough, STEEL, pressures=LOADS, plan=plan)
    known = np.array([0, 0, 1, 0, 0, 1, 0], dtype=bool)
    told = {**model.extra, "area_error_estimate": np.where(known, 0.01, 0.4)}
    area = exact.contact_area * np.where(known, 1.0, 0.7)
    model = dataclasses.replace(model, contact_area=area, extra=told)

    def judge(values, share):
        return exact.select(np.searchsorted(LOADS, values))

    found = verified(rough, plan, model, judge, Accuracy(1.0, 1.0))
    assert not found.extra["anchor"][known].any()
    off = np.abs(np.log(found.contact_area / exact.contact_area))
    assert (off <= found.extra["area_error_estimate"]).all()


def test_anchors_heed_the_constants_of_the_plan(rough):
    """A map whose waves the plan does not take for random gets more anchors to begin with."""
    count = []
    for kurtosis in (1.0, 0.0):
        waves = dataclasses.replace(DEFAULTS.pixel_waves, kurtosis=kurtosis)
        chosen = dataclasses.replace(DEFAULTS, pixel_waves=waves)
        plan = asperity.make_plan(rough, STEEL, pressures=LOADS, scales="all", parameters=chosen)
        model = asperity.contact_curve(rough, STEEL, pressures=LOADS, plan=plan)

        def judge(values, share, model=model):
            told = {**model.extra, "area_error_estimate": 0.0 * LOADS}
            exact = dataclasses.replace(model, error_estimate=0.0 * LOADS, extra=told)
            return exact.select(np.searchsorted(LOADS, values))

        found = verified(rough, plan, model, judge, Accuracy(1.0, 1.0))
        count.append(int(found.extra["anchor"].sum()))
    assert count == [3, 5]


def test_verify_is_a_function(rough):
    with pytest.raises(InputError, match="verify is True; give"):
        asperity.contact_curve(rough, STEEL, pressures=LOADS, verify=True)


def test_equal_loads_have_equal_answers(rough):
    loads = [5e8, 1e8, 2e8, 5e8, 3e8, 1e9, 1e8]
    for curve in (
        asperity.contact_curve(rough, STEEL, pressures=loads, verify=asperity.bem_curve),
        asperity.bem_curve(rough, STEEL, pressures=loads),
    ):
        for name in ("separation", "contact_area", "stiffness", "error_estimate"):
            column = getattr(curve, name)
            assert column[0] == column[3] and column[1] == column[6]
        np.testing.assert_array_equal(curve.extra["asked_pressure"], loads)


@pytest.mark.parametrize("seed", [2, 3])
def test_a_separation_at_which_the_model_alone_touches(seed):
    """It divided by no load; boundary elements have the answer there."""
    hm = surfaces.self_affine(
        (64, 80), (64e-6, 80e-6), hurst=0.8, rms_slope=0.1, rolloff=2e-5, cutoff=6e-6, seed=seed
    )
    top = hm.heights.max() - hm.heights.mean()
    curve = asperity.solve(
        hm, STEEL, engine="anchored", separations=top * np.array([1.0, 0.9, 0.8, 0.6, 0.5, 0.4])
    )
    assert curve.mean_pressure[0] == 0.0 and np.isfinite(curve.error_estimate).all()
    assert curve.extra["anchor"][0] and (curve.error_estimate < 0.05).all()
