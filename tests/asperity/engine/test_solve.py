"""`solve`: the accuracy asked for, by either engine, with bounds that hold."""

from __future__ import annotations

import numpy as np
import pytest

import surfaces
from asperity import ContactCurve, HalfSpace, InputError, bem_curve, contact_curve, solve
from asperity.engine.cost import can_anchor, cheapest, forecast
from asperity.errors import ModelRangeError
from asperity.halfspace.scene import default_pressures
from asperity.model.plan import make_plan

BODY = HalfSpace.from_modulus(1.0)


def waves(points: int = 128, **recipe: object) -> surfaces.HeightMap:
    """Random waves cut off at six pixels."""
    recipe = {"hurst": 0.8, "rms_slope": 0.1, "cutoff": 6.0, "rolloff": 32.0, "seed": 1} | recipe
    return surfaces.self_affine((points, points), (float(points), float(points)), **recipe)


def hill() -> surfaces.HeightMap:
    """A round hill with few fine summits, on which the model alone fails."""
    y, x = np.meshgrid(*2 * [(np.arange(128) + 0.5) / 128 - 0.5], indexing="ij")
    heights = 3.0 * np.exp(-12 * (x**2 + y**2))
    fine = waves(rolloff=12.0, seed=4).heights
    return surfaces.HeightMap(heights + 0.05 * fine / fine.std(), (1.0, 1.0), periodic=True)


def two_tops() -> surfaces.HeightMap:
    """Two summits on each ridge of a long wave."""
    x = np.arange(96) / 96
    heights = 3.0 * np.cos(2 * np.pi * x) + 0.4 * np.cos(4 * np.pi * (x + x[:, None]))
    return surfaces.HeightMap(0.01 * heights, (1.0, 1.0), periodic=True)


def exact(hm, body, loads, boundary=None):
    """Boundary elements to a bound of 0.1 % in load."""
    return bem_curve(hm, body, pressures=loads, tolerance=1e-7, boundary=boundary)


def inside(curve, true, of_bound=1.0):
    """Whether load at equal separation and area at equal load are within the bounds."""
    load = true.stiffness / true.mean_pressure * (curve.separation - true.separation)
    area = np.log(curve.contact_area / true.contact_area)
    return (np.abs(load) <= of_bound * curve.error_estimate).all() and (
        np.abs(area) <= of_bound * curve.extra["area_error_estimate"]
    ).all()


SCENES = {
    "waves": (waves(), BODY, None),
    "hill": (hill(), BODY, None),
    "graded": (waves(seed=2), HalfSpace.from_modulus(1.0, 0.3), None),
    "free": (waves(seed=3), BODY, "free"),
}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("engine", ["bem", "anchored"])
def test_bounds_hold_and_the_accuracy_is_met(name, engine):
    hm, body, boundary = SCENES[name]
    loads = default_pressures(hm, body, 9)
    true = exact(hm, body, loads, boundary)
    curve = solve(hm, body, pressures=loads, engine=engine, boundary=boundary)
    assert inside(curve, true)
    assert curve.verification["met"] == bool(
        (curve.error_estimate <= 0.05).all() and (curve.extra["area_error_estimate"] <= 0.1).all()
    )
    np.testing.assert_allclose(curve.stiffness, true.stiffness, rtol=0.12)
    np.testing.assert_allclose(curve.contacts, true.contacts, rtol=0.35, atol=3)


@pytest.mark.parametrize("verify", [bem_curve, None])
def test_the_accuracy_in_load_is_met_where_nearly_all_touches(verify):
    """There the load changes with the separation faster than the area: 1.8 times the bound."""
    loads = [0.06, 0.08, 0.1]
    hm = waves(64)
    if verify is None:
        curve = solve(hm, BODY, pressures=loads)
        assert curve.verification["met"]
    else:
        curve = contact_curve(hm, BODY, pressures=loads, verify=verify)
    assert curve.area_fraction[-1] > 0.9
    assert (curve.error_estimate <= 0.05).all()


def test_points_solved_by_boundary_elements_are_theirs():
    """And anchors are what boundary elements give alone."""
    hm = waves()
    loads = default_pressures(hm, BODY, 9)
    curve = solve(hm, BODY, pressures=loads, engine="anchored", accuracy=0.1)
    assert curve.model == "anchored" and curve.settings["engine"] == "anchored"
    anchors = curve.verification["anchors"]
    assert {0, 8} < set(anchors) and len(anchors) < 9
    true = exact(hm, BODY, loads[anchors])
    np.testing.assert_allclose(curve.separation[anchors], true.separation, rtol=1e-2)
    np.testing.assert_allclose(curve.contact_area[anchors], true.contact_area, rtol=2e-2)


def test_more_is_anchored_where_more_accuracy_is_asked():
    hm = waves()
    loads = default_pressures(hm, BODY, 9)
    count = [
        len(solve(hm, BODY, pressures=loads, engine="anchored", accuracy=a).verification["anchors"])
        for a in (0.1, 0.02, 0.004)
    ]
    assert count[0] < count[2] == 9 and count[0] <= count[1]


def test_separations_in_place_of_pressures():
    hm = waves()
    loads = default_pressures(hm, BODY, 8)
    true = exact(hm, BODY, loads)
    for engine in ("bem", "anchored"):
        curve = solve(hm, BODY, separations=true.separation, engine=engine)
        load = np.abs(np.log(curve.mean_pressure / true.mean_pressure))
        assert (load <= curve.error_estimate).all()


def test_order_and_zero_load_are_kept():
    hm = waves()
    loads = default_pressures(hm, BODY, 7)
    mixed = np.concatenate([loads[[5, 0, 3]], [0.0], loads[[1, 6, 2, 4]]])
    curve = solve(hm, BODY, pressures=mixed, engine="anchored")
    np.testing.assert_allclose(curve.mean_pressure, mixed, rtol=1e-2)
    order = np.argsort(mixed)
    assert (np.diff(curve.separation[order]) < 0).all() and curve.contact_area[3] == 0.0


def test_a_load_asked_for_twice_has_one_answer():
    """One of them was an anchor, the other between two."""
    hm = waves()
    loads = default_pressures(hm, BODY, 9)[[8, 3, 3, *range(8), 8]]
    curve = solve(hm, BODY, pressures=loads, engine="anchored", accuracy=0.1)
    np.testing.assert_allclose(curve.mean_pressure, loads, rtol=1e-2)
    anchors = np.flatnonzero(curve.extra["anchor"]).tolist()
    assert curve.verification["anchors"] == anchors and 0 < len(anchors) < 12
    for name in ("separation", "contact_area", "contacts", "error_estimate"):
        column = getattr(curve, name)
        assert column[[0, 1, 2]].tolist() == column[[11, 2, 6]].tolist(), name


def test_answer_is_kept_in_a_file(tmp_path):
    hm = waves()
    curve = solve(hm, BODY, pressures=default_pressures(hm, BODY, 6), engine="anchored")
    curve.to_hdf5(tmp_path / "r.h5")
    again = ContactCurve.from_hdf5(tmp_path / "r.h5")
    assert again.verification == curve.verification
    assert str(again) == str(curve) and "engine" in str(curve)


def test_boundary_elements_alone_where_they_are_cheaper():
    """Small maps, and few loads; many loads of a large map are left to the model."""
    hm = waves()
    plan = make_plan(hm, BODY)
    seconds = forecast(hm, BODY, "periodic", 10, plan)
    curve = solve(hm, BODY)
    assert seconds["bem"] < seconds["anchored"] and curve.settings["engine"] == "bem"
    assert curve.extra["anchor"].all() and len(curve.verification["anchors"]) == len(curve)
    least = forecast(hm, BODY, "periodic", 10)
    assert least["bem"] == seconds["bem"] and "at least" in curve.verification["reason"]
    assert all(0.0 < least[name] < seconds[name] for name in ("anchored", "sampled"))
    large = waves(1024, cutoff=None, rolloff=256.0)
    seconds = forecast(large, BODY, "periodic", 60, make_plan(large, BODY))
    assert seconds["bem"] > max(seconds["anchored"], seconds["sampled"])


def test_the_model_is_tried_where_it_is_likely_to_hold():
    """Elsewhere its time is spent beside that of boundary elements: ratios of up to six."""
    maps = waves(), waves(cutoff=None), two_tops()
    assert [can_anchor(hm, make_plan(hm, BODY)) for hm in maps] == [True, False, False]
    assert cheapest({"bem": 1.0, "anchored": 0.9, "sampled": 2.0}) == "bem"
    assert cheapest({"bem": 1.0, "anchored": 0.7, "sampled": 0.6}) == "sampled"


def test_where_anchors_fail_the_rest_is_solved_no_closer_than_asked():
    """Two summits on a ridge: the model has an answer, off by several times the accuracy."""
    hm, asked = two_tops(), []

    def judge(hm, body, *, pressures, accuracy, **how):
        asked.append((len(pressures), accuracy))
        return bem_curve(hm, body, pressures=pressures, accuracy=accuracy, **how)

    curve = solve(
        hm, BODY, pressures=default_pressures(hm, BODY, 12), engine="anchored", judge=judge
    )
    assert curve.verification["met"] and curve.settings["engine"] == curve.model == "bem"
    assert asked == [(5, pytest.approx((0.0075, 0.015))), (7, pytest.approx((0.05, 0.1)))]


def test_forecast_knows_what_makes_boundary_elements_dearer():
    """Padded transforms on free maps, more steps under a hardness; parts are spared both."""
    hm, hard = waves(512), HalfSpace.from_modulus(1.0, hardness=0.02)
    borders = "periodic", "free"
    plans = [make_plan(hm, BODY, boundary=border) for border in borders]
    plain, free = (
        forecast(hm, BODY, border, 10, plan) for border, plan in zip(borders, plans, strict=True)
    )
    both = forecast(hm, hard, "free", 10, plans[1])
    assert 1.5 < free["bem"] / plain["bem"] < 2.5 and 1.2 < both["bem"] / free["bem"] < 2.0
    assert plain["anchored"] < free["anchored"] < both["anchored"]
    assert plain["sampled"] == free["sampled"] == both["sampled"]


def test_many_small_contacts_take_boundary_elements_longer():
    """2.5 times as long to the pixel with H 0.3 as with a cut-off, which the forecast did not tell:
    maps of 1536^2 were left to boundary elements where parts take half of their time."""
    shapes = {"hurst": 0.3, "cutoff": None}, {"hurst": 0.5, "cutoff": None}, {"cutoff": 8.0}
    maps = [waves(512, **shape) for shape in shapes]
    rough, medium, smooth = (forecast(hm, BODY, "periodic", 10)["bem"] for hm in maps)
    assert 1.8 < rough / smooth < 2.8 and 1.4 < medium / smooth < rough / smooth


def test_parts_are_taken_where_the_model_solves_the_map_as_it_is():
    """Its time follows the peaks that may touch: by points boundary elements seemed cheaper, which
    take twice as long here and eight times at 4096^2."""
    fine, coarse = waves(1536, cutoff=8.0, rolloff=60.0), waves(1536, cutoff=16.0, rolloff=60.0)
    many, few = (forecast(hm, BODY, "periodic", 10, make_plan(hm, BODY)) for hm in (fine, coarse))
    assert many["sampled"] < min(many["bem"], many["anchored"])
    assert few["bem"] == pytest.approx(many["bem"], rel=0.02) and few["anchored"] < many["anchored"]


def test_a_model_without_an_answer_leaves_all_to_boundary_elements():
    """Parallel ridges touch along lines, which no law of a summit describes."""
    heights = np.cos(2 * np.pi * np.arange(64) / 32)[:, None] * np.ones(64)
    hm = surfaces.HeightMap(heights, (1.0, 1.0), periodic=True)
    loads = default_pressures(hm, BODY, 6)
    curve = solve(hm, BODY, pressures=loads, engine="anchored")
    assert curve.settings["engine"] == "bem" and inside(curve, exact(hm, BODY, loads))


def test_without_verification_the_model_answers_alone():
    hm = waves()
    loads = default_pressures(hm, BODY, 3)
    curve = solve(hm, BODY, pressures=loads, verify=False)
    alone = contact_curve(hm, BODY, pressures=loads)
    np.testing.assert_array_equal(curve.separation, alone.separation)
    np.testing.assert_array_equal(curve.error_estimate, alone.error_estimate)
    assert curve.settings["engine"] == "model" and curve.verification["anchors"] == []
    assert np.isnan(curve.verification["resolution_uncertainty"]).all() and "model" in str(curve)


def test_the_model_answers_where_boundary_elements_do_not_fit(monkeypatch):
    hm = waves()
    monkeypatch.setattr("asperity.engine.solve.fits", lambda *_: False)
    curve = solve(hm, BODY, pressures=default_pressures(hm, BODY, 6))
    assert curve.settings["engine"] == "model" and "memory" in curve.verification["reason"]


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"accuracy": 0.5}, "accuracy is 0.5"),
        ({"accuracy": "high"}, "accuracy"),
        ({"area_accuracy": 2.0}, "area_accuracy is 2.0"),
        ({"engine": "fem"}, "engine is 'fem'"),
        ({"verify": "often"}, "verify is 'often'"),
        ({"verify": np.ones(2)}, "verify is array"),
        ({"verify": False, "engine": "sampled"}, "engine is 'sampled', which verifies"),
        ({"progress": 1}, "progress is 1; give a function"),
        ({"judge": "bem"}, "judge is 'bem'; give a function"),
    ],
)
def test_bad_input_is_told_in_one_sentence(wrong, text):
    with pytest.raises(InputError, match=text):
        solve(waves(), BODY, **wrong)


@pytest.mark.parametrize("engine", ["bem", "anchored"])
def test_a_hardness_by_either_engine(engine):
    hm = surfaces.self_affine(
        (96, 120), (96.0, 120.0), hurst=0.8, rms_slope=0.1, rolloff=30.0, cutoff=8.0, seed=4
    )
    body = HalfSpace.from_modulus(1.0, hardness=0.004)
    loads = 0.004 * np.geomspace(0.005, 0.1, 8)
    found = solve(hm, body, pressures=loads, engine=engine)
    exact = bem_curve(hm, body, pressures=loads, tolerance=1e-6)
    assert found.converged.all() and found.settings["hardness"] == 0.004
    assert (found.contact_area * 0.004 >= found.load * (1 - 1e-9)).all()
    area = np.abs(found.contact_area / exact.contact_area - 1)
    assert (area <= found.extra["area_error_estimate"] + 1e-3).all()
    load = np.abs(np.interp(-found.separation, -exact.separation, np.log(loads)) - np.log(loads))
    assert (load <= found.error_estimate + 0.01).all()
    assert (found.extra["plastic_share"] > 0.8).all()


def test_what_is_asked_for_is_not_replaced_by_another_engine(monkeypatch):
    """Boundary elements answered where they were left out, the model where they were asked for."""
    with pytest.raises(ModelRangeError, match="near -1"):
        solve(waves(32), HalfSpace.from_modulus(1.0, -0.9985), verify=False)
    monkeypatch.setattr("asperity.engine.solve.fits", lambda *_: False)
    with pytest.raises(InputError, match="does not fit into memory"):
        solve(waves(32), BODY, engine="anchored")
