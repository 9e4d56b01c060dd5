"""Bad input at the command line: one sentence on standard error, exit code 2, nothing written."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from refusals import STEEL, good_map, refusal

import surfaces
from asperity.cli.main import main

MODELS = ["curve", "bem", "compare", "plan"]


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
    heights[4, 7] = 1.0
    surfaces.write(surfaces.HeightMap(heights, (1e-6, 1e-6)), folder / "spike.h5")
    message = refusal([command, "spike.h5", *STEEL, "--outliers", "6"], capsys)
    assert "spike.h5 has 1 missing points of 768; pass --fill harmonic" in message


def test_one_limit_of_the_prominence_of_peaks(folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    limits = ["--min-prominence", "1nm", "--wolf", "5"]
    assert "not allowed with" in refusal(["surface", "peaks", "scan.h5", *limits], capsys)


@pytest.mark.parametrize("command", MODELS)
def test_constant_map(command, folder, capsys):
    surfaces.write(surfaces.HeightMap(np.full((16, 20), 2e-6), (1e-6, 1e-6)), folder / "flat.h5")
    assert "constant" in refusal([command, "flat.h5", *STEEL], capsys)


def test_a_map_that_is_a_plane_leaves_nothing_to_touch(folder, capsys):
    heights = np.mgrid[:16, :20][0] * 1e-8
    surfaces.write(surfaces.HeightMap(heights, (1e-6, 2e-6)), folder / "tilted.h5")
    assert "constant" in refusal(["curve", "tilted.h5", *STEEL], capsys)


def test_heights_in_another_unit_than_stated_are_noticed(folder, capsys):
    hm = good_map()
    surfaces.write(hm.replace(heights=1e6 * hm.heights), folder / "micrometres.h5")
    assert main(["plan", "micrometres.h5", *STEEL]) == 0
    assert "warning: the rms slope is 9.3e+04: check the unit" in capsys.readouterr().out
    assert main(["bem", "micrometres.h5", *STEEL, "--pressure", "1e7"]) == 0
    assert "micrometres.h5: the rms slope is 9.3e+04: check" in capsys.readouterr().err


def test_a_modulus_in_gigapascal_is_noticed(folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    assert main(["plan", "scan.h5", "--E", "210"]) == 0
    assert "E* of 231 Pa is that of no solid" in capsys.readouterr().out
    assert main(["bem", "scan.h5", "--E", "210", "--pressure", "0.01"]) == 0
    assert capsys.readouterr().err.count("E* of 231 Pa is that of no solid") == 1


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
        (["--E", "-210e9"], "E must be positive"),
        (["--bandpass", "-1e-6", "1e-3"], "wavelengths -1e-06 to 0.001 m"),
        (["--bandpass", "4um", "30"], "30 has no unit and others have one"),
        (["--crop", "-5", "10", "0", "10"], "rows (-5, 10) are not inside"),
        (["--crop", "0", "1e-4", "0", "1e-4"], "--crop: 1e-4: give a whole number of pixels"),
        (["--resample", "-1e-6"], "must be positive lengths in m"),
        (["--pressure", "a:b:c"], "LO:HI:N"),
        (["--pressure", "1e7:1e8:99999999"], "1e+08 load points; give at most 10000"),
        (["--pressure", "1e7:1e8:1" + 5000 * "0"], "inf load points; give at most 10000"),
        (["--pressure", "1e6", "--separation", "1e-6"], "not allowed"),
        (["--pressure", "1e300"], "below 1e40"),
        (["--pressure", "2um:1mm:3"], "um is a unit of length, and a pressure is needed"),
        (["--pressure", "2:1GPa:3"], "2 has no unit and others have one"),
        (["--load", "0"], "positive"),
        (["--spacing", "1GPa"], "GPa is a unit of pressure, and a length is needed"),
        (["--E", "5um"], "5um: um is a unit of length, and a pressure is needed, such as 210GPa"),
        (["--nu", "30%"], "a plain number is needed"),
        (["--m", "1.5"], "m"),
        (["--modulus", "1e9"], "not both"),
    ],
)
def test_unusable_options(command, options, match, folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    assert match in refusal([command, "scan.h5", *STEEL, *options], capsys)
    assert {p.name for p in folder.iterdir()} == {"scan.h5"}


@pytest.mark.parametrize("command", [*MODELS, "surface info", "report"])
def test_an_unknown_option_points_to_the_help_of_its_command(command, folder, capsys):
    message = refusal([*command.split(), "scan.h5", "--bogus"], capsys)
    assert message == (
        f"asperity {command}: unrecognized arguments: --bogus; see asperity {command} --help\n"
    )


@pytest.mark.parametrize("options", [["--nu", "0.2"], ["--E2", "1e9"], ["--E", "1e9"]])
def test_the_modulus_of_all_bodies_takes_none_of_one(options, folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    assert "not both" in refusal(["curve", "scan.h5", "--modulus", "1e9", *options], capsys)


@pytest.mark.parametrize("options", [["--modulus", "1e9", "--nu", "0.2"], ["--nu", "0.2"]])
def test_a_poisson_ratio_belongs_to_a_modulus_of_young(options, folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    assert "--E" in refusal(["curve", "scan.h5", *options], capsys)


def test_what_only_some_formats_hold(folder, capsys):
    hm = good_map()
    surfaces.write(hm, folder / "scan.h5")
    np.save(folder / "bare.npy", hm.heights)
    convert = ["surface", "convert", "scan.h5", "--float32", "-o", "scan.npz"]
    assert "only .h5 is written as float32" in refusal(convert, capsys)
    info = ["surface", "info", "bare.npy", "--unit", "m", "--spacing", "1", "--dataset", "z"]
    assert "leave out --dataset" in refusal(info, capsys)
    picture = ["surface", "peaks", "scan.h5", "--plot", "map.bogus"]
    assert "cannot be written as .bogus" in refusal(picture, capsys)
    assert {p.name for p in folder.iterdir()} == {"scan.h5", "bare.npy"}


def test_another_run_is_not_gone_on_with(folder, capsys, monkeypatch):
    """Found before anything is compiled or solved."""
    waves = np.sin(2 * np.pi * np.arange(32) / 16)
    surfaces.write(
        surfaces.HeightMap(1e-7 * np.outer(waves[:24], waves), (1e-6, 2e-6)), folder / "scan.h5"
    )
    assert main(["bem", "scan.h5", *STEEL, "--pressure", "1e8"]) == 0
    capsys.readouterr()
    monkeypatch.delattr("asperity.comparison.run._compile")
    message = refusal(["compare", "scan.h5", *STEEL, "--pressure", "1e8", "--resume"], capsys)
    assert "cannot be continued: command" in message


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


@pytest.mark.parametrize("redirect", [">&-", "2>&-", ">/dev/full"])
def test_a_closed_or_full_terminal_is_no_crash(redirect, folder):
    surfaces.write(good_map(), folder / "größe.h5")
    call = f"{sys.executable} -m asperity surface info größe.h5 {redirect}"
    home = {"PYTHONIOENCODING": "ascii", "PYTHONPATH": str(Path(__file__).parents[2])}
    done = subprocess.run(
        call, shell=True, env={**os.environ, **home}, stderr=subprocess.PIPE, text=True
    )
    assert "Traceback" not in done.stderr and "Exception" not in done.stderr
    assert done.returncode == (2 if "full" in redirect else 0)


def test_a_file_that_another_program_writes_is_not_called_damaged(folder):
    surfaces.write(good_map(), folder / "scan.h5")
    with h5py.File(folder / "scan.h5", "a"):
        code = "import sys; from asperity.cli.main import main; sys.exit(main(sys.argv[1:]))"
        words = [sys.executable, "-c", code, "surface", "info", "scan.h5"]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "another program is writing it" in done.stderr


@pytest.mark.parametrize("option", ["--E", "--hardness"])
def test_all_values_of_a_sweep_have_a_unit_or_none(option, folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    told = refusal(["sweep", "scan.h5", option, "210GPa", "70", "-o", "all"], capsys)
    assert f"{option}: 210GPa 70: 70 has no unit and others have one" in told


@pytest.mark.parametrize("option", ["-o", "--csv", "--plot", "--table"])
def test_a_file_without_a_name_is_not_silently_left_out(option, folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    told = refusal(["curve", "scan.h5", *STEEL, option, ""], capsys)
    assert option in told and "empty" in told
    assert [file.name for file in folder.iterdir()] == ["scan.h5"]


@pytest.mark.parametrize("action", ["info", "validate"])
def test_text_called_hdf5_is_told_to_end_as_what_it_is(action, folder, capsys):
    (folder / "scan.h5").write_text("1 2 3\n4 5 6\n7 8 9\n")
    main(["surface", action, "scan.h5"])
    told = "".join(capsys.readouterr())
    assert "signature is missing" in told and ".csv" in told and "windows" not in told


def test_unknown_command(capsys):
    assert "invalid choice" in refusal(["contact"], capsys)


def test_report_of_something_else(folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    told = refusal(["report", "scan.h5"], capsys)
    assert "is a height map, no results file" in told and "asperity solve" in told
    assert "no such results file" in refusal(["report", "absent.h5"], capsys)


@pytest.mark.parametrize(
    ("more", "left_out"),
    [
        (["--seeds", "2", "--shape", "24", "--bandpass", "1um", "5um"], "--bandpass"),
        (["--seeds", "2", "--shape", "24", "--crop", "0", "8", "0", "8"], "--crop"),
        (["scan.h5", "--hurst", "0.3"], "--hurst"),
    ],
)
def test_options_that_an_ensemble_would_not_heed_are_refused(more, left_out, capsys):
    assert f"leave out {left_out}" in refusal(["ensemble", *more, *STEEL, "-o", "e/"], capsys)


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (["scan.csv", "--windows", "12"], "make it HDF5 with asperity surface convert"),
        (["scan.csv", "--windows", "12", "--spacing", "1", "2", "3"], "one number or two"),
        ([], "name files of maps, or give --seeds"),
        (["--seeds", "0", "--rms-slope", "0.1"], "--seeds is 0; give a whole number"),
        (["--seeds", "2", "--seed", "-1", "--rms-slope", "0.1"], "--seed is -1; give a whole"),
        (["--seeds", "2", "--rms-slope", "0.1", "--shape", "0", "--pressure", "1e6"], "shape is 0"),
    ],
)
def test_an_ensemble_says_what_its_members_lack(more, told, folder, capsys):
    surfaces.write(good_map(), folder / "scan.csv")
    assert told in refusal(["ensemble", *more, *STEEL, "-o", "e/"], capsys)
