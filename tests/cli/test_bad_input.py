"""Bad input at the command line: one sentence on standard error, exit code 2, nothing written."""

from __future__ import annotations

import os
import subprocess
import sys
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
        (["--crop", "-5", "10", "0", "10"], "rows -5 to 10 are not inside"),
        (["--resample", "-1e-6"], "two positive pixel sizes"),
        (["--pressure", "a:b:c"], "LO:HI:N"),
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


@pytest.mark.parametrize("command", ["curve", "bem", "compare"])
def test_no_folder_for_the_results_is_found_before_the_work(command, folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    arguments = [command, "scan.h5", *STEEL, "-o", "absent/results.h5"]
    assert "folder does not exist" in refusal(arguments, capsys)


OUTPUTS = {
    "curve": ["-o", "--csv", "--contacts", "--spots", "--sizes", "--fields", "--table", "--plot"],
    "bem": ["-o", "--csv", "--fields", "--slip"],
    "compare": ["-o", "--csv", "--report"],
    "indent": ["--plot"],
    "surface prepare": ["-o"],
    "surface peaks": ["-o", "--plot", "--fans"],
    "surface info": ["--report", "--table"],
}


@pytest.mark.parametrize(
    ("command", "option"), [(c, option) for c, named in OUTPUTS.items() for option in named]
)
def test_no_output_replaces_the_input_or_what_is_there(command, option, folder, capsys):
    """The one by no means, the other only where it is said."""
    surfaces.write(good_map(), folder / "scan.h5")
    (folder / "there.csv").write_text("mine")
    before = (folder / "scan.h5").read_bytes()
    material = [] if command.startswith("surface") else STEEL
    material = [*material, *(["--friction", "1"] if option == "--slip" else [])]
    call = [*command.split(), "scan.h5", *material, option]
    assert "would replace the input" in refusal([*call, "./scan.h5", "--force"], capsys)
    message = refusal([*call, "there.csv"], capsys)
    assert "there.csv is there already; --force replaces it" in message
    results = command in ("curve", "bem", "compare") and option == "-o"
    assert ("--resume goes on with it" in message) == results
    assert (folder / "scan.h5").read_bytes() == before
    assert {p.name for p in folder.iterdir()} == {"scan.h5", "there.csv"}


def test_a_report_does_not_replace_its_results(folder, capsys):
    (folder / "results.h5").touch()
    message = refusal(["report", "results.h5", "-o", "results.h5"], capsys)
    assert "would replace the input" in message


def test_two_outputs_of_one_name(folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    call = ["compare", "scan.h5", *STEEL, "-o", "a.h5", "--report", "a.h5"]
    assert "two outputs" in refusal(call, capsys)


@pytest.mark.parametrize(
    "call", [["compare", *STEEL], ["surface", "prepare", "-o", "out/"]], ids=lambda c: c[0]
)
def test_two_inputs_of_one_name(call, folder, capsys):
    for place in ("a", "b"):
        (folder / place).mkdir()
        surfaces.write(good_map(), folder / place / "scan.h5")
    assert "replace each other" in refusal([*call, "a/scan.h5", "b/scan.h5"], capsys)


def test_a_folder_that_takes_no_files(folder, capsys, monkeypatch):
    """Permissions do not bind every user who runs the tests, so the refusal is played."""

    def refuse(**_: object) -> None:
        raise PermissionError(13, "Permission denied")

    surfaces.write(good_map(), folder / "scan.h5")
    monkeypatch.setattr("tempfile.TemporaryFile", refuse)
    assert "Permission denied" in refusal(["curve", "scan.h5", *STEEL], capsys)


def test_a_name_with_brackets_is_a_name_before_it_is_a_pattern(folder, capsys):
    surfaces.write(good_map().replace(name="odd"), folder / "scan[1].h5")
    surfaces.write(good_map(), folder / "scan1.h5")
    assert main(["surface", "validate", "scan[1].h5"]) == 0
    assert "scan[1].h5: valid" in capsys.readouterr().out


@pytest.mark.parametrize("command", ["curve", "compare"])
def test_no_output_replaces_a_device_or_has_an_impossible_name(command, folder, capsys):
    """A file is written beside its place and renamed: under root that replaced /dev/null."""
    surfaces.write(good_map(), folder / "scan.h5")
    os.mkfifo(folder / "pipe")
    (folder / "circle").symlink_to("circle")
    for target, match in (
        ("pipe", "it is a device or a pipe"),
        ("circle", "cannot be written"),
        ("a" * 300, "cannot be written"),
        ("scan.h5/results.h5", "cannot be written"),
    ):
        assert match in refusal([command, "scan.h5", *STEEL, "-o", target], capsys)
    assert (folder / "pipe").is_fifo()
    assert {p.name for p in folder.iterdir()} == {"scan.h5", "pipe", "circle"}


def test_an_output_through_a_link_keeps_the_link(folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    (folder / "shelf").mkdir()
    (folder / "link.csv").symlink_to("shelf/table.csv")
    assert main(["surface", "peaks", "scan.h5", "-o", "link.csv"]) == 0
    assert (folder / "link.csv").is_symlink()
    assert (folder / "shelf" / "table.csv").read_text().startswith("x_m,y_m")


def test_a_name_as_long_as_the_folder_takes(folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    name = "a" * 251 + ".csv"
    assert main(["surface", "peaks", "scan.h5", "-o", name]) == 0
    assert (folder / name).is_file()


def test_a_file_name_that_is_no_text(folder, capsys):
    """Bytes of another encoding reach the name, the page and the terminal."""
    name = b"gr\xf6sse.h5".decode("utf-8", "surrogateescape")
    surfaces.write(good_map(), folder / name)
    assert main(["surface", "info", name, "--report", "page.html"]) == 0
    assert main(["surface", "prepare", name, "-o", "ready.h5"]) == 0
    assert main(["surface", "info", "ready.h5"]) == 0
    assert "gr?sse" in (folder / "page.html").read_text(encoding="utf-8")


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


def test_an_interrupted_run_is_one_sentence(folder, capsys, monkeypatch):
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    surfaces.write(good_map(), folder / "scan.h5")
    monkeypatch.setattr("asperity.cli.options.load_surface", interrupt)
    assert main(["curve", "scan.h5", *STEEL]) == 130
    assert capsys.readouterr().err.endswith("interrupted; --resume goes on from its results file\n")


def test_an_interrupt_that_comes_while_code_is_compiled_is_not_lost(tmp_path):
    """The compiler drops what is raised in the functions that it calls; of several one is kept."""
    code = """
import signal, sys, time
import numba
from numba.core.codegen import JITCodeLibrary
from asperity.cli import main, report

noted = JITCodeLibrary._object_compiled_hook.__func__

def interrupted(cls, *compiled):
    noted(cls, *compiled)
    for _ in range(3):
        signal.raise_signal(signal.SIGINT)

def run(args):
    numba.njit(lambda x: x)(1)
    signal.pause()

JITCodeLibrary._object_compiled_hook = classmethod(interrupted)
report.run = run
signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background ignores it
done = main.main(["report", "results.h5"])
time.sleep(0.2)
sys.exit(done)
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60
    )
    assert (done.returncode, done.stderr) == (130, "asperity report: interrupted\n")


def test_unknown_command(capsys):
    assert "invalid choice" in refusal(["contact"], capsys)


def test_report_of_something_else(folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    told = refusal(["report", "scan.h5"], capsys)
    assert "is a height map, no results file" in told and "asperity compare" in told
    assert "no such results file" in refusal(["report", "absent.h5"], capsys)
