"""Both models on one surface: errors, run times, files and the report."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from pages import Page

import asperity
from asperity.comparison.other_grids import coarse_grids, load_at_separation
from asperity.comparison.result import Comparison
from asperity.errors import FileFormatError, InputError
from asperity.model.plan import make_plan
from asperity.results.storage import write_results
from surfaces import self_affine

STEEL = asperity.HalfSpace(210e9, 0.3)


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    hm = self_affine(
        (96, 128), (0.96e-3, 1.28e-3), hurst=0.8, rms_slope=0.1, rolloff=2.4e-4, cutoff=8e-5, seed=3
    )
    return asperity.compare(hm, STEEL, pressures=[2e8, 5e7, 1e9], tolerance=1e-5)


def test_both_models_answer_at_every_load_in_the_order_asked(comparison):
    assert comparison.converged
    for curve in (comparison.model, comparison.reference):
        np.testing.assert_allclose(curve.mean_pressure, [2e8, 5e7, 1e9], rtol=2e-3)
        order = np.argsort(curve.mean_pressure)
        assert (np.diff(curve.separation[order]) < 0).all()
        assert (np.diff(curve.area_fraction[order]) > 0).all()


def test_the_models_agree_to_the_class_of_the_approximation(comparison):
    assert np.abs(comparison.table["load_error"]).max() < 0.35
    assert np.abs(comparison.table["area_error"]).max() < 0.35
    assert comparison.overlap > 0.4


def test_the_baseline_holds_coarser_and_looser_runs(comparison):
    rows = comparison.pareto[comparison.pareto["model"] == "bem"]
    assert {(r["ny"], r["nx"]) for r in rows} == {(96, 128), (48, 64)}
    assert (comparison.pareto["seconds"] > 0).all()
    full = rows[(rows["ny"] == 96) & (rows["tolerance"] > 1e-4)][0]
    coarse = rows[rows["ny"] == 48][0]
    assert full["load_error"] < coarse["load_error"]


def test_a_rival_is_at_least_as_accurate(comparison):
    rival, ours = comparison.rival, comparison.pareto[0]
    assert rival["load_error"] <= ours["load_error"]
    assert rival["area_error"] <= ours["area_error"]
    assert "boundary-element run at least as accurate" in comparison.verdict()


def test_file_gives_back_the_comparison(comparison, tmp_path):
    comparison.to_hdf5(tmp_path / "r.h5")
    back = Comparison.from_hdf5(tmp_path / "r.h5")
    assert str(back) == str(comparison)
    assert back.about == comparison.about
    for name, touching in comparison.maps.items():
        np.testing.assert_array_equal(back.maps[name], touching)
    np.testing.assert_array_equal(back.microcontacts, comparison.microcontacts)


def test_a_curve_is_no_comparison(comparison, tmp_path):
    comparison.model.to_hdf5(tmp_path / "c.h5")
    with pytest.raises(InputError, match="holds no comparison"):
        Comparison.from_hdf5(tmp_path / "c.h5")


def test_nothing_that_can_be_judged_is_said_so(tmp_path):
    """Nearly full contact, where the model refuses every point."""
    hm = self_affine((30, 40), (3e-4, 8e-4), hurst=0.8, rms_slope=0.1, cutoff=1.2e-4, seed=1)
    found = asperity.compare(hm, STEEL, pressures=[1e12])
    assert not found.converged
    assert "can be judged" in found.verdict() and "nan" not in str(found)
    for name in ("separation_error", "area_model", "separation_model"):
        assert np.isnan(found.table[name]).all()
    assert np.isnan(found.overlap) and not found.maps["asperity"].any()
    assert "100 % of the nominal area" in found.verdict() and len(found.microcontacts) == 0
    found.to_hdf5(tmp_path / "r.h5")
    assert np.isnan(Comparison.from_hdf5(tmp_path / "r.h5").overlap)
    found.to_html(tmp_path / "r.html")
    assert "nan" not in Page(tmp_path / "r.html").shown.split()


def test_the_maps_are_of_a_load_that_came_out(tmp_path):
    hm = self_affine((30, 40), (3e-4, 8e-4), hurst=0.8, rms_slope=0.1, cutoff=1.2e-4, seed=1)
    found = asperity.compare(hm, STEEL, pressures=[1e12, 1e7])
    assert found.map_point == 1 and found.overlap > 0.4


@pytest.mark.parametrize(
    "lost, told",
    [(("bem",), "touches at a separation of {} (microcontact"), (("bem", "model"), "neither")],
)
def test_the_verdict_names_no_answer_that_there_is_not(comparison, lost, told):
    table, pareto = comparison.table.copy(), comparison.pareto.copy()
    here = table[comparison.map_point]
    for name in [f"{part}_{of}" for part in ("area", "separation") for of in lost]:
        here[name] = np.nan
    pareto["load_error"][0] = np.nan
    text = dataclasses.replace(comparison, table=table, pareto=pareto).verdict()
    assert told.format(f"{1e6 * here['separation_model']:.3g} µm") in text and "nan" not in text
    assert "off by" in text and "rms in load" not in text


@pytest.mark.parametrize("name", ["comparison", "pareto"])
def test_words_in_a_column_of_numbers_are_refused(comparison, tmp_path, name):
    held = comparison.to_results()
    table = held.tables[name]
    types = [(n, "S8" if n == "load_error" else table.dtype[n]) for n in table.dtype.names]
    held.tables[name] = table.astype(types)
    write_results(tmp_path / "r.h5", held)
    with pytest.raises(FileFormatError, match="holds no numbers"):
        Comparison.from_hdf5(tmp_path / "r.h5")


def test_points_that_are_not_judged_are_counted(comparison):
    table = comparison.table.copy()
    table["area_error"][1] = np.nan
    text = dataclasses.replace(comparison, table=table).verdict()
    assert "At 2 of 3 load points" in text


def test_the_plan_is_timed_after_compilation_on_a_map_without_stored_means(monkeypatch):
    steps = []

    def plan(hm, *given, **chosen):
        steps.append("plan with means" if "roughness" in vars(hm) else "plan")
        return make_plan(hm, *given, **chosen)

    hm = self_affine((60, 80), (6e-4, 8e-4), hurst=0.8, rms_slope=0.1, cutoff=6e-5)
    monkeypatch.setattr("asperity.comparison.run.make_plan", plan)
    monkeypatch.setattr("asperity.comparison.run._compile", lambda *_: steps.append("compile"))
    asperity.compare(hm, STEEL, pressures=[1e8], tolerance=1e-3)
    assert steps[-2:] == ["compile", "plan"]


def test_microcontacts_carry_the_load(comparison):
    table = comparison.microcontacts
    at = comparison.model
    point = comparison.map_point
    assert table["force"].sum() == pytest.approx(at.load[point], rel=1e-9)
    assert table["area"].sum() == pytest.approx(at.contact_area[point], rel=1e-9)
    assert (table["semi_major"] >= table["semi_minor"]).all()
    np.testing.assert_allclose(
        np.pi * table["semi_major"] * table["semi_minor"], table["area"], rtol=1e-9
    )


def test_grids_halve_down_to_a_useful_size():
    assert coarse_grids((400, 300)) == [(400, 300), (200, 150), (100, 75)]
    assert coarse_grids((60, 700)) == [(60, 700)]


def test_reading_off_beyond_the_ends_is_log_linear(comparison):
    curve = comparison.reference
    inside = load_at_separation(curve, curve.separation)
    np.testing.assert_allclose(inside, curve.mean_pressure, rtol=1e-9)
    far = curve.separation.max() + np.array([1e-8, 2e-8])
    beyond = load_at_separation(curve, far)
    end = curve.mean_pressure.min()
    assert beyond[0] ** 2 == pytest.approx(beyond[1] * end, rel=1e-9)


def test_one_load_point_is_read_off_by_its_stiffness(comparison):
    """Loose runs at one load had no error in load: the reference itself was the rival."""
    one = comparison.reference.select([0])
    near = one.separation[0] - 1e-3 * one.mean_pressure[0] / one.stiffness[0]
    assert load_at_separation(one, near) == pytest.approx(one.mean_pressure * np.exp(1e-3))


@pytest.mark.parametrize(
    ("given", "told"), [({"plan": "auto"}, "make one with"), ({"reference": 3}, "reference is 3")]
)
def test_what_is_no_plan_or_no_reference_is_refused_before_any_run(given, told):
    hm = self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    with pytest.raises(InputError, match=told):
        asperity.compare(hm, asperity.HalfSpace(210e9, 0.3), pressures=[1e8], **given)


def test_a_reference_of_another_run_is_refused():
    """Errors were judged by it: of another modulus they were 206 % in place of 1 %."""
    hm = self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6, seed=3)
    other = hm.replace(heights=2.0 * hm.heights)
    body, loads = asperity.HalfSpace(210e9, 0.3), [1e8, 1e9]
    soft, yielding = asperity.HalfSpace(70e9, 0.3), asperity.HalfSpace(210e9, 0.3, hardness=2e9)
    for wrong, told in (
        (lambda: asperity.bem_curve(hm, soft, pressures=loads), "a curve of modulus"),
        (lambda: asperity.bem_curve(hm, yielding, pressures=loads), "one of hardness None"),
        (lambda: asperity.bem_curve(other, body, pressures=loads), "a curve of input"),
        (lambda: asperity.bem_curve(hm, body, pressures=loads, boundary="free"), "of boundary"),
        (lambda: asperity.bem_curve(hm, body, pressures=[1e7, 1e8]), "other load points"),
        (lambda: asperity.contact_curve(hm, body, pressures=loads), "a curve of model"),
        (lambda: None, "curve"),
    ):
        with pytest.raises(InputError, match=told):
            asperity.compare(hm, body, pressures=loads, reference=wrong)
