"""Contact curves by boundary elements."""

from __future__ import annotations

import numpy as np
import pytest
from strategies import rough

from asperity import HalfSpace, bem_curve, bem_solve, contact_curve
from asperity.errors import InputError

BODY = HalfSpace.from_modulus(1.0)
HARD = HalfSpace.from_modulus(1.0, hardness=1.0)


def test_curve_equals_single_solutions_in_the_order_asked():
    """Each point is the solution at its load, whatever the order and repetition."""
    hm = rough()
    loads = [0.1, 0.01, 0.03, 0.03, 0.0]
    curve = bem_curve(hm, BODY, pressures=loads)
    assert curve.converged.all() and curve.residual.max() <= 1e-6
    for i, load in enumerate(loads):
        one = bem_solve(hm, BODY, pressure=load)
        assert curve.separation[i] == pytest.approx(one.separation, rel=1e-4)
        assert curve.area_fraction[i] == pytest.approx(one.area_fraction, rel=0.02)
        assert curve.mean_pressure[i] == pytest.approx(load, abs=1e-12)
    assert curve.stiffness[2] == curve.stiffness[3]


def test_default_loads_and_extra():
    """Without load points: ten of them, light to moderate contact, with certificates."""
    hm = rough((48, 64))
    curve = bem_curve(hm, BODY)
    assert len(curve) == 10 and curve.converged.all()
    assert curve.area_fraction[0] < 0.01 and 0.03 < curve.area_fraction[-1] < 0.3
    for name in ("load_error", "complementarity", "penetration", "contact_area_raw", "fft_pairs"):
        assert curve.extra[name].shape == (10,)


def test_stiffness_by_slope_and_by_energy():
    """dp/ds of neighboring points; the energy of the curve is its work."""
    hm = rough((48, 64), seed=1)
    curve = bem_curve(hm, BODY, pressures=np.linspace(0.02, 0.05, 7), tolerance=1e-8)
    assert (curve.stiffness > 0).all()
    slope = np.gradient(curve.extra["elastic_energy"] / hm.area, -curve.separation)
    np.testing.assert_allclose(slope[1:-1], curve.mean_pressure[1:-1], rtol=0.01)


@pytest.mark.parametrize("accuracy", [None, 0.05])
def test_the_slightest_touch_carries_what_it_should(accuracy):
    """Errors of a prescribed separation are relative to how far the highest point reaches beyond
    it: an empty contact is none of a small error."""
    hm = rough()
    tops = hm.about_mean.heights.max() - hm.rms_height * np.array([1e-9, 1e-6, 1e-4])
    touched = bem_curve(hm, BODY, separations=tops, accuracy=accuracy)
    assert touched.converged.all() and (touched.load > 0.0).all()
    back = bem_curve(hm, BODY, pressures=touched.mean_pressure)
    approach = hm.about_mean.heights.max() - back.separation
    np.testing.assert_allclose(approach / hm.rms_height, [1e-9, 1e-6, 1e-4], rtol=0.05)


def test_prescribed_separations():
    """Separations in falling order of load give the same curve back."""
    hm = rough((48, 64), seed=2)
    forward = bem_curve(hm, BODY, pressures=[0.01, 0.05])
    back = bem_curve(hm, BODY, separations=forward.separation)
    np.testing.assert_allclose(back.mean_pressure, forward.mean_pressure, rtol=1e-3)


@pytest.mark.parametrize(("body", "least"), [(BODY, -0.01), (BODY, 0.0), (HARD, 0.0)])
def test_an_unusable_separation_is_refused_before_the_work(body, least):
    """Nothing is solved for the sake of points that would be lost with the refusal. At separation
    zero any load came back, stated as exact, if the body had a hardness."""
    seen = []
    with pytest.raises(InputError, match="it is the mean gap"):
        bem_curve(rough((30, 40)), body, separations=[0.05, least], progress=seen.append)
    assert not seen


def test_secant_saves_transforms():
    """Along a curve the extrapolated start needs fewer transform pairs than a cold one."""
    hm = rough((150, 180), cutoff=8.0, seed=3)
    loads = np.geomspace(0.005, 0.08, 8)
    curve = bem_curve(hm, BODY, pressures=loads, tolerance=1e-7)
    cold = [bem_solve(hm, BODY, pressure=p, tolerance=1e-7).fft_pairs for p in loads]
    assert curve.converged.all()
    assert curve.extra["fft_pairs"][2:].sum() < sum(cold[2:])


def test_progress_sees_every_point_with_its_map():
    """The callbacks run point by point; the contact map is of that point."""
    seen, lengths = [], []
    curve = bem_curve(
        rough((30, 40), seed=5),
        BODY,
        pressures=[0.2, 0.02],
        progress=lambda point: seen.append((point.mean_pressure, point.contact.mean())),
        checkpoint=lambda part: lengths.append(len(part)),
    )
    assert lengths == [1, 2]
    assert [p for p, _ in seen] == pytest.approx([0.02, 0.2])
    raw = curve.extra["contact_area_raw"] / 1.5
    assert [a for _, a in seen] == pytest.approx(raw[::-1].tolist())


@pytest.mark.parametrize("curve", [bem_curve, contact_curve])
@pytest.mark.parametrize("name", ["progress", "checkpoint"])
def test_what_cannot_be_called_is_refused_before_the_work(curve, name):
    """It was found out after the first load point, as a TypeError."""
    with pytest.raises(InputError, match=f"{name} is 3; give a function"):
        curve(rough((24, 30)), BODY, pressures=[0.1], **{name: 3})


class Interrupted(Exception):
    """Stands for a run that is killed."""


@pytest.mark.parametrize(
    ("shape", "after", "how"),
    [
        ((24, 30), 1, {"tolerance": 1e-6}),
        ((24, 30), 5, {"accuracy": 0.05}),
        ((200, 204), 5, {"accuracy": (0.02, 0.05)}),  # two chains of loads
    ],
)
@pytest.mark.parametrize("kind", ["pressures", "separations"])
def test_a_run_goes_on_as_if_it_had_not_been_interrupted(shape, after, how, kind):
    """The loads that were left started anew: areas to an accuracy moved by up to 2 %."""
    hm = rough(shape, seed=3)
    loads = np.random.default_rng(0).permutation(np.geomspace(1e-3, 0.3, 9))
    if kind == "separations":
        loads = bem_curve(hm, BODY, pressures=loads, tolerance=1e-2).separation
    seen, paths = [], {}

    def kept(curve):
        seen.append(curve)
        if len(seen) == after:
            raise Interrupted

    whole = bem_curve(hm, BODY, **{kind: loads}, **how)
    with pytest.raises(Interrupted):
        bem_curve(hm, BODY, **{kind: loads}, **how, checkpoint=kept, paths=paths)
    left = ~np.isin(loads, seen[-1].extra[f"asked_{kind[:-1]}"])
    rest = bem_curve(hm, BODY, **{kind: loads[left]}, **how, paths=paths)
    for name in ("separation", "mean_pressure", "area_fraction", "stiffness", "error_estimate"):
        np.testing.assert_allclose(getattr(rest, name), getattr(whole, name)[left], rtol=1e-12)


def test_paths_of_another_run_are_left_out():
    hm, paths = rough((24, 30)), {}
    bem_curve(hm, BODY, pressures=[0.1, 0.2], checkpoint=lambda _: None, paths=paths)
    other = bem_curve(hm, BODY, pressures=[0.03, 0.2], paths=paths)
    np.testing.assert_array_equal(
        other.separation, bem_curve(hm, BODY, pressures=[0.03, 0.2]).separation
    )
