"""Bad input at the command line: one sentence on standard error, exit code 2, nothing written."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

import surfaces
from asperity.cli.main import main

STEEL = ["--E", "210e9", "--nu", "0.3"]
MODELS = ["curve", "bem", "compare", "plan"]


def good_map(shape: tuple[int, int] = (24, 32)) -> surfaces.HeightMap:
    return surfaces.self_affine(shape, (24e-6, 32e-6), hurst=0.8, rms_slope=0.1, seed=1)


def refusal(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """Run the command and return its one sentence, having checked that it is one."""
    try:
        code = main(arguments)
    except SystemExit as leaving:
        code = leaving.code
    shown = capsys.readouterr()
    assert code == 2, shown.err
    assert shown.err.count("\n") == 1, shown.err
    assert "Traceback" not in shown.err
    return shown.err


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write_raw(path: Path, heights: object, **attributes: object) -> None:
    with h5py.File(path, "w") as file:
        dataset = file.create_dataset("heights", data=heights)
        dataset.attrs.update(attributes)


@pytest.mark.parametrize("command", MODELS)
def test_no_such_file(command, folder, capsys):
    assert "absent.h5" in refusal([command, "absent.h5", *STEEL], capsys)


@pytest.mark.parametrize("command", MODELS)
def test_no_units(command, folder, capsys):
    write_raw(folder / "bare.h5", good_map().heights, spacing=(1e-6, 1e-6))
    assert "--unit" in refusal([command, "bare.h5", *STEEL], capsys)


@pytest.mark.parametrize("command", MODELS)
def test_missing_points_without_fill(command, folder, capsys):
    heights = good_map().heights.copy()
    heights[4, 7] = np.nan
    surfaces.write(surfaces.HeightMap(heights, (1e-6, 1e-6)), folder / "holes.h5")
    message = refusal([command, "holes.h5", *STEEL], capsys)
    assert "1 missing" in message
    assert "--fill harmonic" in message


@pytest.mark.parametrize("command", MODELS)
def test_constant_map(command, folder, capsys):
    surfaces.write(surfaces.HeightMap(np.full((16, 20), 2e-6), (1e-6, 1e-6)), folder / "flat.h5")
    assert "constant" in refusal([command, "flat.h5", *STEEL], capsys)


@pytest.mark.parametrize("command", MODELS)
def test_two_by_two_map(command, folder, capsys):
    write_raw(folder / "tiny.h5", np.zeros((2, 2)), spacing=(1e-6, 1e-6), unit="m")
    assert "(2, 2)" in refusal([command, "tiny.h5", *STEEL], capsys)


@pytest.mark.parametrize("command", MODELS)
@pytest.mark.parametrize(
    ("options", "match"),
    [
        (["--pressure", "-1e6"], "positive"),
        (["--pressure=-1e6:1e7:3"], "positive"),
        (["--pressure", "a:b:c"], "LO:HI:N"),
        (["--pressure", "1e6", "--separation", "1e-6"], "not allowed"),
        (["--bogus"], "unrecognized arguments: --bogus"),
        (["--m", "1.5"], "m"),
        (["--modulus", "1e9"], "not both"),
    ],
)
def test_unusable_options(command, options, match, folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    assert match in refusal([command, "scan.h5", *STEEL, *options], capsys)
    assert {p.name for p in folder.iterdir()} == {"scan.h5"}


@pytest.mark.parametrize("command", MODELS)
def test_no_material(command, folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    assert "--E" in refusal([command, "scan.h5"], capsys)


@pytest.mark.parametrize("command", MODELS)
@pytest.mark.parametrize("share", [0.1, 0.5, 0.95])
def test_truncated_file(command, share, folder, capsys):
    surfaces.write(good_map((96, 128)), folder / "whole.h5")
    whole = (folder / "whole.h5").read_bytes()
    (folder / "cut.h5").write_bytes(whole[: int(share * len(whole))])
    assert "cut.h5" in refusal([command, "cut.h5", *STEEL], capsys)


@pytest.mark.parametrize("command", ["curve", "bem", "compare"])
def test_no_folder_for_the_results_is_found_before_the_work(command, folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    arguments = [command, "scan.h5", *STEEL, "-o", "absent/results.h5"]
    assert "folder does not exist" in refusal(arguments, capsys)


def test_unknown_command(capsys):
    assert "invalid choice" in refusal(["contact"], capsys)


def test_report_of_something_else(folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    assert "schema" in refusal(["report", "scan.h5"], capsys)
    assert "no such results file" in refusal(["report", "absent.h5"], capsys)
