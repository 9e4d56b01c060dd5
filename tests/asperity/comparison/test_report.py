"""The report: one page about any results files, whose figures carry their numbers."""

from __future__ import annotations

import csv
import dataclasses
import html
import io
import re

import numpy as np
import pytest
from pages import BROWSER, Page, browsed

import asperity
from asperity.comparison.report.build import write_report
from asperity.comparison.report.sample import Sample, curve_verdict, read_sample
from asperity.comparison.result import Comparison
from asperity.errors import InputError
from asperity.results.storage import ResultFile, write_results
from surfaces import HeightMap, self_affine

STEEL = asperity.HalfSpace(210e9, 0.3, hardness=5e9)
LOADS = [5e7, 2e8, 1e9]
EVIL = "<script>alert('x')</script> $$\\frac$$ & \"quoted\""


def rough() -> HeightMap:
    hm = self_affine(
        (96, 128), (0.96e-3, 1.28e-3), hurst=0.8, rms_slope=0.1, rolloff=2.4e-4, cutoff=8e-5, seed=3
    )
    taper = {"step": "periodic", "how": "taper", "width": 1e-4, "area_changed": 0.36}
    taper |= {"seam_step": 1e-9, "inner_step": 1e-8}
    evil = {"step": "<b>sanded</b>", "unit": "<i>um</i>"}
    return hm.replace(name=EVIL, history=({"step": "level", "form": "plane"}, taper, evil))


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    return asperity.compare(rough(), STEEL, pressures=LOADS, tolerance=1e-5)


@pytest.fixture(scope="module")
def page(comparison, tmp_path_factory) -> Page:
    path = tmp_path_factory.mktemp("report") / "r.html"
    comparison.to_html(path)
    return Page(path)


def test_the_page_needs_nothing_else(page):
    assert not page.loads()
    assert len(page.text.encode()) < 4e6
    assert page.shown.startswith("Contact report:")


def test_the_verdict_comes_first(page, comparison):
    assert 0 < page.shown.index(comparison.verdict()) < page.shown.index("Load against separation")


def test_the_verdict_of_one_load_speaks_of_one(comparison):
    curve = comparison.reference
    assert re.match("At mean pressures of .*, at separations of ", curve_verdict("bem", curve))
    text = curve_verdict("bem", curve.select([1]))
    assert re.match("At a mean pressure of .*, at a separation of ", text) and text[-1] == "."


def test_text_of_files_is_escaped(page):
    assert EVIL in page.shown and "<b>sanded</b>: unit <i>um</i>" in page.shown
    assert {tag for tag, _ in page.tags}.isdisjoint({"b", "i"})
    assert "<script>alert" not in page.text


def test_every_figure_carries_its_numbers(page, comparison):
    figures = page.figures()
    load, area = figures["Load against separation"], figures["Real contact area against load"]
    for name, curve in (
        ("microcontacts", comparison.model),
        ("boundary elements", comparison.reference),
    ):
        np.testing.assert_allclose(
            load[name]["mean pressure [MPa]"], curve.mean_pressure[::-1] / 1e6
        )
        np.testing.assert_allclose(load[name]["separation [µm]"], curve.separation[::-1] / 1e-6)
        np.testing.assert_allclose(area[name]["real contact area [%]"], 100 * curve.area_fraction)
    assert "microcontacts without hardness" in load
    heights = next(found for title, found in figures.items() if "Height" in title)["mm"]
    shown = heights["height [µm]"][0]
    assert shown.shape == (96, 128)
    expected = rough().heights - rough().heights.mean()
    np.testing.assert_allclose(shown, expected / 1e-6, atol=np.ptp(expected) / 1e-6 / 4000)
    np.testing.assert_array_equal(heights["contact"][0], comparison.maps["bem"])


def test_the_band_is_the_stated_error(page, comparison):
    model = comparison.model
    drawn = page.figures()["Real contact area against load"]["microcontacts"]
    high = np.asarray(drawn["stated area, high"]) / np.asarray(drawn["real contact area [%]"])
    np.testing.assert_allclose(high - 1, model.extra["area_error_estimate"])
    inside = np.abs(comparison.table["load_error"]) <= model.error_estimate
    assert f"within the stated band at {inside.sum()} of 3 loads" in page.shown


def test_pressure_maps_differ_by_the_map_of_differences(page):
    figures = page.figures()
    titles = [f"Pressure, {name}" for name in ("boundary elements", "microcontacts")]
    bem, model = (np.nan_to_num(figures[t]["mm"]["pressure [GPa]"][0]) for t in titles)
    apart = figures["Pressure, microcontacts less boundary elements"]["mm"]["difference [GPa]"][0]
    np.testing.assert_allclose(np.nan_to_num(apart), model - bem, atol=2e-3)
    assert bem.max() <= 5.0 * 1.001


def test_contact_sizes_count_all_contacts_and_their_area(page, comparison):
    sizes = page.figures()["Contact sizes"]
    name = next(name for name in sizes if name.startswith("boundary"))
    assert int(re.search(r"\((\d+)\)", name)[1]) == sizes[name]["contacts at least as large"][0]
    assert sizes[name]["their share [%]"][0] == pytest.approx(100)


def test_what_preparation_changed_is_said(page):
    assert "Levelled: plane taken off." in page.shown
    assert "Tapering altered 36 % of the map" in page.shown


def test_what_made_it_is_said(page, comparison):
    made = comparison.about["made"]
    for fact in (made["date"], made["versions"], comparison.about["input"][:16], "230.8 GPa"):
        assert fact in page.shown


def test_the_reference_is_judged_by_a_grid_twice_as_fine(comparison):
    held = comparison.resolution
    assert held["mean_pressure"] == pytest.approx([LOADS[0], LOADS[-1]], rel=1e-3)
    assert set(held["ny"]) == {192} and set(held["nx"]) == {256}
    # waves of eight pixels: the grid holds the load to some per cent
    assert (np.abs(held["load_error"]) < 0.1).all() and (np.abs(held["area_error"]) < 0.1).all()


def test_the_file_gives_back_the_page(comparison, page, tmp_path):
    comparison.to_hdf5(tmp_path / "r.h5")
    write_report(tmp_path / "again.html", [read_sample(tmp_path / "r.h5")])
    assert Page(tmp_path / "again.html").shown == page.shown


@pytest.mark.parametrize("gone", ["heights", "pressure_bem", "pressure_asperity", "resolution"])
def test_an_earlier_file_is_shown_without_what_it_lacks(comparison, gone, tmp_path):
    held = comparison.to_results()
    held.maps.pop(gone, None)
    held.tables.pop(gone, None)
    for fact in ("made", "rms_slope", "rms_height"):
        held.about.pop(fact)
    write_results(tmp_path / "r.h5", held)
    write_report(tmp_path / "r.html", [read_sample(tmp_path / "r.h5")])
    found = Page(tmp_path / "r.html")
    assert "rms slope" not in found.shown.split("Input and run")[1]
    figures = found.figures()
    assert ("Power spectrum" in figures) == (gone != "heights")
    assert ("Pressure, microcontacts" in figures) == (not gone.startswith("pressure"))


def curves(tmp_path):
    """Files of curve, bem and solve, as the commands write them."""
    hm = rough()
    made = {
        "curve": [asperity.contact_curve(hm, STEEL, pressures=LOADS)],
        "bem": [asperity.bem_curve(hm, STEEL, pressures=LOADS, tolerance=1e-4)],
        "solve": [asperity.solve(hm, STEEL, pressures=LOADS, accuracy=0.1)],
    }
    request = {"command": "curve", "modulus": STEEL.modulus, "m": 0.0, "input": hm.digest}
    for name, held in made.items():
        records = {one.model: one for one in held}
        write_results(tmp_path / f"{name}.h5", ResultFile(records, about={"request": request}))
    return [tmp_path / f"{name}.h5" for name in made]


def test_curves_of_any_command_and_several_side_by_side(comparison, tmp_path):
    files = curves(tmp_path)
    comparison.to_hdf5(tmp_path / "compare.h5")
    for file in files:
        write_report(tmp_path / "one.html", [read_sample(file)])
        found = Page(tmp_path / "one.html")
        assert len(found.figures()) == 2 and "modulus E* 230.8 GPa" in found.shown
        assert "Where it touches" not in found.shown
    names = [*files, tmp_path / "compare.h5", tmp_path / "compare.h5"]
    write_report(tmp_path / "all.html", [read_sample(file) for file in names])
    found = Page(tmp_path / "all.html")
    assert "Side by side" in found.shown and "contact area at 50 MPa" in found.shown
    lines = found.figures()["Load against separation"]
    assert {"curve: microcontacts", "bem: boundary elements"} <= {
        name.removeprefix(f"{EVIL.replace('$$', '$ $')}, ") for name in lines
    }
    assert len(lines) == len(names)  # of so many the first curve of each
    write_report(tmp_path / "two.html", [read_sample(file) for file in names[-2:]])
    assert len(Page(tmp_path / "two.html").figures()["Load against separation"]) == 2 * 3


def test_points_that_did_not_converge_are_left_out_with_their_reason(comparison, tmp_path):
    converged = comparison.model.converged.copy()
    converged[1] = False
    model = dataclasses.replace(
        comparison.model, converged=converged, reasons=("", "contacts fill the cell", "")
    )
    dataclasses.replace(comparison, model=model).to_html(tmp_path / "r.html")
    found = Page(tmp_path / "r.html")
    assert "Some load points did not converge" in found.shown
    assert "load point 2: contacts fill the cell" in found.shown
    assert len(found.figures()["Load against separation"]["microcontacts"]["contacts"]) == 2


def test_errors_that_are_not_stated_are_dashes(comparison, tmp_path):
    extra = {k: v for k, v in comparison.model.extra.items() if k != "area_error_estimate"}
    model = dataclasses.replace(comparison.model, extra=extra)
    dataclasses.replace(comparison, model=model).to_html(tmp_path / "r.html")
    found = Page(tmp_path / "r.html")
    assert "Area at equal load: boundary" not in found.shown
    assert "stated area, low" not in found.figures()["Real contact area against load"]


def test_nothing_converged_is_a_page_as_well(comparison, tmp_path):
    none = np.zeros(3, bool)
    curve = dataclasses.replace(comparison.model, converged=none, reasons=("no",) * 3)
    write_report(tmp_path / "r.html", [Sample("x", {"microcontacts": curve}, {})])
    assert "No load point" in Page(tmp_path / "r.html").shown


def test_the_verdict_of_one_load_is_of_one_load(comparison):
    found = curve_verdict("bem", comparison.reference.select([1]))
    assert "At a mean pressure of 200 MPa" in found and "at a separation of" in found
    assert "At mean pressures of 50 MPa to 1 GPa" in curve_verdict("bem", comparison.reference)


def test_a_file_without_curves_is_refused(tmp_path):
    write_results(tmp_path / "r.h5", ResultFile())
    with pytest.raises(InputError, match="holds no curve"):
        read_sample(tmp_path / "r.h5")


def test_provenance_is_kept_when_a_file_is_written_again(comparison, tmp_path):
    comparison.model.to_hdf5(tmp_path / "c.h5")
    held = asperity.read_results(tmp_path / "c.h5")
    held.about["made"]["date"] = "then"
    write_results(tmp_path / "d.h5", held)
    assert asperity.read_results(tmp_path / "d.h5").about["made"]["date"] == "then"


@pytest.mark.skipif(BROWSER is None, reason="no chromium is installed")
def test_a_browser_draws_all_figures_and_saves_their_numbers(comparison, page, tmp_path):
    """Also on a phone: nothing is wider than the window."""
    comparison.to_html(tmp_path / "r.html")
    script = """() => {
      const drawn = [...document.querySelectorAll('.plot')].filter((one) => one.offsetHeight > 100);
      const button = document.querySelector('button[data-plot]');
      const map = document.querySelector('button[data-name^=Height]');
      return [drawn.length, document.documentElement.scrollWidth <= innerWidth,
        csv(button.dataset.plot), csv(map.dataset.plot)].join('\\u2029');
    }"""
    told, console = browsed(tmp_path / "r.html", script, "--window-size=500,900")
    drawn, narrow, curve, heights = html.unescape(told).split("\u2029")
    assert int(drawn) == len(page.figures()) and narrow == "true"
    assert "Uncaught" not in console and "rror" not in console, console
    rows = list(csv.DictReader(io.StringIO(curve)))
    assert {row["curve"] for row in rows} >= {"microcontacts", "boundary elements"}
    model = [float(row["mean pressure [MPa]"]) for row in rows if row["curve"] == "microcontacts"]
    np.testing.assert_allclose(model, comparison.model.mean_pressure[::-1] / 1e6, rtol=1e-9)
    cells = np.loadtxt(io.StringIO(heights), delimiter=",", skiprows=1)
    assert cells.shape == (96 * 128, 4)
    np.testing.assert_allclose(cells[:2, :2], [[0.005, 0.005], [0.015, 0.005]], rtol=1e-9)
    surface = comparison.surface.heights / 1e-6
    np.testing.assert_allclose(cells[:, 2], surface.ravel(), atol=np.ptp(surface) / 4000)
