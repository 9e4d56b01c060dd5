"""``asperity surface``: one file, several, a glob; a bad one is named and the rest go on."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from pages import Page

import surfaces
from asperity.cli.main import main


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for number in range(3):
        heights = np.random.default_rng(number).normal(0.0, 1e-7, (20, 31))
        heights[4, 5] = np.nan
        hm = surfaces.HeightMap(heights, (1e-6, 2e-6), name=f"map {number}")
        surfaces.write(hm, tmp_path / f"map{number}.h5")
    return tmp_path


def run(*words: object) -> int:
    return main(["surface", *map(str, words)])


def test_info_on_a_glob(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("info", folder / "*.h5") == 0
    out = capsys.readouterr().out
    assert out.count("20 x 31 (y, x), 1 missing") == 3


def test_info_by_blocks(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("info", folder / "map0.h5") == 0
    whole = capsys.readouterr().out
    assert run("info", folder / "map0.h5", "--memory", "8GiB") == 0
    blocks = capsys.readouterr().out
    for name in ("points", "pixel", "periodic", "heights", "hybrid", "functional", "history"):
        told = [line for line in whole.splitlines() if line.startswith(f"  {name}")]
        assert told == [line for line in blocks.splitlines() if line.startswith(f"  {name}")]


@pytest.mark.parametrize("action", ["info", "validate", "convert"])
def test_a_batch_goes_on_past_a_bad_file(
    folder: Path, action: str, capsys: pytest.CaptureFixture[str]
) -> None:
    content = (folder / "map1.h5").read_bytes()
    (folder / "map1.h5").write_bytes(content[: len(content) // 2])
    extra = ["-o", f"{folder}/out/"] if action == "convert" else []
    assert run(action, folder / "*.h5", *extra) == 2
    captured = capsys.readouterr()
    text = captured.out + captured.err
    assert "map1.h5" in text and "truncated or damaged" in text
    assert "map2.h5" in text
    assert "Traceback" not in text


def test_prepare_writes_history(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = folder / "ready.h5"
    assert run("prepare", folder / "map0.h5", "--periodic", "mirror", "-o", target) == 0
    ready = surfaces.read(target)
    assert ready.periodic and ready.missing == 0 and ready.shape == (40, 62)
    assert [step["step"] for step in ready.history] == ["read", "level", "fill", "periodic"]
    told = capsys.readouterr().out
    assert "1 missing points (0.16 %) filled smoothly" in told and "Made periodic" in told


def test_prepare_crop_and_resample(folder: Path) -> None:
    target = folder / "part.h5"
    words = ("--crop", 5, 20, 0, 30, "--resample", "2e-6", "--bandpass", "0", "inf", "-o", target)
    assert run("prepare", folder / "map0.h5", *words) == 0
    assert surfaces.read(target).shape == (8, 30)


def test_convert_round_trip(folder: Path) -> None:
    assert run("convert", folder / "map0.h5", "-o", folder / "a.csv") == 0
    assert run("convert", folder / "a.csv", "-o", folder / "b.h5") == 0
    assert surfaces.read(folder / "b.h5").digest == surfaces.read(folder / "map0.h5").digest


def test_generate(tmp_path: Path) -> None:
    words = "--size 1e-3 --shape 64 96 --hurst 0.8 --rms-slope 0.1 --rolloff 2.5e-4".split()
    assert run("generate", *words, "--cutoff", "6e-5", "--seed", 3, "-o", tmp_path / "g.h5") == 0
    hm = surfaces.read(tmp_path / "g.h5")
    assert hm.shape == (64, 96) and hm.size == (1e-3, 1e-3) and hm.periodic
    assert surfaces.validate(tmp_path / "g.h5") == []
    words += ["--cutoff", "6e-5", "--seed", "3", "--memory", "8GiB"]
    assert run("generate", *words, "-o", tmp_path / "blocks.h5") == 0
    found = surfaces.read(tmp_path / "blocks.h5").heights
    np.testing.assert_allclose(found, hm.heights, rtol=0, atol=1e-12 * hm.rms_height)


@pytest.mark.parametrize(
    "words",
    [
        "--texture plateau-honed --rms-slope 0.1 --cutoff 6e-5",
        "--texture ground --rms-slope 0.1 --cutoff 6e-5 --angle 30",
        "--texture turned --feed 1e-4 --nose-radius 4e-4 --roughness 1e-7",
        "--texture two-scale --coarse 2e-4 --fine 5e-5 --coarse-height 1e-6 --fine-height 1e-7",
    ],
)
def test_generate_textures(tmp_path: Path, words: str) -> None:
    target = tmp_path / "g.h5"
    size = ("--shape", 64, 96, "--size", 1e-3, 2e-3)
    assert run("generate", *words.split(), *size, "-o", target) == 0
    hm = surfaces.read(target)
    assert hm.shape == (64, 96) and hm.size == (1e-3, 2e-3) and hm.rms_height > 0.0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["generate", "-o", "a.h5"], "give either rms_slope (--rms-slope) or rms_height"),
        (["generate", "--feed", "1", "-o", "a.h5"], "--feed does not belong to self-affine"),
        (["generate", "--texture", "turned", "-o", "a.h5"], "turned needs --feed"),
        (
            ["generate", "--texture", "ground", "--memory", "1GiB", "-o", "a.h5"],
            "--memory does not belong to ground",
        ),
        (
            ["generate", "--memory", "386MiB", "--rms-slope", "1", "-o", "a.h5"],
            "takes 389 MiB of memory or more, not 386 MiB",
        ),
        (["info", "none.h5"], "none.h5: no such file"),
        (["info", "none*.h5"], "none*.h5: no such file"),
        (["convert", "{0}/map0.h5", "-o", "a.xyz"], "not as .xyz"),
        (["convert", "{0}/map0.h5", "-o", "{0}"], "would replace the input"),
        (["info", "{0}/map0.h5", "--spacing", "1", "2", "3"], "one number or two"),
        (["info", "{0}/map0.h5", "--unit", "um"], "leave out"),
        (["info", "{0}/map0.h5", "--memory", "1GiB", "--report", "a.html"], "leave out --memory"),
        (["info", "{0}/map0.h5", "--dataset", "z"], "the file holds heights (20, 31) float64"),
        (["peaks", "{0}/map0.h5"], "missing (1 of 620 points)"),
        (["peaks", "{0}/map0.h5", "--fill", "harmonic", "--plot", "a.xyz"], "cannot be written"),
        (["prepare", "{0}/map0.h5", "--fill-limit", "0", "-o", "a.h5"], "fill limit of 0 %"),
    ],
)
def test_bad_input_is_one_sentence(
    folder: Path, words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(*(word.format(folder) for word in words)) == 2
    err = capsys.readouterr().err
    assert message in err.splitlines()[-1] and "Traceback" not in err


def small(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file["heights"] = np.ones((2, 2))


def constant(path: Path) -> None:
    surfaces.write(surfaces.HeightMap(np.ones((5, 6)), 1e-6), path)


def nothing(path: Path) -> None:
    path.touch()


def words_only(path: Path) -> None:
    path.write_text("height of the hill: considerable\n")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (small, "at least 3 points"),
        (constant, "constant"),
        (nothing, "the file is empty"),
        (words_only, "not an HDF5 file"),
    ],
)
@pytest.mark.parametrize("action", ["info", "peaks"])
def test_files_that_are_no_use(
    tmp_path: Path, make, message: str, action: str, capsys: pytest.CaptureFixture[str]
) -> None:
    make(tmp_path / "a.h5")
    assert run(action, tmp_path / "a.h5", "--unit", "m", "--spacing", 1e-6) == 2
    err = capsys.readouterr().err
    assert message in err.splitlines()[-1] and "Traceback" not in err


def test_peaks_as_csv(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    hm = surfaces.self_affine((48, 64), (1e-3, 2e-3), hurst=0.8, rms_slope=0.1, cutoff=2e-4)
    surfaces.write(hm, tmp_path / "g.h5")
    assert run("peaks", tmp_path / "g.h5", "-o", tmp_path / "peaks.csv") == 0
    rows = (tmp_path / "peaks.csv").read_text().splitlines()
    assert len(rows) == 1 + len(surfaces.segment(hm))
    assert f"{len(rows) - 1} peaks" in capsys.readouterr().out
    assert rows[0].startswith("x_m,y_m,height_m,prominence_m")
    pictures = [tmp_path / "p.png", tmp_path / "f.svg"]
    assert run("peaks", tmp_path / "g.h5", "--plot", pictures[0], "--fans", pictures[1]) == 0
    assert "highest ten" in capsys.readouterr().out
    assert pictures[0].read_bytes().startswith(b"\x89PNG")
    assert "<svg" in pictures[1].read_text()


def test_info_as_a_page_that_needs_nothing_else(folder: Path) -> None:
    page = folder / "maps.html"
    assert run("info", folder / "map[01].h5", "--report", page) == 0
    found = Page(page)
    assert not found.loads()
    assert [tag for tag, _ in found.tags].count("section") == 2
    assert "missing: no spectrum" in found.shown
    assert {"Height map", "Autocorrelation", "Bearing curve"} <= set(found.figures())


def test_help_has_an_example(capsys: pytest.CaptureFixture[str]) -> None:
    for action in ("info", "generate", "prepare", "convert", "validate", "peaks"):
        with pytest.raises(SystemExit) as stopped:
            run(action, "--help")
        assert stopped.value.code == 0
        assert f"asperity surface {action}" in capsys.readouterr().out.split("example:")[1]


def test_forms_and_filters_are_those_of_python(folder: Path) -> None:
    options = ["--level", "cubic", "--bandpass", "5e-6", "inf", "--filter", "spline"]
    assert run("prepare", folder / "map0.h5", *options, "-o", folder / "ready.h5") == 0
    expected = surfaces.prepare(
        surfaces.read(folder / "map0.h5"), level="cubic", bandpass=(5e-6, None), filter="spline"
    )
    assert surfaces.read(folder / "ready.h5").digest == expected.digest


def test_the_height_of_one_grey_level(folder: Path) -> None:
    import cv2

    grey = np.arange(60, dtype=np.uint16).reshape(10, 6)
    assert cv2.imwrite(str(folder / "scan.png"), grey)
    words = [folder / "scan.png", "--unit", "2.5nm", "--spacing", "1e-6", "2e-6"]
    assert run("convert", *words, "-o", folder / "scan.h5") == 0
    hm = surfaces.read(folder / "scan.h5")
    np.testing.assert_allclose(hm.heights, 2.5e-9 * grey)
    assert hm.spacing == (1e-6, 2e-6)
