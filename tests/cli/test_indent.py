"""``asperity indent`` from the outside: tables, pictures, files, refusals."""

from __future__ import annotations

import json

import h5py
import numpy as np
import pytest

from asperity import HalfSpace, indent
from asperity.cli.main import main
from surfaces import FileFormatError, HeightMap, PolarProfile, write
from surfaces.files.profile_file import read_profile
from surfaces.shapes import bent_body

TURN = 2 * np.pi * np.arange(32) / 32


def write_profile(profile, path):
    """A profile file: datasets ``r``, ``phi``, ``f``, ``edge``."""
    with h5py.File(path, "w") as file:
        for name in ("r", "phi", "f", "edge"):
            if getattr(profile, name) is not None:
                file[name] = getattr(profile, name)


@pytest.fixture
def table() -> PolarProfile:
    """Table of a body whose section changes with height."""
    r = np.linspace(0, 2e-6, 24)
    body = bent_body(curvature=1e5, size=3e-6)
    return PolarProfile(r, TURN, body(r[:, None], TURN))


def test_shape_against_boundary_elements_with_picture(tmp_path, capsys):
    picture = tmp_path / "square.png"
    call = ["indent", "--shape", "polygon:4", "--m", "0.3", "--bem", "--grid", "64"]
    assert main([*call, "--law", "paper,harmonic", "--plot", str(picture)]) == 0
    lines = {line.split()[0]: line.split() for line in capsys.readouterr().out.splitlines() if line}
    assert -4.2 < float(lines["paper"][3]) < -3.5
    assert -0.9 < float(lines["harmonic"][3]) < -0.3
    assert picture.stat().st_size > 10_000


def test_picture_of_no_solution(tmp_path, recwarn):
    """The law of Hertz has none of a pyramid: no legend."""
    call = ["indent", "--shape", "polygon:4", "--law", "hertz"]
    assert main([*call, "--plot", str(tmp_path / "none.png")]) == 1
    assert not recwarn.list


def test_load_control_compares_at_the_same_load(capsys):
    """The published law needs 1.7 % more approach for the load of the boundary elements."""
    call = ["indent", "--shape", "polygon:4", "--m", "0.3", "--load", "0.6", "--bem"]
    assert main([*call, "--grid", "64", "--law", "paper,harmonic"]) == 0
    text = capsys.readouterr().out
    lines = {line.split()[0]: line.split() for line in text.splitlines() if line}
    assert "F = 0.6 N" in text and "e_d %" in text
    assert 1.5 < float(lines["paper"][3]) < 2.0
    assert 0.1 < float(lines["harmonic"][3]) < 0.4
    assert abs(float(lines["harmonic"][5])) < 1.5


@pytest.mark.parametrize(
    "shape",
    ["polygon:5 --k 2", "cosine:3 --k 2", "rounded:4:0.5 --k 2", "ellipse:2 --k 2", "cone",
     "paraboloid", "random:0.1:3 --k 2", "convex:6:1 --k 2", "bent"],
)  # fmt: skip
def test_every_shape_is_solved(shape, capsys):
    assert main(["indent", "--shape", *shape.split()]) == 0
    text = capsys.readouterr().out
    assert "harmonic" in text and "nan" not in text  # no errors without boundary elements


def test_profile_file_comes_back_and_is_solved(tmp_path, table, capsys):
    path = tmp_path / "profile.h5"
    write_profile(table, path)
    np.testing.assert_array_equal(read_profile(path).f, table.f)
    call = ["indent", str(path), "--E", "1e9", "--approach", "1e-9:1e-8:3"]
    assert main([*call, "--law", "harmonic"]) == 0
    assert capsys.readouterr().out.count("harmonic") == 3


@pytest.mark.parametrize(("value", "words"), [(np.nan, "it must be finite"), (b"x", "cut off")])
def test_what_is_wrong_in_a_profile_file_is_told_with_its_name(value, words, tmp_path, table):
    path = tmp_path / "profile.h5"
    write_profile(table, path)
    with h5py.File(path, "r+") as file:
        f = file["f"][:].astype(np.array(value).dtype)
        del file["f"]
        f[4, 3] = value
        file["f"] = f
    with pytest.raises(FileFormatError, match=rf"^profile\.h5: .*{words}"):
        read_profile(path)


def test_a_contact_without_solution_is_marked_and_drawn(tmp_path, capsys):
    r = np.linspace(0, 2e-6, 24)
    turning = np.sin(1.4 * (r / r[-1]) ** 2)[:, None] * 1e-7 * np.ones(TURN.size)
    path, picture = tmp_path / "turning.h5", tmp_path / "turning.png"
    write_profile(PolarProfile(r, TURN, turning), path)
    call = ["indent", str(path), "--E", "1e9", "--approach", "1e-4", "--law", "paper,harmonic"]
    assert main([*call, "--plot", str(picture)]) == 1
    assert "TURNING" in capsys.readouterr().out and picture.is_file()


def test_load_control_reaches_the_load(tmp_path, table, capsys):
    path = tmp_path / "profile.h5"
    write_profile(table, path)
    call = ["indent", str(path), "--modulus", "1e9", "--load", "2e-6"]
    assert main([*call, "--law", "paper"]) == 0
    line = next(v for v in capsys.readouterr().out.splitlines() if v.split()[:1] == ["paper"])
    approach = indent(table, HalfSpace.from_modulus(1e9), load=2e-6, law="paper").approach
    assert float(line.split()[1]) == pytest.approx(float(approach), rel=1e-4)


@pytest.mark.parametrize("bare", [False, True])
def test_the_highest_peak_of_a_map_is_a_profile(bare, tmp_path):
    y, x = np.mgrid[0:48, 0:64]
    heights = -((x - 30.3) ** 2 + 2 * (y - 22.6) ** 2) * 1e-9
    if bare:
        np.save(tmp_path / "map.npy", 1e6 * heights)
        profile = read_profile(tmp_path / "map.npy", unit="um", spacing=1e-6)
    else:
        write(HeightMap(heights, (1e-6, 1e-6)), tmp_path / "map.h5")
        profile = read_profile(tmp_path / "map.h5")
    assert profile(3e-6, 0.0) == pytest.approx(9e-9, rel=1e-3)
    assert profile(3e-6, np.pi / 2) == pytest.approx(18e-9, rel=1e-3)


def test_the_highest_peak_is_that_of_the_map_without_its_tilt(tmp_path):
    y, x = np.mgrid[0:48, 0:64] * 1e-6
    bump = -((x - 30e-6) ** 2 + 2 * (y - 22e-6) ** 2) * 1e3
    write(HeightMap(np.maximum(bump, -2e-7) + 0.3 * x, (1e-6, 1e-6)), tmp_path / "tilted.h5")
    profile = read_profile(tmp_path / "tilted.h5")
    assert profile(3e-6, 0.0) == pytest.approx(9e-9, rel=0.1)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (["indent"], "either a profile file or --shape"),
        (["indent", "--shape", "blob"], "no shape is called 'blob'"),
        (["indent", "--shape", "polygon"], "write polygon:N, N and SEED whole"),
        (["indent", "--shape", "polygon:4.7"], "write polygon:N, N and SEED whole"),
        (["indent", "--shape", "polygon:4:5"], "write polygon:N, N and SEED whole"),
        (["indent", "--shape", "polygon:1000000000"], "3 to 1000 sides"),
        (["indent", "--shape", "cone:5"], "write cone\n"),
        (["indent", "--shape", "random:0.1:-3"], "seed is -3"),
        (["indent", "--shape", "ellipse:-3"], "must be positive"),
        (["indent", "--shape", "cone", "--scale", "0"], "--scale must be positive"),
        (["indent", "--shape", "cone", "--k", "2"], "--k does not belong to --shape cone"),
        (["indent", "--shape", "cone", "--nu", "0.2"], "give --E"),
        (["indent", "--shape", "cone", "--E2", "70GPa"], "give --E"),
        (["indent", "--shape", "cone", "--hardness2", "1GPa"], "give --E"),
        (["indent", "--shape", "cone", "--unit", "um"], "--unit belongs to a file"),
        (["indent", "nothing.h5", "--E", "1", "--k", "2"], "--k belongs to --shape"),
        (["indent", "--shape", "cone", "--grid", "64"], "add --bem"),
        (["indent", "--shape", "cone", "--tolerance", "1e-3"], "add --bem"),
        (["indent", "--shape", "cone", "--approach", "1e300"], "below 1e40"),
        (["indent", "--shape", "cone", "--plot", "a.bogus"], "cannot be written as .bogus"),
        (["indent", "--shape", "cone", "--law", "cube"], "law is 'cube'; choose one of auto"),
        (["indent", "--shape", "cone", "--approach", "-1"], "must be positive"),
        (["indent", "--shape", "cone", "--load", "0"], "must be positive"),
        (["indent", "--shape", "cone", "--plot", "/nowhere/a.png"], "does not exist"),
        (["indent", "nothing.h5", "--E", "1"], "no such file"),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_two(call, message, capsys):
    assert main(call) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1


def test_damaged_profile_files_are_refused(tmp_path, capsys):
    path = tmp_path / "bad.h5"
    with h5py.File(path, "w") as file:
        file["r"] = np.arange(5.0)
    assert main(["indent", str(path), "--E", "1"]) == 2
    assert "no dataset 'phi'" in capsys.readouterr().err
    path.write_bytes(path.read_bytes()[:700])
    assert main(["indent", str(path), "--E", "1"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_flags_are_told_to_programs_too(tmp_path, capsys):
    """A force beyond the first contact of a second summit came without a word."""
    x, y = np.meshgrid(np.arange(40), np.arange(32))
    two = np.maximum(-((x - 12) ** 2), -0.3 - (x - 28) ** 2) - (y - 16) ** 2
    write(HeightMap(two * 1e-9, 1e-7), tmp_path / "two.h5")
    call = ["indent", str(tmp_path / "two.h5"), "--modulus", "1e9", "--law", "hertz,harmonic"]
    assert main([*call, "--approach", "90nm", "--json"]) == 1
    told = capsys.readouterr()
    for law in json.loads(told.out)["results"][0]["laws"]:
        assert "SECOND_SUMMIT" in law["flags"] and law["flags"] in told.err
