"""The command line does its jobs: files in, curves, comparison and report out."""

from __future__ import annotations

import re
from pathlib import Path

import h5py
import numpy as np
import pytest
from pages import Page
from vti import read_vti

import asperity
import surfaces
from asperity import ContactCurve, HalfSpace, compare, read_results
from asperity.cli.main import COMMANDS, main
from asperity.comparison.result import Comparison

STEEL = ["--E", "210e9", "--nu", "0.3"]


@pytest.fixture
def folder(folder: Path) -> Path:
    """A folder with one periodic synthetic map and one raw scan with tilt and missing points."""
    hm = surfaces.self_affine(
        (64, 80), (6.4e-4, 8e-4), hurst=0.8, rms_slope=0.1, rolloff=2e-4, cutoff=6e-5, seed=1
    )
    surfaces.write(hm, folder / "rough.h5")
    heights = hm.heights + 0.05 * hm.x[None, :]
    heights[10:12, 20:23] = np.nan
    surfaces.write(surfaces.HeightMap(heights, hm.spacing), folder / "scan.h5")
    return folder


@pytest.mark.parametrize("command", COMMANDS)
def test_help_has_an_example(command, capsys):
    with pytest.raises(SystemExit) as leaving:
        main([command, "--help"])
    assert leaving.value.code == 0
    assert f"asperity {command}" in capsys.readouterr().out.split("example")[1]


@pytest.mark.parametrize("command", ["curve", "bem", "solve"])
def test_curve_commands_write_what_they_print(command, folder, capsys):
    arguments = [command, "rough.h5", *STEEL, "--pressure", "3e7:3e8:3", "--csv", "c.csv"]
    assert main(arguments) == 0
    curve = ContactCurve.from_hdf5("results.h5")
    told = capsys.readouterr()
    for line in str(curve).splitlines():  # doubts are told before, on standard error
        assert line in told.out or line.removeprefix("warning").strip() in told.err
    np.testing.assert_allclose(curve.mean_pressure, np.geomspace(3e7, 3e8, 3), rtol=2e-3)
    assert len((folder / "c.csv").read_text().splitlines()) == 4


@pytest.mark.parametrize("command", ["curve", "bem", "solve"])
def test_lost_digits_are_told_once(command, folder, capsys):
    hm = surfaces.read("rough.h5")
    surfaces.write(hm.replace(heights=hm.heights + 1e9), "far.h5")
    main([command, "far.h5", *STEEL, "--pressure", "1e8"])
    out, err = capsys.readouterr()
    assert (out + err).count("are rounded to") == 1


@pytest.mark.parametrize("command", ["curve", "bem", "solve"])
def test_curve_commands_resume(command, folder, capsys):
    assert main([command, "rough.h5", *STEEL, "--pressure", "1e8,3e8"]) == 0
    assert main([command, "rough.h5", *STEEL, "--pressure", "3e8,5e7,1e8", "--resume"]) == 0
    curve = ContactCurve.from_hdf5("results.h5")
    np.testing.assert_allclose(curve.mean_pressure, [3e8, 5e7, 1e8], rtol=2e-3)
    capsys.readouterr()
    changed = [command, "rough.h5", "--E", "70e9", "--pressure", "1e8", "--resume"]
    assert main(changed) == 2
    assert "modulus changed" in capsys.readouterr().err
    by_separation = [command, "rough.h5", *STEEL, "--separation", "1e-5", "--resume"]
    assert main(by_separation) == 2
    assert "kind of load points changed" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["curve", "bem"])
def test_a_resumed_curve_is_that_of_a_run_without_interruption(command, folder):
    call = [command, "rough.h5", *STEEL, "--pressure"]
    assert main([*call, "5e7,1e8,4e8,1e9"]) == 0
    whole = ContactCurve.from_hdf5("results.h5")
    assert main([*call, "5e7,1e8", "--force"]) == 0
    assert main([*call, "5e7,1e8,4e8,1e9", "--resume"]) == 0
    again = ContactCurve.from_hdf5("results.h5")
    for name in ("mean_pressure", "separation", "contact_area"):
        np.testing.assert_allclose(getattr(again, name), getattr(whole, name), rtol=1e-7)


def test_another_version_starts_anew(folder, monkeypatch, capsys):
    """What it would add may be another model, or lack what the file holds."""
    arguments = ["curve", "rough.h5", *STEEL, "--pressure", "1e8", "--resume"]
    assert main(arguments) == 0
    monkeypatch.setattr("asperity.cli.output.__version__", "0.0.1")
    assert main(arguments) == 2
    assert "version changed" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["curve", "bem"])
def test_a_finished_run_is_not_solved_again(command, folder, monkeypatch):
    arguments = [command, "rough.h5", *STEEL, "--pressure", "5e7:4e8:4", "--resume"]
    assert main(arguments) == 0
    first = ContactCurve.from_hdf5("results.h5")

    def solved_again(*_, **__):
        raise AssertionError("a finished point was solved again")

    for name in ("asperity.curve.contact_curve", "asperity.bem.curve.bem_curve"):
        monkeypatch.setattr(name, solved_again)
    assert main(arguments) == 0
    second = ContactCurve.from_hdf5("results.h5")
    np.testing.assert_array_equal(second.separation, first.separation)
    assert second.seconds == first.seconds


def test_negative_separations_are_numbers_not_options(folder):
    assert main(["curve", "rough.h5", *STEEL, "--separation", "-1e-7,1e-6"]) in (0, 1)
    assert ContactCurve.from_hdf5("results.h5").asked["asked_separation"][0] == pytest.approx(-1e-7)


def test_contacts_as_a_table(folder):
    assert main(["curve", "rough.h5", *STEEL, "--pressure", "1e8", "--contacts", "t.csv"]) == 0
    table = np.genfromtxt("t.csv", delimiter=",", names=True)
    curve = ContactCurve.from_hdf5("results.h5")
    assert table["force"].sum() == pytest.approx(curve.load[-1], rel=5e-3)


@pytest.mark.parametrize("command", ["curve", "bem", "plan"])
def test_a_map_too_coarse_for_its_roughness_is_named_once(command, folder, capsys):
    fine = surfaces.self_affine((64, 80), (6.4e-4, 8e-4), hurst=0.8, rms_slope=0.1, rolloff=2e-4)
    surfaces.write(fine, "fine.h5")
    for name, times in (("fine.h5", 1), ("rough.h5", 0)):
        output = ["--force"] if command == "plan" else ["-o", f"{command}-{name}"]
        assert main([command, name, *STEEL, "--pressure", "1e8", *output]) == 0
        said = capsys.readouterr()
        assert (said.out + said.err).count("too coarse for its roughness") == times


def test_sizes_of_the_spots_are_those_of_the_table(folder):
    options = ["--pressure", "1e8", "--spots", "t.csv", "--sizes", "s.csv"]
    assert main(["curve", "rough.h5", *STEEL, *options]) == 0
    table, sizes = (np.genfromtxt(n, delimiter=",", names=True) for n in ("t.csv", "s.csv"))
    assert sizes["contacts"].sum() == len(table)
    assert sizes["area_share"].sum() == pytest.approx(1.0)


@pytest.mark.parametrize("command", ["curve", "bem", "solve"])
def test_conductance_and_partial_slip_from_the_curve(command, folder, capsys):
    options = ["--pressure", "1e8:1e7:4", "--csv", "c.csv", "--resistivity", "1e-7", "3e-7"]
    options += ["--friction", "0.3", "--slip", "slip.csv"]
    assert main([command, "rough.h5", *STEEL, *options]) == 0
    assert re.search(r"conductance( +\S+){4} S/m\^2 or W/\(m\^2 K\)\n", capsys.readouterr().out)
    table, slip = (np.genfromtxt(n, delimiter=",", names=True) for n in ("c.csv", "slip.csv"))
    modulus = 210e9 / (1 - 0.3**2)
    np.testing.assert_allclose(table["conductance"], 2 * table["stiffness"] / (modulus * 4e-7))
    assert slip["shear"][0] == pytest.approx(0.0, abs=1.0)
    assert slip["shear"][-1] == pytest.approx(0.3 * 9e7, rel=1e-2)
    assert (np.diff(slip["displacement"]) > 0).all()


@pytest.mark.parametrize("command", ["curve", "bem"])
def test_conductance_of_contacts_that_yield(command, folder, capsys):
    """Their spots keep their size as the load begins to fall."""
    options = ["--hardness", "2GPa", "--pressure", "1e8", "--resistivity", "1e-7", "3e-7"]
    assert main([command, "rough.h5", *STEEL, *options, "--csv", "c.csv"]) == 0
    table = np.genfromtxt("c.csv", delimiter=",", names=True)
    stiffness = table["unloading_stiffness"]
    found = 2 * stiffness / (210e9 / (1 - 0.3**2) * 4e-7)
    assert table["conductance"] == pytest.approx(found) and stiffness > table["stiffness"]


@pytest.mark.parametrize("partner", [["--against", "rough.h5"], ["--E2", "70e9", "--nu2", "0.4"]])
def test_partial_slip_of_two_bodies(partner, folder):
    loads = ["--pressure", "1e7:1e8:4", "--friction", "0.3", "--slip", "slip.csv", "--csv", "c.csv"]
    assert main(["curve", "rough.h5", *STEEL, *partner, *loads]) == 0
    table, slip = (np.genfromtxt(n, delimiter=",", names=True) for n in ("c.csv", "slip.csv"))
    one = asperity.HalfSpace(210e9, 0.3)
    two = asperity.HalfSpace(70e9, 0.4) if "--E2" in partner else one
    ratio = asperity.HalfSpace.pair(one, two).modulus / asperity.tangential_modulus(one, two)
    apart = table["separation"][0] - table["separation"][-1]
    assert slip["displacement"][-1] == pytest.approx(0.3 * ratio * apart, rel=1e-6)


def test_no_slip_from_a_curve_that_hardly_converged(folder, capsys):
    """The curve is told, and its exit code is that of points that did not converge."""
    loads = ["--pressure", "1e8,1e12,2e12", "--resistivity", "1e-7", "1e-7"]
    slip = ["--friction", "0.3", "--slip", "slip.csv"]
    assert main(["curve", "rough.h5", *STEEL, *loads, *slip]) == 1
    shown = capsys.readouterr()
    assert "no partial slip is written" in shown.err and not (folder / "slip.csv").exists()
    assert "3 points, 1 converged" in shown.out and "nan nan" in shown.out


@pytest.mark.parametrize("command", ["curve", "bem", "solve"])
@pytest.mark.parametrize(
    ("options", "match"),
    [
        (["--E", "1e9", "--m", "0.3", "--resistivity", "1", "1"], "homogeneous"),
        (["--E", "1e9", "--friction", "0.3"], "--slip FILE"),
        (["--modulus", "1e9", "--friction", "0.3", "--slip", "s.csv"], "needs --E"),
        (["--E", "1e9", "--friction", "nan", "--slip", "s.csv"], "positive and finite"),
        (["--E", "1e9", "--friction", "1", "--slip", "s.csv", "--pressure", "1e8"], "lighter"),
        (["--E", "1e9", "--resistivity", "-1", "2"], "must not be negative"),
    ],
)
def test_what_does_not_follow_from_the_curve(command, options, match, folder, capsys):
    assert main([command, "rough.h5", *options]) == 2
    assert match in capsys.readouterr().err
    assert not (folder / "results.h5").exists()


def test_a_last_point_that_failed_is_not_written(folder, capsys):
    options = ["--pressure", "1e8,1e13", "--contacts", "t.csv", "--fields", "f.vti"]
    assert main(["curve", "rough.h5", *STEEL, *options]) == 1
    assert "did not converge: no table" in capsys.readouterr().err
    assert not {"t.csv", "f.vti"} & {p.name for p in folder.iterdir()}


@pytest.mark.parametrize("command", ["curve", "bem"])
def test_fields_for_paraview_carry_the_load(command, folder):
    options = ["--pressure", "1e8,2e8", "--fields", "f.vti"]
    assert main([command, "rough.h5", *STEEL, *options]) == 0
    cells, spacing, fields = read_vti(folder / "f.vti")
    assert cells == (80, 64)
    np.testing.assert_allclose(spacing, (1e-5, 1e-5))
    np.testing.assert_allclose(fields["pressure"].mean(), 2e8, rtol=5e-3)


def test_compare_and_report(folder, capsys):
    assert main(["compare", "rough.h5", *STEEL, "--pressure", "5e7:5e8:3"]) == 0
    comparison = Comparison.from_hdf5("results.h5")
    first = Page(folder / "report.html")
    assert comparison.verdict() in capsys.readouterr().out
    assert main(["report", "results.h5", "-o", "again.html"]) == 0
    assert Page(folder / "again.html").shown == first.shown
    assert main(["report", "results.h5", "-o", "again.html"]) == 2
    assert "--force replaces it" in capsys.readouterr().err
    assert main(["curve", "rough.h5", *STEEL, "--pressure", "5e7:5e8:3", "-o", "curve.h5"]) == 0
    assert main(["report", "results.h5", "curve.h5", "-o", "again.html", "--force"]) == 0
    assert "Side by side" in Page(folder / "again.html").shown


@pytest.mark.parametrize(
    "part", ["curves/bem", "curves/asperity", "tables/pareto", "tables/microcontacts", "maps/bem"]
)
def test_a_comparison_of_which_a_part_is_missing(part, folder, capsys):
    material, loads = HalfSpace(210e9, 0.3), [1e8]
    compare(surfaces.read("rough.h5"), material, pressures=loads).to_hdf5("results.h5")
    with h5py.File("results.h5", "a") as file:
        del file[part]
    assert main(["report", "results.h5"]) == 2
    assert "of the comparison is missing" in capsys.readouterr().err


def test_compare_goes_on_from_the_boundary_elements_it_has(folder, monkeypatch, capsys):
    arguments = ["compare", "rough.h5", *STEEL, "--pressure", "1e8,3e8"]
    assert main(arguments) == 0
    first = Comparison.from_hdf5("results.h5")

    def solved_again(*_, **__):
        raise AssertionError("the reference was solved again")

    with monkeypatch.context() as patch:
        patch.setattr("asperity.bem.curve.bem_curve", solved_again)
        assert main([*arguments, "--resume"]) == 2
        told = "report.html is there already; --force replaces it, and with --resume the results"
        assert told in capsys.readouterr().err
        assert main([*arguments, "--resume", "--force"]) == 0
    np.testing.assert_array_equal(Comparison.from_hdf5("results.h5").table, first.table)
    capsys.readouterr()
    assert main([*arguments, "--tolerance", "1e-5", "--resume", "--force"]) == 2
    assert "tolerance changed" in capsys.readouterr().err


def test_compare_keeps_the_load_points_that_its_file_holds(folder):
    """As the other commands do; those not asked for again were lost."""
    call = ["compare", "rough.h5", *STEEL, "--pressure"]
    assert main([*call, "5e7,3e8"]) == 0
    assert main([*call, "1e8", "--resume", "--force"]) == 0
    held = read_results("results.h5").curves["bem"]
    np.testing.assert_allclose(np.sort(held.mean_pressure), [5e7, 1e8, 3e8], rtol=1e-6)


def test_compare_prepares_a_raw_scan_and_goes_on_past_a_bad_file(folder, capsys):
    (folder / "bad.h5").write_text("no surface")
    options = ["--fill", "harmonic", "--periodic", "taper", "--pressure", "1e8,3e8"]
    assert main(["compare", "scan.h5", "bad.h5", "rough.h5", *STEEL, *options]) == 2
    shown = capsys.readouterr()
    assert shown.err.count("bad.h5") == 1
    assert {p.name for p in (folder / "results").iterdir()} == {"scan.h5", "rough.h5"}
    assert (folder / "report.html").is_file()
    history = Comparison.from_hdf5("results/scan.h5").about["history"]
    assert {"level", "fill"} <= {step["step"] for step in history}


def test_plan_runs_nothing(folder, capsys):
    assert main(["plan", "rough.h5", *STEEL]) == 0
    assert "interaction" in capsys.readouterr().out
    assert not (folder / "results.h5").exists()


def test_demo(folder, capsys):
    """Into a folder that it makes; what is there is not replaced."""
    assert main(["demo", "-o", "new/demo"]) == 0
    assert "The model is" in capsys.readouterr().out
    made = {p.name for p in (folder / "new" / "demo").iterdir()}
    assert made == {"surface.h5", "results.h5", "report.html"}
    (folder / "rough.h5").rename(folder / "surface.h5")
    before = (folder / "surface.h5").read_bytes()
    assert main(["demo"]) == 2
    assert "surface.h5 is there already; --force replaces it" in capsys.readouterr().err
    assert (folder / "surface.h5").read_bytes() == before
