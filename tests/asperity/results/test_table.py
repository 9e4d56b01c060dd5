"""The table of a curve: columns, frames, CSV, figures, and points that did not converge."""

from __future__ import annotations

import csv
import dataclasses
import warnings

import h5py
import matplotlib
import numpy as np
import pandas
import pytest
from matplotlib.figure import Figure

import asperity
from asperity.errors import InputError
from asperity.halfspace.scene import pressure_scale
from asperity.results.curve import ContactCurve
from asperity.results.interpolation import POINT_FIELDS
from asperity.results.resume import run_resumably
from surfaces import self_affine

STEEL = asperity.HalfSpace(210e9, 0.3)
HEAVY = 1e12
"""Mean pressure [Pa] that no model of separate contacts carries."""


@pytest.fixture(scope="module")
def hm():
    return self_affine((48, 64), (96e-6, 64e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6, seed=1)


@pytest.fixture(scope="module")
def curve(hm) -> ContactCurve:
    """Four points, of which the third is refused."""
    return asperity.contact_curve(hm, STEEL, pressures=[1e7, 1e9, HEAVY, 3e8])


@pytest.fixture(scope="module")
def judge(hm) -> ContactCurve:
    return asperity.bem_curve(hm, STEEL, pressures=[1e8, 1e9, 3e8])


def is_answer(name):
    how = ("asked_", "iterations", "fft_pairs", "seconds", "load_error", "complement", "penetr")
    return not name.startswith(("converged", "residual", "reason", *how))


def test_a_point_that_did_not_converge_has_its_reason_and_no_answer(curve, tmp_path):
    """In the object, the frame, the CSV and the results file; the load asked for stays."""
    assert curve.converged.tolist() == [True, True, False, True]
    curve.to_csv(tmp_path / "c.csv")
    curve.to_hdf5(tmp_path / "r.h5")
    with h5py.File(tmp_path / "r.h5") as file:
        group = file["curves/asperity"]
        stored = {name: part[:] for name, part in group.items() if isinstance(part, h5py.Dataset)}
        stored |= {name: part[:] for name, part in group["extra"].items()}
    stored["reason"] = np.char.decode(stored.pop("reasons"))
    outputs = (
        curve.to_dataframe(),
        pandas.read_csv(tmp_path / "c.csv"),
        pandas.DataFrame(stored),
    )
    for frame in outputs:
        for name in filter(is_answer, frame.columns):
            assert np.isnan(frame[name][2]), name
        assert set(POINT_FIELDS) <= set(frame.columns)
        assert frame.asked_pressure[2] == HEAVY and "separate" in frame.reason[2]
        assert np.isfinite(frame.residual[2]) and not frame.converged[2]
        touching = frame.loc[[0, 1, 3]]
        np.testing.assert_allclose(
            touching.mean_contact_pressure, touching.load / touching.contact_area, rtol=1e-12
        )


def test_a_file_of_an_earlier_version_is_read(curve, tmp_path):
    """It has answers at every point, whole counts of contacts and no load points asked for."""
    curve.to_hdf5(tmp_path / "r.h5")
    with h5py.File(tmp_path / "r.h5", "r+") as file:
        group = file["curves/asperity"]
        for name in ("mean_contact_pressure", "extra/asked_pressure", "contacts", "load"):
            del group[name]
        group["contacts"], group["load"] = np.array([2, 5, 9, 3]), np.array([1.0, 2.0, 3.0, 1.5])
    back = asperity.read_results(tmp_path / "r.h5").curves["asperity"]
    assert back.asked == {} and back.contacts[1] == 5 and np.isnan(back.load[2])
    assert "asked_pressure" not in back.to_dataframe()


def test_the_frame_holds_what_the_curve_holds(curve):
    frame = curve.to_dataframe()
    for name, values in {**{n: getattr(curve, n) for n in POINT_FIELDS}, **curve.extra}.items():
        np.testing.assert_array_equal(frame[name], values)
    assert frame.attrs["model"] == "asperity" and frame.attrs["settings"]["map"]["shape"] == [
        48,
        64,
    ]


def test_csv_gives_back_every_number(judge, tmp_path):
    judge.to_csv(tmp_path / "c.csv", dimensionless=True)
    with open(tmp_path / "c.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for name, values in judge.columns(dimensionless=True).items():
        if values.dtype.kind in "if":
            back = [float(row[name] or "nan") for row in rows]
            np.testing.assert_array_equal(back, values, err_msg=name)


def test_axes_of_two_curves_suit_both(judge):
    """A curve over a decade of separations does not hide what another has below zero."""
    n = len(judge)
    apart, below = (
        dataclasses.replace(judge, separation=1e-6 * np.linspace(5.0, least, n), extra={})
        for least in (0.1, -1.0)
    )
    for curves in ((apart, below), (below, apart)):
        ax = Figure().add_subplot()
        for curve in curves:
            curve.plot("separation", "mean_pressure", ax)
        assert ax.get_xscale() == "linear" and ax.get_yscale() == "log"
    assert apart.plot("separation", "load", Figure().add_subplot()).get_xscale() == "log"


@pytest.mark.parametrize(
    ("x", "y"), [("separation", "mean_pressure"), ("mean_pressure", "separation")]
)
def test_where_the_error_is_not_bounded_no_band_is_drawn(judge, x, y):
    """And nothing is warned of, also where it is of no load."""
    lightest = judge.mean_pressure == judge.mean_pressure.min()
    odd = dataclasses.replace(
        judge,
        mean_pressure=np.where(lightest, 0.0, judge.mean_pressure),
        error_estimate=np.where(lightest, np.inf, judge.error_estimate),
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ax = odd.plot(x, y, Figure().add_subplot())
    (band,) = ax.collections
    assert np.isfinite(np.concatenate([path.vertices for path in band.get_paths()])).all()


def test_a_file_gives_back_the_settings(curve, judge, tmp_path):
    for one in (curve, judge):
        one.to_hdf5(tmp_path / "r.h5")
        assert ContactCurve.from_hdf5(tmp_path / "r.h5").settings == one.settings


def test_dimensionless_columns_do_not_depend_on_units(hm, judge):
    """Lengths times s and stresses times t: the same contact."""
    large = hm.replace(heights=hm.heights * 1e3, spacing=tuple(1e3 * d for d in hm.spacing))
    soft = asperity.HalfSpace(210e6, 0.3)
    pressures = judge.asked["asked_pressure"] / 1e3
    other = asperity.bem_curve(large, soft, pressures=pressures).columns(dimensionless=True)
    own = judge.columns(dimensionless=True)
    for name in filter(lambda name: name.endswith("_dimensionless"), own):
        np.testing.assert_allclose(other[name], own[name], rtol=1e-5)
    np.testing.assert_allclose(
        own["mean_pressure_dimensionless"] * pressure_scale(hm, STEEL), judge.mean_pressure
    )
    np.testing.assert_allclose(own["separation_dimensionless"] * hm.rms_height, judge.separation)
    without = dataclasses.replace(judge, settings={})
    with pytest.raises(InputError, match="make it again"):
        without.to_dataframe(dimensionless=True)


def test_load_points_come_back_as_they_were_asked(hm, curve, judge):
    asked = [2e-6, 1.5e-6, 1e-6]
    for run in (asperity.contact_curve, asperity.bem_curve):
        found = run(hm, STEEL, separations=asked)
        np.testing.assert_array_equal(found.asked["asked_separation"], asked)
    found = asperity.solve(hm, STEEL, pressures=np.geomspace(1e7, 1e9, 8), engine="anchored")
    np.testing.assert_array_equal(found.asked["asked_pressure"], np.geomspace(1e7, 1e9, 8))


def test_a_refused_point_is_solved_again_by_a_run_that_goes_on(hm, curve, tmp_path):
    """Its load is known by what was asked for, though its answers are NaN."""
    loads = curve.asked["asked_pressure"]
    solved = []

    def solve(values, keep, _):
        solved.append(values.tolist())
        return asperity.contact_curve(hm, STEEL, pressures=values, checkpoint=keep)

    for _ in range(2):
        whole = run_resumably(
            solve, loads, "pressure", tmp_path / "r.h5", model="asperity", request={}, resume=True
        )
        np.testing.assert_array_equal(whole.asked["asked_pressure"], loads)
    assert solved == [loads.tolist(), [HEAVY]]


def test_two_runs_join_with_a_point_that_failed(hm, curve):
    joined = curve.joined(asperity.contact_curve(hm, STEEL, pressures=[2e8]))
    assert len(joined) == 5 and np.isnan(joined.load).tolist() == [False, False, True, False, False]


def test_what_is_read_off_states_its_errors(curve, hm):
    point = curve.at(pressure=curve.mean_pressure[[0, 3]])
    assert point.error_estimate == pytest.approx(curve.error_estimate[[0, 3]])
    stated = curve.extra["area_error_estimate"][[0, 3]]
    middle = curve.at(pressure=0.5 * curve.mean_pressure[[0, 3]].sum())
    assert stated.min() <= middle.area_error_estimate <= stated.max()
    assert np.isnan(
        asperity.contact_curve(hm, STEEL, law="hertz").at(area_fraction=0.01).error_estimate
    )


@pytest.mark.parametrize("name", ["load", "separation", "area_fraction"])
def test_reading_off_at_any_column_is_reading_off_at_the_pressure(curve, name):
    there = curve.at(pressure=5e8)
    back = curve.at(**{name: getattr(there, name)})
    for other in ("mean_pressure", "load", "separation", "area_fraction", "mean_contact_pressure"):
        assert getattr(back, other) == pytest.approx(getattr(there, other), rel=0.1)
    assert getattr(back, name) == getattr(there, name)
    with pytest.raises(InputError, match=f"{name} .*[^ ] lies outside the .*[^ ]; add load points"):
        curve.at(**{name: 10.0 * getattr(curve, name)[1] + 1.0})


def test_comparison_verification_and_conductance_with_a_point_that_failed(hm, curve):
    found = asperity.constriction_conductance(curve, resistivity=(1e-7, 1e-7))
    assert np.isnan(found).tolist() == (~curve.converged).tolist()
    both = asperity.compare(hm, STEEL, pressures=[1e8, HEAVY], tolerance=1e-3)
    assert np.isnan(both.table["area_model"]).tolist() == [False, True]
    assert both.table["mean_pressure"].tolist() == pytest.approx([1e8, HEAVY])
    assert both.map_point == 0 and not both.converged


def test_a_reference_that_misses_a_point_leaves_the_others_to_be_compared(hm):
    whole = asperity.bem_curve(hm, STEEL, pressures=[1e8, 3e8, 1e9], tolerance=1e-3)
    broken = dataclasses.replace(
        whole, converged=np.array([True, False, True]), reasons=("", "stopped", "")
    )
    both = asperity.compare(
        hm, STEEL, pressures=[1e8, 3e8, 1e9], tolerance=1e-3, reference=lambda: broken
    )
    assert np.isnan(both.table["area_error"]).tolist() == [False, True, False]
    assert np.isnan(both.table["load_error"]).tolist() == [False, True, False]
    assert both.model.mean_pressure[1] == pytest.approx(3e8, rel=1e-3)


@pytest.mark.parametrize(
    ("x", "y", "labels"),
    [
        ("mean_pressure", "area_fraction", ("mean pressure [MPa]", "real contact area [%]")),
        ("separation", "mean_pressure", ("separation [µm]", "mean pressure [MPa]")),
        ("load", "separation", ("load [N]", "separation [µm]")),
    ],
)
def test_a_figure_shows_points_and_band_in_common_units(curve, x, y, labels):
    ax = Figure().add_subplot()
    assert curve.plot(x, y, ax, color="k", label="steel") is ax
    assert (ax.get_xlabel(), ax.get_ylabel()) == labels
    (line,), (band,) = ax.lines, ax.collections
    assert line.get_label() == "steel" and np.isnan(line.get_ydata()[-1])
    drawn = np.array(line.get_xydata())[:3]
    units = {"mean_pressure": 1e-6, "separation": 1e6, "area_fraction": 100.0, "load": 1.0}
    order = [0, 3, 1]
    np.testing.assert_allclose(drawn[:, 0], getattr(curve, x)[order] * units[x])
    np.testing.assert_allclose(drawn[:, 1], getattr(curve, y)[order] * units[y])
    name = "area_error_estimate" if y == "area_fraction" else "error_estimate"
    off = getattr(curve, name, None) if name == "error_estimate" else curve.extra[name]
    wide = 0 if x == "load" else 1
    edge = np.concatenate([path.vertices for path in band.get_paths()])[:, wide]
    assert edge.max() == pytest.approx((drawn[:, wide] * (1 + off[order])).max(), rel=1e-12)


def test_a_figure_without_axes_has_its_own_and_no_band_if_none_is_wanted(curve):
    matplotlib.use("Agg")
    from matplotlib import pyplot

    ax = curve.plot(band=False)
    assert not ax.collections and ax.get_xscale() == ax.get_yscale() == "log"
    pyplot.close(ax.figure)
    for name in ("nothing", "reason", ["load"]):
        with pytest.raises(InputError, match=r"y is .*; choose one of .*load"):
            curve.plot(y=name)


def test_a_word_is_no_switch(curve):
    with pytest.raises(InputError, match="dimensionless is 'no'; it must be True or False"):
        curve.columns(dimensionless="no")
    with pytest.raises(InputError, match="band is 'no'; it must be True or False"):
        curve.plot(band="no")


def test_a_notebook_shows_table_figure_and_reason_escaped(curve):
    odd = dataclasses.replace(curve, model="<b>", reasons=("", "", "1 < 2", ""))
    page = odd._repr_html_()
    assert "&lt;b&gt;" in page and "1 &lt; 2" in page and "data:image/png;base64" in page
    assert page.count("<tr>") == 5 and "nan" in page


def test_what_is_printed_names_the_contact_pressure(curve):
    assert "contact mean" in str(curve) and "point 2:" in str(curve)


def test_tables_are_read_by_pandas_alone(hm, tmp_path):
    """As they come, and from a results file: every field is one column."""
    both = asperity.compare(hm, STEEL, pressures=[1e9], tolerance=1e-3)
    both.to_hdf5(tmp_path / "r.h5")
    with h5py.File(tmp_path / "r.h5") as file:
        read = {name: pandas.DataFrame(table[:]) for name, table in file["tables"].items()}
        for name in ("asperity", "bem"):
            group = file[f"curves/{name}"]
            for field in (*POINT_FIELDS, "mean_contact_pressure"):
                assert len(pandas.Series(group[field][:])) == 1
    contacts = pandas.DataFrame(both.microcontacts)
    assert set(read) == {"comparison", "pareto", "microcontacts", "resolution"}
    assert list(read["microcontacts"]) == list(contacts)
    assert [f"radii_{i}" in contacts for i in (0, 15, 16)] == [True, True, False]


def test_progress_is_a_bar_or_a_function(hm, capsys):
    calls = []
    asperity.contact_curve(hm, STEEL, pressures=[1e8, 1e9], progress=calls.append)
    asperity.bem_curve(hm, STEEL, pressures=[1e8], tolerance=1e-3, progress=calls.append)
    asperity.solve(hm, STEEL, pressures=[1e8], progress=calls.append)
    asperity.hardness_sweep(hm, STEEL, [1e10], pressures=[1e8], progress=calls.append)
    asperity.compare(hm, STEEL, pressures=[1e8], tolerance=1e-3, progress=calls.append)
    assert len(calls) >= 9 and calls[-1].endswith("refined grid") and not capsys.readouterr().err
    asperity.contact_curve(hm, STEEL, pressures=[1e8, 1e9], progress=True)
    asperity.bem_curve(hm, STEEL, pressures=[1e8], tolerance=1e-3, progress=True)
    assert "load points" in capsys.readouterr().err


def test_columns_of_several_numbers_in_tables_of_earlier_versions_are_parted(curve, tmp_path):
    """So were the radii of a contact."""
    curve.to_hdf5(tmp_path / "r.h5")
    old = np.zeros(3, [("x", float), ("radii", float, (16,))])
    old["radii"] = np.arange(16.0)
    with h5py.File(tmp_path / "r.h5", "r+") as file:
        file["tables/microcontacts"] = old
    frame = pandas.DataFrame(asperity.read_results(tmp_path / "r.h5").tables["microcontacts"])
    assert frame.shape == (3, 17) and (frame.radii_7 == 7.0).all()
