"""Contact curves: reading off, tables, and what is refused."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys

import numpy as np
import pytest
from matplotlib.figure import Figure
from samples import power_law_curve

from asperity.errors import InputError
from asperity.results.curve import ContactCurve
from asperity.results.interpolation import POINT_FIELDS
from asperity.results.storage import write_csv


def test_reading_off_an_exponential_law_is_exact_between_points():
    curve = power_law_curve()
    asked = np.array([2.3e4, 7e5, 9.9e6])
    point = curve.at(pressure=asked)
    np.testing.assert_allclose(point.area_fraction, asked / 1e8, rtol=1e-12)
    np.testing.assert_allclose(point.separation, -1e-6 * np.log(asked / 1e8), rtol=1e-12)
    back = curve.at(separation=point.separation)
    np.testing.assert_allclose(back.mean_pressure, asked, rtol=1e-9)


def test_what_is_asked_for_comes_back():
    curve = power_law_curve()
    bent = dataclasses.replace(curve, separation=np.expm1(3e5 * curve.separation))
    asked = bent.separation[:-1] + 0.4 * np.diff(bent.separation)
    np.testing.assert_array_equal(bent.at(separation=asked).separation, asked)


def test_scalar_question_scalar_answer():
    point = power_law_curve().at(pressure=1e5)
    assert np.ndim(point.area_fraction) == 0
    assert point.load == pytest.approx(0.1)


def test_points_that_did_not_converge_are_not_read():
    whole, broken = power_law_curve(), power_law_curve(broken=5)
    p = whole.mean_pressure[5]
    assert broken.at(pressure=p).separation == pytest.approx(whole.separation[5], rel=1e-9)


def test_points_whose_separation_does_not_fall_are_left_out():
    """Two loads closer than the solve can tell apart may come out in the wrong order."""
    curve = power_law_curve()
    swapped = curve.separation.copy()
    swapped[5] = swapped[4] * (1 + 1e-12)
    point = dataclasses.replace(curve, separation=swapped).at(separation=swapped[[3, 7]])
    np.testing.assert_allclose(point.mean_pressure, curve.mean_pressure[[3, 7]], rtol=1e-9)


def test_of_points_that_have_yielded_all_over_the_lightest_is_read_in_any_order():
    """They bear the hardness at any separation below the first at which they do."""
    curve = power_law_curve(6)
    pressure, separation = curve.mean_pressure.copy(), curve.separation.copy()
    pressure[4:], separation[5] = pressure[4], separation[4] - 1e-5
    curve = dataclasses.replace(curve, mean_pressure=pressure, separation=separation)
    between = np.sqrt(pressure[3] * pressure[4])
    for points in (np.arange(6), [5, 4, 3, 2, 1, 0]):
        found = curve.select(points).at(pressure=between).separation
        assert found == pytest.approx(0.5 * (separation[3] + separation[4]), rel=1e-9)


@pytest.mark.parametrize("question", [{"pressure": "much"}, {"separation": [1e-6, None, "x"]}])
def test_reading_off_at_no_number_is_refused(question):
    with pytest.raises(InputError, match="a number or an array"):
        power_law_curve().at(**question)


@pytest.mark.parametrize("question", [{}, {"pressure": 1e5, "separation": 1e-6}])
def test_one_question_at_a_time(question):
    with pytest.raises(InputError, match="one of pressure, load, separation"):
        power_law_curve().at(**question)


@pytest.mark.parametrize(
    "question",
    [
        {"pressure": 1e9},
        {"pressure": -1.0},
        {"separation": 1.0},
    ],
)
def test_reading_off_outside_the_curve_is_refused(question):
    with pytest.raises(InputError, match="outside the converged curve"):
        power_law_curve().at(**question)


def test_the_columns_of_a_curve_are_its_own_and_stay_as_they_are():
    spots = np.arange(3.0)
    curve = dataclasses.replace(power_law_curve(3), extra={"spots": spots})
    spots[0] = 7.0
    other = dataclasses.replace(curve, model="other")
    assert other.extra["spots"].tolist() == [0.0, 1.0, 2.0]
    for column in (curve.load, curve.converged, other.extra["spots"], curve.select([0]).load):
        with pytest.raises(ValueError, match="read-only"):
            column[0] = 1.0


@pytest.mark.parametrize(
    "wrong", [{"load": ["a", "b"]}, {"load": [1j, 2.0]}, {"extra": {"load": [None, {}]}}]
)
def test_columns_that_no_file_holds_are_refused(wrong):
    with pytest.raises(InputError, match=r"^load is "):
        dataclasses.replace(power_law_curve(2), **wrong)


def test_reasons_are_as_many_as_points():
    assert dataclasses.replace(power_law_curve(2), reasons=["", "no"]).reasons == ("", "no")
    with pytest.raises(InputError, match=r"reasons has shape \(1,\); expected \(2, ...\)"):
        dataclasses.replace(power_law_curve(2), reasons=("no",))


def test_columns_of_unequal_length_are_refused():
    with pytest.raises(InputError, match=r"load has shape \(3,\); expected \(2,\)"):
        ContactCurve(**{n: np.zeros(3 if n == "load" else 2) for n in POINT_FIELDS}, model="x")


def test_print_tells_the_points_that_failed():
    text = str(power_law_curve(broken=3))
    assert "12 points, 11 converged" in text
    assert "point 3: stopped" in text


def test_a_notebook_shows_what_is_printed():
    assert repr(power_law_curve()) == str(power_law_curve())


def test_points_are_selected_by_number_or_mask():
    curve = power_law_curve()
    np.testing.assert_array_equal(curve.select([2, -1]).load, curve.load[[2, 11]])
    np.testing.assert_array_equal(curve.select(curve.load > 1.0).load, curve.load[curve.load > 1.0])
    assert len(curve.select(3)) == 1 and len(curve.select([])) == 0


@pytest.mark.parametrize("points", [[12], [True, False], 1.5, "first", [[0, 1]], [[0], [1, 2]]])
def test_points_that_are_none_are_refused(points):
    with pytest.raises(InputError, match="numbered 0 to 11"):
        power_law_curve().select(points)


def test_what_one_run_did_not_find_out_is_not_known_of_its_points():
    first = power_law_curve(3)
    told = {**first.extra, "interaction_difference": np.array([0.1, 0.2, 0.3])}
    second = dataclasses.replace(first, extra=told)
    for one, other, known in ((first, second, slice(3, 6)), (second, first, slice(0, 3))):
        found = one.joined(other).extra["interaction_difference"]
        np.testing.assert_array_equal(found[known], [0.1, 0.2, 0.3])
        assert np.isnan(np.delete(found, np.arange(6)[known])).all()


def test_a_curve_is_joined_to_a_later_one_of_the_same_run():
    """What either warns of is kept; the verification of one is not that of all."""
    facts = {"input": "map 1", "warnings": ["tilted", "rough"], "verification": {"met": True}}
    first, second = (
        dataclasses.replace(power_law_curve(3), settings={**facts, "warnings": warned})
        for warned in (["tilted", "rough"], ["rough", "light"])
    )
    joined = first.joined(second)
    assert joined.settings["warnings"] == ["tilted", "rough", "light"]
    assert joined.verification is None and joined.settings["input"] == "map 1"
    others = {"model": "bem"}, {"settings": {**facts, "input": "map 2"}}
    for other in others:
        with pytest.raises(InputError, match="does not belong to"):
            first.joined(dataclasses.replace(second, **other))
    with pytest.raises(InputError, match="a contact curve is needed, not int"):
        first.joined(3)


def test_a_figure_of_runs_at_pressures_and_at_separations_goes_from_light_to_heavy():
    curve = power_law_curve(6)
    runs = (
        dataclasses.replace(curve, extra={f"asked_{name}": getattr(curve, column)}).select(points)
        for name, column, points in (
            ("pressure", "mean_pressure", [4, 0, 2]),
            ("separation", "separation", [5, 1, 3]),
        )
    )
    (line,) = ContactCurve.joined(*runs).plot("load", "area_fraction", Figure().subplots()).lines
    np.testing.assert_array_equal(line.get_xdata(), curve.load)


def test_csv_holds_the_columns(tmp_path):
    write_csv(tmp_path / "c.csv", {"x": np.array([1.5, 2.0]), "n": np.array([1, 2])})
    assert (tmp_path / "c.csv").read_text().split() == ["x,n", "1.5,1", "2.0,2"]


def test_csv_is_utf8_wherever_it_is_written(tmp_path):
    """Reasons and names hold letters that the encoding of a plain C locale does not have."""
    code = f"from asperity.results.storage import write_csv; write_csv({str(tmp_path / 'c')!r}, "
    code += "{'reason': [chr(181) + 'm']})"
    plain = os.environ | {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}
    subprocess.run([sys.executable, "-c", code], env=plain, check=True)
    assert (tmp_path / "c").read_text(encoding="utf-8").split() == ["reason", "\N{MICRO SIGN}m"]
