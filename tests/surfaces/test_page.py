"""Pages of height maps: units that suit, history in words, maps reduced to what a page can hold."""

from __future__ import annotations

import json
import math
import shutil
import subprocess

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pages import Page

import surfaces
from surfaces.drawing import prefixed_unit, with_unit
from surfaces.history import in_words, preparation_warnings
from surfaces.page import section, write_page
from surfaces.page.fields import reduced, reduction, touched
from surfaces.page.lines import TICKS, Line, line_figure
from surfaces.page.roughness import height_layer
from surfaces.statistics import bearing, correlation, density


@given(st.floats(1e-12, 1e12), st.sampled_from([("Pa", 1), ("m", 1), ("m", 2), ("N", 1)]))
def test_a_suited_unit_gives_numbers_that_are_easily_read(value, unit):
    factor, name = prefixed_unit(value, *unit)
    assert name.rstrip("²").endswith(unit[0])
    largest = math.inf if unit[0] == "m" and factor == 1.0 else 1000 ** unit[1]
    smallest = 0.0 if name.startswith("p") else 1.0
    assert smallest * (1 - 1e-6) <= value / factor < largest * (1 + 1e-6)


def test_an_axis_shows_as_many_digits_as_tell_its_labels_apart():
    """Four digits repeated one number on axes whose values differ less."""
    for rise, kind in (1e-6, "auto"), (100.0, None):
        values = 1e15 * np.linspace(1.0, 1.0 + rise, 5)
        figure = line_figure([Line("a", {"x": np.arange(5.0), "y": values}, "black")], "x", "y")
        assert getattr(figure.yaxis[0].formatter, "precision", None) == kind


@given(st.floats(1e-9, 1e9))
def test_a_quantity_is_told_to_three_digits(value):
    number, unit = with_unit(value, "Pa").split()
    scale = {"n": 1e-9, "µ": 1e-6, "m": 1e-3, "P": 1, "k": 1e3, "M": 1e6, "G": 1e9}[unit[0]]
    assert float(number) * scale == pytest.approx(value, rel=5.1e-3)


def test_what_is_no_number_is_a_dash():
    assert with_unit(math.nan, "Pa") == with_unit(math.inf, "m") == "–"
    assert with_unit(0.0, "m") == "0 m"


def rough(shape=(48, 64)) -> surfaces.HeightMap:
    size = tuple(1e-6 * n for n in shape)
    return surfaces.self_affine(shape, size, hurst=0.8, rms_slope=0.1, cutoff=8e-6, seed=2)


def test_every_step_of_a_preparation_has_words():
    heights = rough().heights.copy()
    heights[3, 4:7], heights[20, 20] = np.nan, 1e-3
    hm = surfaces.HeightMap(heights, 1e-6)
    ready = surfaces.prepare(hm, outliers=8.0, bandpass=(4e-6, None), periodic="taper")
    told_steps = in_words(surfaces.crop(ready, (0, 40), (4, 60)).history)
    for part in ("plane taken off", "spikes beyond", "filled", "from 4 µm", "fade", "Rows 0 to 40"):
        assert sum(part in one for one in told_steps) == 1, (part, told_steps)
    assert len(preparation_warnings(ready.history)) == 1
    large = rough((96, 128)).replace(periodic=False)
    narrow = surfaces.make_periodic(large, "taper", width=2e-6)
    assert not preparation_warnings(narrow.history)


@pytest.mark.parametrize(
    "step", [{"step": "level"}, {"step": "periodic", "how": "x"}, {"a": 1}, {}]
)
def test_a_step_that_is_not_understood_is_listed(step):
    assert len(in_words([step])) == 1 and not preparation_warnings([step])


def test_a_large_map_is_shown_as_means_that_keep_its_mean():
    values = np.random.default_rng(1).normal(size=(600, 1024))
    shown = reduced(values)
    assert shown.shape == (300, 512) and "300 × 512 means" in reduction(values.shape)
    expected = values.reshape(300, 2, 512, 2).mean(axis=(1, 3))
    np.testing.assert_allclose(shown, expected, atol=np.ptp(expected) / 4000)
    spot = np.zeros((600, 1024), bool)
    spot[301, 77] = True
    assert np.argwhere(touched(spot)).tolist() == [[150, 38]]
    small = np.arange(12.0).reshape(3, 4)
    np.testing.assert_allclose(reduced(small), small, atol=12 / 4000)
    assert reduction(small.shape) == ""


def test_a_page_finds_each_curve_once(monkeypatch):
    steps = (bearing, "BearingCurve"), (correlation, "_correlated"), (density, "along_both")
    calls = []
    for module, name in steps:
        whole = getattr(module, name)
        monkeypatch.setattr(module, name, lambda *a, w=whole: calls.append(w.__name__) or w(*a))
    section(rough())
    assert sorted(calls) == ["BearingCurve", "_correlated", "along_both"]


@pytest.mark.filterwarnings("error")
def test_points_that_are_missing_here_and_there_do_not_empty_a_large_map():
    present = np.random.default_rng(1).random((1100, 1100)) < 0.9
    values = np.where(present, np.linspace(-1.0, 1.0, 1100), np.nan)
    shown = reduced(values)
    np.testing.assert_allclose(shown, np.tile(reduced(values[:1, :]), (512, 1)), atol=4e-3)
    values[::2] = np.nan  # every other line
    assert np.isfinite(reduced(values)).mean() > 0.98
    values[:600] = np.nan
    assert np.isnan(reduced(values)[:279]).all()


@pytest.mark.filterwarnings("error")
def test_few_hills_on_a_flat_have_their_colors():
    heights = np.zeros((48, 64))
    heights[5, 7], heights[40, 60] = 1e-6, 2e-6
    hm = surfaces.HeightMap(heights, 1e-6)
    layer = height_layer(hm)
    assert layer.high - layer.low == pytest.approx(2.0, rel=1e-3)
    assert section(hm).parameters["Svc, mean curvature of pits"] == "0 1/m"


def test_a_spike_leaves_the_levels_of_the_other_heights():
    values = np.random.default_rng(1).normal(size=(64, 64))
    values[3, 4] = 1e5
    np.testing.assert_allclose(reduced(values), values, atol=2e-3, rtol=1e-6)


@pytest.mark.skipif(shutil.which("node") is None, reason="no node is installed")
@pytest.mark.parametrize(
    "low, high, expected",
    [
        (0.24, 14.0, [0.5, 1, 2, 5, 10]),
        (14.0, 0.24, [0.5, 1, 2, 5, 10]),
        (0.03, 40.0, [0.1, 1, 10]),
        (3e-25, 2e-9, [10.0**power for power in range(-24, -8, 2)]),
        (2.2, 5.1, [3, 4, 5]),
    ],
)
def test_a_logarithmic_axis_has_numbers_all_along(low, high, expected):
    data = json.dumps({"range": {"start": low, "end": high}})
    code = f"console.log(JSON.stringify(((cb_data) => {{{TICKS}}})({data})))"
    told_by = subprocess.run(["node", "-e", code], capture_output=True, text=True, check=True)
    np.testing.assert_allclose(json.loads(told_by.stdout), expected)


def test_a_page_of_a_map_with_gaps_and_a_hostile_name(tmp_path):
    heights = rough().heights.copy()
    heights[3, 4:7] = np.nan
    hm = surfaces.HeightMap(heights, 1e-6, name="<script>alert(1)</script>")
    write_page([section(hm)], tmp_path / "p.html")
    page = Page(tmp_path / "p.html")
    assert "<script>alert(1)</script>" in page.shown and not page.loads()
    drawn = next(iter(page.figures()["Height map"].values()))["height [µm]"][0]
    np.testing.assert_array_equal(np.isnan(drawn), np.isnan(heights))
