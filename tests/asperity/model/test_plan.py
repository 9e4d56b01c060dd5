"""The plan: what is left out follows from the input and is said."""

from __future__ import annotations

import dataclasses
from dataclasses import replace

import numpy as np
import pytest

from asperity import contact_curve, solve_contacts
from asperity.errors import InputError, SurfaceError
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import pressure_scale
from asperity.model.plan import make_plan
from asperity.parameters import DEFAULTS, ENGINE, Segmentation
from surfaces import HeightMap, self_affine

STEEL = HalfSpace.from_modulus(2e11)


@pytest.fixture(scope="module")
def rough() -> HeightMap:
    return self_affine((96, 128), (9.6e-4, 1.28e-3), hurst=0.8, rms_slope=0.1, cutoff=8e-5, seed=4)


def test_boundary_follows_the_map_unless_asked(rough):
    assert make_plan(rough, STEEL).boundary == "periodic"
    assert make_plan(dataclasses.replace(rough, periodic=False), STEEL).boundary == "free"
    assert make_plan(rough, STEEL, boundary="free").boundary == "free"


def test_interaction_is_left_out_only_if_asked(rough):
    """Not at a vanishing load either."""
    assert make_plan(rough, STEEL).interaction
    assert not make_plan(rough, STEEL, interaction=False).interaction
    assert make_plan(rough, STEEL, pressures=[1e-14 * pressure_scale(rough, STEEL)]).interaction


def test_light_loads_segment_only_the_top_of_many_points(rough):
    few = replace(DEFAULTS, segmentation=Segmentation(whole_points=2**18))
    large = self_affine(
        (640, 512), (6.4e-3, 5.12e-3), hurst=0.8, rms_slope=0.1, cutoff=5e-5, seed=4
    )
    scale = pressure_scale(large, STEEL)
    light = make_plan(large, STEEL, pressures=[1e-3 * scale], scales="all", parameters=few)
    heavy = make_plan(large, STEEL, pressures=[0.2 * scale], scales="all", parameters=few)
    assert light.above is not None
    assert light.above > 0
    assert heavy.above is None
    gap = [1.5 * large.rms_height]
    high = make_plan(large, STEEL, separations=gap, scales="all", parameters=few)
    assert high.above == pytest.approx(large.rms_height, rel=1e-9)
    assert make_plan(rough, STEEL, pressures=[1e-3 * scale]).above is None


def test_every_choice_has_its_reason(rough):
    text = str(make_plan(rough, STEEL))
    for word in ("boundary", "material", "interaction", "segmentation", "grid", "memory"):
        assert word in text


def test_smooth_maps_are_solved_on_fewer_points(rough):
    smooth = self_affine((240, 180), (1e-3, 1e-3), hurst=0.8, rms_slope=0.1, cutoff=1e-4, seed=4)
    assert make_plan(rough, STEEL).resampled is None
    plan = make_plan(smooth, STEEL)
    assert plan.resampled is not None
    assert "108 x 80 points hold the map of 240 x 180" in str(plan)


def test_maps_rough_to_the_pixel_are_solved_on_more_points():
    rough = self_affine((96, 128), (9.6e-4, 1.28e-3), hurst=0.8, rms_slope=0.1, seed=4)
    for hm in (rough, dataclasses.replace(rough, periodic=False)):
        plan = make_plan(hm, STEEL, interaction=False)
        assert plan.resampled is not None
        assert plan.solved(hm).shape == tuple(2 * n for n in hm.shape)
        assert "192 x 256 points show the summits of 96 x 128" in str(plan)
    assert make_plan(rough, STEEL, scales="all").resampled is None


def test_a_plan_is_not_used_for_another_map(rough):
    smooth = self_affine((240, 180), (1e-3, 1e-3), hurst=0.8, rms_slope=0.1, cutoff=1e-4, seed=4)
    plan = make_plan(smooth, STEEL)
    curve = contact_curve(smooth.replace(name="the same"), STEEL, pressures=[1e8], plan=plan)
    assert curve.converged.all()
    for other in (smooth.replace(heights=2 * smooth.heights), rough):
        with pytest.raises(InputError, match="for another map"):
            contact_curve(other, STEEL, pressures=[1e8], plan=plan)


def test_a_plan_of_the_map_itself_is_not_used_for_another_map_or_material(rough):
    plan = make_plan(rough, STEEL)
    assert plan.resampled is None
    soft = HalfSpace.from_modulus(2e10, m=0.3)
    for hm, body, other in (
        (rough.replace(heights=2 * rough.heights), STEEL, "map"),
        (rough, soft, "material"),
    ):
        with pytest.raises(InputError, match=f"for another {other}"):
            contact_curve(hm, body, pressures=[1e8], plan=plan)


def test_loads_in_the_place_of_a_plan(rough):
    with pytest.raises(InputError, match=r"plan is a list; make one with asperity\.make_plan"):
        solve_contacts(rough, STEEL, [1e8])


@pytest.mark.parametrize("given", [ENGINE, ENGINE.anchors, DEFAULTS.limits, {"limits": 1}, None])
def test_only_constants_of_the_model_belong_to_a_plan(rough, given):
    said = rf"parameters is of type {type(given).__name__}; give .*asperity\.parameters\.Parameters"
    with pytest.raises(InputError, match=said):
        make_plan(rough, STEEL, parameters=given)


def test_what_does_not_fit_into_the_memory_is_refused(rough, monkeypatch):
    monkeypatch.setattr("surfaces.numerics.memory.available_bytes", lambda: 10_000)
    with pytest.raises(SurfaceError, match="crop or resample"):
        make_plan(rough, STEEL)


def test_maps_that_no_model_can_use(rough):
    holed = rough.heights.copy()
    holed[3, 5] = np.nan
    with pytest.raises(SurfaceError, match=r"\(1 of 12288 points\).*fill"):
        make_plan(rough.replace(heights=holed), STEEL)
    with pytest.raises(SurfaceError, match="constant"):
        make_plan(rough.replace(heights=np.ones((4, 5))), STEEL)
    with pytest.raises(InputError, match="one of periodic, free"):
        make_plan(rough, STEEL, boundary="open")
