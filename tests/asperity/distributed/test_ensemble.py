"""Ensembles: bands of known members, stops that no worker changes, windows read one by one."""

from __future__ import annotations

import json
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import stats

import asperity
import surfaces
from asperity.cli.main import main
from asperity.distributed.bands import mean_and_scatter, relative_half_width
from asperity.distributed.ensemble import enough, windows_of

from .conftest import LOADS, MAKE, STEEL

HEIGHTS = st.floats(-1e3, 1e3).map(lambda x: round(x, 3))


@settings(deadline=None)  # the first example imports scipy.stats
@given(arrays(float, st.tuples(st.integers(2, 12), st.just(3)), elements=HEIGHTS))
def test_the_interval_is_that_of_student(curves):
    mean, deviation, half_width = mean_and_scatter(curves)
    np.testing.assert_allclose(mean, curves.mean(axis=0), atol=1e-9)
    np.testing.assert_allclose(deviation, curves.std(axis=0, ddof=1), atol=1e-7)
    for column, half in zip(curves.T, half_width, strict=True):
        if np.ptp(column) > 1e-3:
            low, high = stats.t.interval(
                0.95, len(column) - 1, loc=column.mean(), scale=stats.sem(column)
            )
            assert half == pytest.approx(0.5 * (high - low), rel=1e-6)


@pytest.mark.parametrize("members", [12, 25, 50])
def test_the_band_asked_for_holds_the_mean_as_often_as_it_says(members):
    """4000 ensembles of scatter 0.3, of which about so many members tell enough."""
    until, draws = 1.96 * 0.3 / members**0.5, np.random.default_rng(0)
    curves = 1.0 + 0.3 * draws.standard_normal((2 * members + 20, 4000))
    widths, means = [], []
    for count in range(1, len(curves) + 1):
        mean, _, half_width = mean_and_scatter(curves[:count])
        widths.append(half_width / mean)
        means.append(mean)
    held = 0
    for of_one, mean_of_one in zip(np.transpose(widths), np.transpose(means), strict=True):
        last = next(n for n in range(10, len(of_one) + 1) if enough(of_one[:n], until))
        held += abs(mean_of_one[last - 1] - 1.0) <= until * mean_of_one[last - 1]
    assert held >= 0.95 * 4000


def test_points_that_did_not_converge_are_left_out():
    curves = np.array([[1.0, np.nan], [3.0, 5.0], [np.nan, 7.0]])
    mean, _, half_width = mean_and_scatter(curves)
    assert mean.tolist() == [2.0, 6.0]
    for column, half in zip(([1.0, 3.0], [5.0, 7.0]), half_width, strict=True):
        assert half == pytest.approx(stats.t.ppf(0.975, 1) * stats.sem(column), rel=1e-12)
    nothing = np.full((1, 1), np.nan)
    assert relative_half_width(nothing) == np.inf and np.isnan(mean_and_scatter(nothing)[2][0])


def test_the_mean_is_that_of_the_curves(here, tmp_path):
    found = asperity.ensemble(MAKE, STEEL, LOADS, folder=tmp_path, seeds=5)
    for name in ("separation", "area_fraction", "contacts"):
        curves = [getattr(found.sweep.curve(row), name) for row in range(5)]
        np.testing.assert_allclose(found.table[name], np.mean(curves, axis=0), rtol=1e-3)
        np.testing.assert_allclose(
            found.table[f"{name}_p90"], np.quantile(curves, 0.9, axis=0), rtol=1e-3
        )
    frame = found.to_dataframe()
    assert str(frame.members.tolist()) == "[5, 5]"  # which 5.0 is not, in CSV and JSON
    assert (frame.area_fraction_p10 < frame.area_fraction_p90).all()
    assert {"ensemble.csv", "convergence.csv", "ensemble.h5", "index.csv"} <= {
        path.name for path in tmp_path.iterdir()
    }


def test_members_are_added_until_the_mean_is_known(here, tmp_path):
    every = asperity.ensemble(MAKE, STEEL, LOADS, folder=tmp_path, seeds=30)
    until = float(every.convergence[14])
    narrow = 10 + np.flatnonzero(every.convergence[9:] <= until)
    some = asperity.ensemble(MAKE, STEEL, LOADS, folder=tmp_path / "some", seeds=30, until=until)
    assert len(some) == narrow[4] < 30 and some.met
    assert np.array_equal(some.convergence, every.convergence[: narrow[4]])
    never = asperity.ensemble(MAKE, STEEL, LOADS, folder=tmp_path, seeds=30, until=1e-9)
    assert not never.met and np.array_equal(never.table, every.table)


def test_which_members_are_taken_does_not_depend_on_the_workers(without_dask, request, tmp_path):
    run = partial(asperity.ensemble, MAKE, STEEL, LOADS, seeds=30, until=0.35)
    found = run(folder=tmp_path / "two", workers=2)
    request.getfixturevalue("here")
    alone = run(folder=tmp_path / "alone")
    assert found.met and 10 <= len(found) < 30
    assert found.table.tobytes() == alone.table.tobytes()
    assert found.convergence.tobytes() == alone.convergence.tobytes()


def test_a_member_that_fails_is_left_out_and_told(here, maps, tmp_path):
    files = maps(3)
    files[1].write_text("no map")
    found = asperity.ensemble(files, STEEL, LOADS, folder=tmp_path / "out")
    assert len(found) == 2 and found.sweep.failed.tolist() == [1]
    assert "m1.h5" in str(found) and "2 members, 1 failed" in str(found)
    with pytest.raises(asperity.ConvergenceError, match=r"1 of 2 members have a curve: .*HDF5"):
        asperity.ensemble(files[:2], STEEL, LOADS, folder=tmp_path / "out")


@given(st.integers(3, 60), st.integers(3, 60), st.integers(3, 70), st.integers(3, 70))
def test_windows_cut_a_map_without_overlap(ny, nx, high, wide):
    if high > ny or wide > nx:
        with pytest.raises(asperity.InputError, match="do not fit"):
            windows_of((ny, nx), (high, wide))
        return
    seen = np.zeros((ny, nx), int)
    places = windows_of((ny, nx), (high, wide))
    for rows, columns in places:
        seen[slice(*rows), slice(*columns)] += 1
    assert len(places) == (ny // high) * (nx // wide) and seen.max() == 1
    assert seen.sum() == len(places) * high * wide


def test_windows_of_a_large_map_are_read_one_by_one(here, tmp_path, monkeypatch):
    hm = surfaces.self_affine((96, 80), (96e-6, 80e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    surfaces.write(hm, tmp_path / "large.h5")
    read, asked = surfaces.read, []
    heights = surfaces.SurfaceFile.heights

    def noted(self, rows=None, columns=None):
        asked.append((rows[1] - rows[0], columns[1] - columns[0]))
        return heights(self, rows, columns)

    monkeypatch.setattr(surfaces.SurfaceFile, "heights", noted)
    settings = {**LOADS, "prepare": {"level": "plane"}}
    found = asperity.ensemble(
        tmp_path / "large.h5", STEEL, settings, folder=tmp_path / "out", windows=(48, 40)
    )
    assert len(found) == 4 and set(asked) == {(48, 40)}
    rows, columns = windows_of(hm.shape, (48, 40))[0]
    first = surfaces.prepare(read(tmp_path / "large.h5", rows=rows, columns=columns))
    assert found.sweep.curve(0).settings["input"] == first.digest


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"seeds": 3, "windows": 8}, "seeds or windows"),
        ({"until": 0.0, "seeds": 3}, "until is 0.0; give a relative half width"),
        ({"windows": 8}, "windows are of an HDF5 file"),
        ({"settings": {"loads": [1.0]}, "seeds": 3}, "leave out loads"),
        ({"settings": {"pressures": [0.0, 1e8]}, "seeds": 3}, "must be positive"),
        ({"seeds": []}, "at least one surface"),
        ({"seeds": 2.5}, "give a whole number"),
        ({"seeds": 0}, "at least 1"),
        ({"settings": {"pressures": "high"}, "seeds": 3}, "an array of numbers"),
        ({"settings": 3, "seeds": 3}, "settings is 3; an ensemble is of one"),
        ({"settings": [LOADS, LOADS], "seeds": 3}, "an ensemble is of one"),
        ({"material": [STEEL, STEEL], "seeds": 3}, "an ensemble is of one"),
        ({"settings": {"prepare": 3}, "seeds": 3}, "the keywords of surfaces.prepare"),
        ({"folder": 3, "seeds": 3}, "the path of a file"),
    ],
)
def test_bad_arguments_are_refused_in_one_sentence(change, match, tmp_path):
    given = {"material": STEEL, "settings": LOADS, "folder": tmp_path / "out"} | change
    with pytest.raises(asperity.InputError, match=match):
        asperity.ensemble(MAKE, **given)
    for windows in ("wide", (8, 8, 8), 8.5, 2):
        with pytest.raises(asperity.InputError, match="windows is"):
            windows_of((48, 64), windows)
    with pytest.raises(asperity.InputError, match="seeds need a function of seed"):
        asperity.ensemble("map.h5", STEEL, folder=tmp_path, seeds=3)
    flat = partial(MAKE, rms_slope=0.0)
    with pytest.raises(asperity.InputError, match="the rms value is 0"):
        asperity.ensemble(flat, STEEL, LOADS, folder=tmp_path, seeds=3)


def test_the_command(here, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    body = ["--E", "210GPa", "--pressure", "100MPa,1GPa"]
    made = [
        "--shape",
        "48",
        "64",
        "--size",
        "48um",
        "64um",
        "--rms-slope",
        "0.1",
        "--cutoff",
        "8um",
    ]
    call = ["ensemble", "--seeds", "12", *made, *body, "-o", "out", "--plot", "mean.png"]
    assert main([*call, "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["results"]
    alone = asperity.ensemble(MAKE, STEEL, LOADS, folder=tmp_path / "alone", seeds=12)
    np.testing.assert_array_equal(
        [row["area_fraction"] for row in rows], alone.table["area_fraction"]
    )
    assert (tmp_path / "mean.png").read_bytes().startswith(b"\x89PNG")
    assert main([*call, "--until", "0.1%", "--force"]) == 1
    assert "NOT MET" in capsys.readouterr().out
    hm = surfaces.self_affine((96, 80), (96e-6, 80e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    surfaces.write(hm, "large.h5")
    assert main(["ensemble", "large.h5", "--windows", "48", "40", *body, "-o", "w"]) == 0
    assert "4 members" in capsys.readouterr().out
    for words, told in (
        (["large.h5", "--seeds", "3"], "name no file"),
        (["large.h5", "--windows", "8", "--crop", "0", "9", "0", "9"], "no --crop"),
        ([], "name files of maps, or give --seeds"),
    ):
        assert main(["ensemble", *words, *body]) == 2
        assert told in capsys.readouterr().err


def test_a_picture_of_the_mean(here, tmp_path):
    found = asperity.ensemble(partial(MAKE), STEEL, LOADS, folder=tmp_path, seeds=3)
    assert found.plot("separation").get_ylabel() == "separation [µm]"
    with pytest.raises(asperity.InputError, match="no column 'speed'; there are separation"):
        found.plot("speed")


def test_equal_pressures_are_one(here, tmp_path):
    loads = {"pressures": [1e9, 1e8, 1e9]}
    found = asperity.ensemble(MAKE, STEEL, loads, folder=tmp_path, seeds=2)
    assert found.pressures.tolist() == [1e9, 1e8]


def test_members_in_full_contact_are_compared(here, tmp_path):
    """Of two loads there a curve read off refused the heavier, and all members were lost."""
    loads = {"method": "bem", "pressures": [1e8, 1e9, 8e10, 1.6e11]}
    found = asperity.ensemble(MAKE, STEEL, loads, folder=tmp_path, seeds=2)
    np.testing.assert_allclose(found.table["area_fraction"][2:], 1.0, rtol=1e-12)
    np.testing.assert_allclose(found.table["separation"][2:], 0.0, atol=1e-20)


def test_a_scatter_that_nobody_knows_is_told(here, tmp_path):
    """Loads of which no member converges: the mean of nothing warned."""
    found = asperity.ensemble(MAKE, STEEL, {"pressures": [1e13, 2e13]}, folder=tmp_path, seeds=2)
    assert "scatter         unknown" in str(found)


@pytest.mark.parametrize("name", ["index.csv", "ensemble.csv"])
def test_a_file_of_another_kind_is_not_replaced(name, here, tmp_path):
    """The table of the jobs, called index.csv, was replaced by the index of the sweep."""
    (tmp_path / name).write_text("file,E\nscan.h5,210e9\n")
    run = partial(asperity.ensemble, MAKE, STEEL, LOADS, folder=tmp_path, seeds=2)
    calls = [run]
    if name == "index.csv":
        calls.append(partial(asperity.sweep, MAKE(seed=0), STEEL, LOADS, folder=tmp_path))
    for call in calls:
        with pytest.raises(asperity.InputError, match=f"{name} is there already, and not of a sw"):
            call()
    assert (tmp_path / name).read_text().startswith("file,E")
    run(force=True)
    assert len(run()) == 2
