"""Many files, one mechanism: a bad one is a row with its reason, and all end in one table."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surfaces
from asperity import ContactCurve
from asperity.cli.main import main

STEEL = ["--E", "210GPa"]
LIGHT = ["--pressure", "50MPa,0.2GPa"]
COMMANDS: dict[str, list[str]] = {
    "curve": [*STEEL, *LIGHT],
    "bem": [*STEEL, *LIGHT],
    "solve": [*STEEL, *LIGHT],
    "compare": [*STEEL, *LIGHT],
    "plan": STEEL,
    "surface info": [],
    "surface validate": [],
    "surface prepare": ["-o", "ready/"],
    "surface convert": ["-o", "ready/"],
    "surface peaks": [],
}


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """A folder with two maps and a file that is none, between them by name."""
    for seed, name in enumerate(("map1", "map3")):
        hm = surfaces.self_affine(
            (48, 60), (4.8e-4, 6e-4), hurst=0.8, rms_slope=0.1, cutoff=6e-5, seed=seed
        )
        surfaces.write(hm, folder / f"{name}.h5")
    (folder / "map2.h5").write_text("no map")
    return folder


def rows(path: str = "table.csv") -> list[dict[str, str]]:
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def results(capsys: pytest.CaptureFixture[str]) -> list[dict[str, Any]]:
    """Results of the one JSON document on standard output."""

    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is no JSON")

    found = json.loads(capsys.readouterr().out, parse_constant=refuse)
    return list(found["results"])


@pytest.mark.parametrize("command", COMMANDS)
def test_a_row_for_each_file_and_for_the_bad_one_its_reason(command, capsys):
    call = [*command.split(), "map*.h5", *COMMANDS[command], "--table", "all.csv"]
    assert main(call) == 2
    shown = capsys.readouterr()
    assert "Traceback" not in shown.err
    bad = [line for line in shown.err.splitlines() if "map2.h5" in line]
    assert command == "surface validate" or len(bad) == 1
    table = rows("all.csv")
    assert [row["file"] for row in table] == ["map1.h5", "map2.h5", "map3.h5"]
    assert [bool(row["reason"]) for row in table] == [False, True, False]
    assert "HDF5" in table[1]["reason"]
    told = shown.out.splitlines()
    head = next(i for i, line in enumerate(told) if line.startswith("file "))
    assert [line.split()[0] for line in told[head + 1 : head + 4]] == [r["file"] for r in table]


@pytest.mark.parametrize("command", COMMANDS)
def test_json_is_all_that_standard_output_holds(command, capsys):
    call = [*command.split(), "map1.h5", "map2.h5", *COMMANDS[command], "--json"]
    assert main(call) == 2
    good, bad = results(capsys)
    assert good["file"] == "map1.h5" and not good["reason"] and len(good) > 4
    assert bad["file"] == "map2.h5" and bad["reason"]


def test_the_table_tells_the_load_that_was_asked_for():
    assert main(["curve", "map1.h5", *STEEL, "--load", "0.5N", "--table", "t.csv"]) == 0
    assert float(rows("t.csv")[0]["load"]) == pytest.approx(0.5)


@pytest.mark.parametrize("command", ["curve", "bem", "solve"])
def test_the_json_of_a_curve_is_the_curve_and_tells_null_for_no_number(command, capsys):
    """Also for the infinite stiffness of full contact."""
    call = [command, "map1.h5", *STEEL, "--pressure", "1e8,1e13", "--json"]
    assert main(call) in (0, 1)
    (found,) = results(capsys)
    curve = ContactCurve.from_hdf5("results.h5", found["model"])
    for name, column in curve.columns().items():
        told = [math.nan if value is None else value for value in found["curve"][name]]
        known = [math.nan if value == math.inf else value for value in column.tolist()]
        assert told == column.tolist() or np.array_equal(told, known, equal_nan=True), name
    assert found["converged"] == bool(curve.converged.all())


def test_points_that_did_not_converge_give_one_and_a_bad_file_two():
    loads = ["--pressure", "1e8,1e13"]
    assert main(["curve", "map1.h5", "map3.h5", *STEEL, *loads]) == 1
    table = rows()
    assert [row["converged"] for row in table] == ["False", "False"]
    assert all(row["reason"] and float(row["mean_pressure"]) < 2e8 for row in table)
    assert main(["curve", "map*.h5", *STEEL, *loads, "--force"]) == 2


def test_one_file_leaves_no_table_and_several_leave_a_folder(folder):
    assert main(["curve", "map1.h5", *STEEL, *LIGHT]) == 0
    assert (folder / "results.h5").exists() and not (folder / "table.csv").exists()
    assert main(["curve", "map1.h5", "map3.h5", *STEEL, *LIGHT, "--csv", "c.csv"]) == 0
    assert {path.name for path in (folder / "results").iterdir()} == {"map1.h5", "map3.h5"}
    for row in rows():
        curve = ContactCurve.from_hdf5(row["output"])
        assert float(row["area_fraction"]) == curve.area_fraction[-1]
        assert len(rows(f"{Path(row['file']).stem}-c.csv")) == 2


def test_the_report_of_a_comparison_lies_beside_its_results(folder):
    assert main(["compare", "map1.h5", *STEEL, *LIGHT, "-o", "steel.h5"]) == 0
    assert main(["compare", "map1.h5", *STEEL, *LIGHT, "-o", "new/"]) == 0
    assert main(["compare", "map1.h5", "map3.h5", *STEEL, *LIGHT, "-o", "more"]) == 0  # a folder
    made = {str(path.relative_to(folder)) for path in folder.rglob("*.html")}
    assert made == {"steel.html", "new/report.html", "more/report.html"}


@pytest.mark.parametrize("command", ["curve", "bem", "solve", "compare"])
def test_one_page_tells_of_all_inputs(command, folder):
    (folder / "bad.h5").write_text("no surface")
    call = [command, "map1.h5", "bad.h5", "map3.h5", *STEEL, *LIGHT, "--report", "page.html"]
    assert main(call) == 2
    text = (folder / "page.html").read_text()
    assert "map1" in text and "map3" in text


def test_a_batch_goes_on_where_it_was_interrupted(monkeypatch, capsys):
    call = ["bem", "map1.h5", "map3.h5", *STEEL, *LIGHT]
    from asperity.bem.curve import bem_curve

    solved = []

    def interrupted(hm, *args, **kwargs):
        solved.append(hm.name)
        if len(solved) == 2:
            raise KeyboardInterrupt
        return bem_curve(hm, *args, **kwargs)

    monkeypatch.setattr("asperity.bem.curve.bem_curve", interrupted)
    assert main(call) == 130
    assert "--resume goes on" in capsys.readouterr().err
    assert main(call) == 2
    assert "map1.h5 is there already; --force replaces it, --resume" in capsys.readouterr().err
    assert main([*call, "--resume"]) == 0
    assert len(solved) == 3 and len(rows()) == 2


@pytest.mark.parametrize("command", ["curve", "bem", "solve", "compare"])
def test_nothing_is_read_where_something_would_be_overwritten(command, folder, monkeypatch, capsys):
    def read(*_: object) -> None:
        raise AssertionError("a map was read")

    monkeypatch.setattr("asperity.cli.options.load_surface", read)
    for there in ("results.h5", "results/map3.h5", "table.csv"):
        path = folder / there
        path.parent.mkdir(exist_ok=True)
        path.write_text("mine")
        files = ["map1.h5"] if there == "results.h5" else ["map1.h5", "map3.h5"]
        assert main([command, *files, *STEEL]) == 2
        assert f"{there} is there already; --force replaces it" in capsys.readouterr().err
        assert path.read_text() == "mine"
        path.unlink()


@pytest.mark.parametrize("command", ["curve", "bem"])
def test_a_load_is_the_pressure_times_the_area_of_the_map(command):
    area = math.prod(surfaces.read("map1.h5").size)
    load = ["--load", f"{1e8 * area!r}N"]
    assert main([command, "map1.h5", *STEEL, *load]) == 0
    by_load = ContactCurve.from_hdf5("results.h5")
    assert main([command, "map1.h5", *STEEL, "--pressure", "100MPa", "-o", "p.h5"]) == 0
    np.testing.assert_allclose(
        by_load.separation, ContactCurve.from_hdf5("p.h5").separation, rtol=1e-9
    )


def test_units_change_no_number(folder):
    plain = ["--E", "210e9", "--hardness", "2e10", "--separation", "3e-6:1e-6:3"]
    units = ["--E", "210GPa", "--hardness", "20 GPa", "--separation", "3um:1000nm:3"]
    for words, name in ((plain, "plain.csv"), (units, "units.csv")):
        assert main(["bem", "map1.h5", *words, "-o", f"{name}.h5", "--csv", name]) == 0
    timed = {"seconds"}
    for one, two in zip(rows("plain.csv"), rows("units.csv"), strict=True):
        assert {k: v for k, v in one.items() if k not in timed} == {
            k: v for k, v in two.items() if k not in timed
        }


def test_a_picture_of_each_curve(folder):
    """Of several files a name without a suffix is a folder."""
    call = ["curve", "map1.h5", "map3.h5", *STEEL, *LIGHT, "--plot", "pictures"]
    assert main(call) == 0
    for name in ("map1", "map3"):
        assert (folder / "pictures" / f"{name}.png").read_bytes().startswith(b"\x89PNG")


def test_json_of_one_contact(capsys):
    call = ["indent", "--shape", "polygon:4", "--law", "harmonic,hertz", "--load", "0.5,1"]
    assert main([*call, "--bem", "--grid", "32", "--json"]) == 0
    light, heavy = results(capsys)
    assert (light["load"], heavy["load"]) == (0.5, 1.0)
    laws = {law["law"]: law for law in heavy["laws"]}
    assert laws["harmonic"]["force"] == pytest.approx(1.0, rel=1e-3)
    assert laws["hertz"]["reason"] and "force" not in laws["hertz"]
    assert heavy["bem"]["converged"]


def test_the_measured_maps_by_one_command(measured, capsys):
    options = ["--fill", "harmonic", "--periodic", "taper", "--no-interaction"]
    assert main(["curve", f"{measured}/*.h5", *STEEL, *options, "-o", "curves/"]) == 0
    table = rows()
    assert len(table) == 8
    for row in table:
        curve = ContactCurve.from_hdf5(row["output"])
        assert (np.diff(curve.area_fraction) > 0).all(), row["file"]
        assert float(row["area_fraction"]) == curve.area_fraction[-1]
