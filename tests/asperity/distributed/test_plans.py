"""The command asperity sweep, its plans and its tables."""

from __future__ import annotations

import json
from contextlib import chdir
from functools import wraps
from pathlib import Path

import pytest

import asperity
import surfaces
from asperity.cli.main import main
from asperity.distributed import work
from surfaces.numerics.memory import available_bytes, set_memory


def test_the_command_and_its_plans(here, maps, tmp_path, monkeypatch, capsys):
    maps(2)
    monkeypatch.chdir(tmp_path)
    loads = ["--pressure", "100MPa,1GPa", "--workers", "1"]
    call = ["sweep", "maps/*.h5", "--E", "210GPa", "70GPa", "-o", "out", *loads, "--json"]
    assert main(call) == 0
    (rows,) = [json.loads(capsys.readouterr().out)["results"]]
    assert [row["E"] for row in rows] == [210e9, 70e9] * 2
    Path("plan.toml").write_text(
        'files = ["maps/*.h5"]\npressure = "100MPa,1GPa"\n[[material]]\nE = ["210GPa", "70GPa"]\n'
    )
    assert main(["sweep", "plan.toml", "-o", "out", "--workers", "1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["results"] == rows
    Path("settings.toml").write_text(
        'pressure = ["100MPa", "1GPa"]\n[material]\nE = ["210GPa", "70GPa"]\n'
    )
    call = ["sweep", "maps/*.h5", "--config", "settings.toml", "-o", "out", "--workers", "1"]
    assert main([*call, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["results"] == rows
    Path("jobs.csv").write_text(
        'file,E,pressure\nmaps/m0.h5,210GPa,"100MPa,1GPa"\nmaps/no.h5,70GPa,\n'
    )
    assert main(["sweep", "jobs.csv", "-o", "out", "--workers", "1", "--json"]) == 2
    good, bad = json.loads(capsys.readouterr().out)["results"]
    assert good == rows[0] and "no such file" in bad["reason"]


def test_an_interrupted_command_says_how_to_go_on(here, maps, tmp_path, monkeypatch, capsys):
    maps(2)
    monkeypatch.chdir(tmp_path)
    call = ["sweep", "maps/*.h5", "--E", "210GPa", "--pressure", "100MPa,1GPa", "-o", "out"]
    solve = asperity.contact_curve

    @wraps(solve)
    def interrupted(hm, *args, **kwargs):
        if hm.name == "m1":
            raise KeyboardInterrupt
        return solve(hm, *args, **kwargs)

    with monkeypatch.context() as once:
        once.setattr("asperity.contact_curve", interrupted)
        assert main(call) == 130
    assert "the same again goes on where this ended" in capsys.readouterr().err
    assert asperity.Sweep.read("out").table["state"][1] == "waiting"
    assert [file.name[:2] for file in Path("out/results").iterdir()] == ["m0"]
    assert main(call) == 0


def test_workers_in_another_folder_know_the_memory_and_the_second_surface(
    here, maps, tmp_path, monkeypatch, capsys
):
    maps(2)
    monkeypatch.chdir(tmp_path)
    solve, begin, left = asperity.contact_curve, work.run_jobs, []

    @wraps(begin)
    def elsewhere(*args, **kwargs):
        set_memory(None)  # as in another process
        with chdir("/"):
            return begin(*args, **kwargs)

    @wraps(solve)
    def watched(*args, **kwargs):
        left.append(available_bytes())
        return solve(*args, **kwargs)

    monkeypatch.setattr("asperity.contact_curve", watched)
    monkeypatch.setattr("asperity.distributed.sweep.run_jobs", elsewhere)
    call = ["sweep", "maps/m0.h5", "--against", "maps/m1.h5", "--E", "210GPa", "--pressure", "1GPa"]
    assert main([*call, "--memory", "3GiB", "-o", "out", "--json"]) == 0, capsys.readouterr()
    assert left[0] < 3 << 30 < available_bytes()
    capsys.readouterr()
    assert main([*call, "--memory", "2GiB", "-o", "out", "--json"]) == 0, capsys.readouterr()
    assert len(left) == 1  # what is finished is the same with another limit


def test_the_second_surface_of_a_plan_lies_beside_it(here, maps, tmp_path, monkeypatch, capsys):
    maps(3)
    monkeypatch.chdir(tmp_path)
    Path("maps/m2.h5").replace("m1.h5")  # of the same name, where the command is called
    Path("maps/plan.toml").write_text('files = "m0.h5"\nagainst = "m1.h5"\nE = 1e11\nload = 1\n')
    Path("maps/jobs.csv").write_text("file,against,E,load\nm0.h5,m1.h5,1e11,1\n")
    assert main(["sweep", "maps/plan.toml", "maps/jobs.csv", "-o", "out", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["results"]
    one, two = (surfaces.read(f"maps/m{seed}.h5") for seed in (0, 1))
    rms_height = surfaces.composite(one, two).rms_height
    assert [row["rms_height"] for row in rows] == pytest.approx([rms_height] * 2, rel=1e-9)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("files = ", "plan.toml: no plan in TOML"),
        ('E = "210GPa"', "plan.toml: names no file"),
        ('files = "maps/*.h5"\nE = "210um"', "argument --E: 210um"),
        ('files = "maps/*.h5"\nspeed = 3', "plan.toml: speed: no options of a map"),
        ('files = "maps/*.h5"\noutput = "o/"\nworkers = 2', "plan.toml: output, workers: no opt"),
        ('files = "maps/*.h5"\nE = 1e9\nmethod = "bem"\nlaw = "ritz"', "leave out --law"),
        ('files = "maps/*.h5"\nmaterial = 3', "plan.toml: material is no table"),
        ('files = "maps/*.h5"\nmaterial = [{E = 1}, 3]', "plan.toml: material is no table"),
        ("files = [3]", "plan.toml: names no file"),
        (
            'files = "maps/*.h5"\nE = 1e9\nscales = ["auto", "all"]',
            "plan.toml: scales takes one val",
        ),
        ('files = "maps/*.h5"\nE = 1e9\nno-interaction = "maybe"', "argument --no-interaction: "),
    ],
)
def test_bad_plans_are_refused_in_one_sentence(text, match, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("plan.toml").write_text(text)
    try:
        code = main(["sweep", "plan.toml"])
    except SystemExit as leaving:
        code = leaving.code
    err = capsys.readouterr().err
    assert code == 2 and match in err and err.count("\n") == 1


@pytest.mark.parametrize(
    ("method", "more"),
    [
        ("bem", ["--law", "ritz"]),
        ("bem", ["--accuracy", "1%"]),
        ("curve", ["--tolerance", "1e-3"]),
        ("curve", ["--engine", "bem"]),
        ("solve", ["--no-interaction"]),
        ("solve", ["--tolerance", "1e-3"]),
    ],
)
def test_options_of_another_method_are_refused(method, more, capsys):
    call = ["sweep", "scan.h5", "--E", "210GPa", "--method", method, *more]
    assert main(call) == 2
    assert f"leave out {more[0]}" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["sweep", "ensemble"])
def test_workers_are_here_or_those_of_a_scheduler(command, capsys):
    with pytest.raises(SystemExit, match="2"):
        main([command, "scan.h5", "--E", "1", "--workers", "2", "--scheduler", "tcp://node:8786"])
    err = capsys.readouterr().err
    assert "--scheduler: not allowed with argument --workers" in err and err.count("\n") == 1


def test_loads_of_a_plan_and_of_the_command_line_are_not_both_taken(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("plan.toml").write_text('files = "maps/*.h5"\nE = 1e9\nseparation = "1um"')
    assert main(["sweep", "plan.toml", "--pressure", "2"]) == 2
    assert "give one of --pressure 2 and --separation 1um" in capsys.readouterr().err


def test_a_table_of_a_spreadsheet_is_understood(here, maps, tmp_path, monkeypatch, capsys):
    """A mark of the encoding in front, words for what is given or not, semicolons between the
    cells, and several numbers in one."""
    maps(1)
    monkeypatch.chdir(tmp_path)
    text = "file;no_interaction;crop\nmaps/m0.h5;TRUE;0 24 0 32\nmaps/m0.h5;FALSE;\n"
    Path("jobs.csv").write_text(text, encoding="utf-8-sig")
    call = ["sweep", "jobs.csv", "--E", "210GPa", "--pressure", "1GPa", "-o", "out"]
    assert main([*call, "--workers", "1", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["results"]
    assert [row["interaction"] for row in rows] == ["False", "True"]
    found = [asperity.read_results(f"out/{row['file']}").curves.values() for row in rows]
    shapes = [curve.settings["map"]["shape"] for (curve,) in found]
    assert shapes == [[24, 32], [48, 64]]
    Path("jobs.csv").write_text("file,E\n")
    assert main(call) == 2
    assert "jobs.csv: a table without rows" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("file,pressure\na.h5,1MPa\na.h5,1MPa,9MPa\n", "line 3 has a cell without a column"),
        ("file,pressure,\na.h5,1MPa,9MPa\n", "line 2 has a cell without a column"),
        ("file,E,E\na.h5,1GPa,2GPa\n", "two columns have one name"),
        ("File,E\na.h5,1GPa\n", 'a table without a column "file"'),
    ],
)
def test_no_cell_of_a_table_is_silently_left_out(text, match, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("jobs.csv").write_text(text)
    assert main(["sweep", "jobs.csv", "--E", "210GPa"]) == 2
    err = capsys.readouterr().err
    assert f"jobs.csv: {match}" in err and err.count("\n") == 1
