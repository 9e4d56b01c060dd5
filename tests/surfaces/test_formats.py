"""Arrays and text: units are never guessed, and faults are one sentence."""

from __future__ import annotations

import io
import sys
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pytest
from samples import SPACING
from scipy.io import savemat

import surfaces
from surfaces.errors import FileFormatError, InputError, SurfaceError

from .fuzz_hdf5 import mutate_bytes

HEIGHTS = np.random.default_rng(4).normal(0.0, 5.0, (12, 17))
HEIGHTS[2, 3] = np.nan


def sample() -> surfaces.HeightMap:
    return surfaces.HeightMap(HEIGHTS * 1e-6, SPACING, periodic=True, name="sample")


@pytest.mark.parametrize("suffix", [".h5", ".npz", ".txt", ".csv"])
def test_what_is_written_is_read(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"map{suffix}"
    surfaces.write(sample(), path)
    back = surfaces.read(path)
    assert back.digest == sample().digest and back.name == "sample"


@pytest.mark.parametrize("suffix", [".txt", ".csv"])
def test_a_text_tells_its_shape(tmp_path: Path, suffix: str) -> None:
    """Three columns were read as points x, y, z, and a text cut off as a smaller map."""
    path, row = tmp_path / f"a{suffix}", np.arange(64)
    hm = surfaces.HeightMap(1e-9 * np.column_stack([row // 8, row % 8, row**2 % 7]), 1e-6)
    surfaces.write(hm, path)
    assert surfaces.read(path).digest == hm.digest
    path.write_text("".join(path.read_text().splitlines(True)[:-9]))
    with pytest.raises(FileFormatError, match="states 64 x 3 points and holds"):
        surfaces.read(path)


@pytest.mark.parametrize("suffix", [".h5", ".npz", ".csv", ".txt"])
def test_a_map_without_a_name_has_that_of_its_file(tmp_path: Path, suffix: str) -> None:
    surfaces.write(sample().replace(name=""), tmp_path / f"map{suffix}")
    assert surfaces.read(tmp_path / f"map{suffix}").name == "map"


@pytest.mark.parametrize("suffix", [".h5", ".npz", ".csv", ".txt"])
def test_any_name_comes_back_and_states_nothing_else(tmp_path: Path, suffix: str) -> None:
    hm = sample().replace(name="µ–日本\nspacing = 1 1")
    surfaces.write(hm, tmp_path / f"map{suffix}")
    back = surfaces.read(tmp_path / f"map{suffix}")
    assert back.digest == hm.digest and back.name.split() == hm.name.split()


@pytest.mark.parametrize("suffix", [".h5", ".npz", ".csv"])
def test_rectangles(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"map{suffix}"
    surfaces.write(sample(), path)
    part = surfaces.read(path, rows=(1, 9), columns=(3, 8))
    np.testing.assert_array_equal(part.heights, sample().heights[1:9, 3:8])
    assert not part.periodic and part.history[-1]["step"] == "crop"
    assert surfaces.read(path, columns=(0, 5)).shape == (12, 5)
    with pytest.raises(SurfaceError, match=r"map.*not inside"):
        surfaces.read(path, rows=(0, 13))


def as_npy(path: Path) -> None:
    np.save(path, HEIGHTS)


def as_npz(path: Path) -> None:
    np.savez(path, z=HEIGHTS)


def as_text(path: Path) -> None:
    np.savetxt(path, HEIGHTS)


def as_german_csv(path: Path) -> None:
    rows = (";".join("" if np.isnan(v) else repr(float(v)) for v in row) for row in HEIGHTS)
    path.write_text("\n".join(rows).replace(".", ","))


@pytest.mark.parametrize(
    ("name", "make"),
    [("a.npy", as_npy), ("a.npz", as_npz), ("a.txt", as_text), ("a.csv", as_german_csv)],
)
def test_bare_arrays_need_unit_and_spacing(tmp_path: Path, name: str, make) -> None:
    path = tmp_path / name
    make(path)
    hm = surfaces.read(path, unit="um", spacing=SPACING)
    np.testing.assert_allclose(hm.heights, HEIGHTS * 1e-6, rtol=1e-12)
    assert hm.spacing == SPACING and hm.history[0]["unit"] == "um"
    with pytest.raises(FileFormatError, match="states no unit; pass --unit"):
        surfaces.read(path, spacing=SPACING)
    with pytest.raises(FileFormatError, match="states no pixel size; pass --spacing"):
        surfaces.read(path, unit="um")


def test_text_comments_may_state_units(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    np.savetxt(path, HEIGHTS, header="unit: nm\nspacing: 1e-6 2e-6", delimiter="\t")
    hm = surfaces.read(path)
    assert hm.spacing == (1e-6, 2e-6)
    np.testing.assert_allclose(hm.heights, HEIGHTS * 1e-9)
    with pytest.raises(FileFormatError, match="states unit 'nm'"):
        surfaces.read(path, unit="um")


@pytest.mark.parametrize("encoding", ["latin-1", "utf-16", "utf-8-sig"])
def test_the_unit_of_a_text_is_read_in_any_encoding(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "a.txt"
    text = "# Höhe\n# unit = µm\n# spacing = 1e-6 2e-6\n1 2 3\n4 5 6\n7 8 9\n"
    path.write_text(text, encoding=encoding)
    assert surfaces.read(path).heights[0, 1] == pytest.approx(2e-6)


@pytest.mark.parametrize("name", ["a.txt", "a.csv"])
@pytest.mark.parametrize("library", [True, False])
def test_a_heading_that_nothing_reads_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, library: bool
) -> None:
    if library:
        pytest.importorskip("SurfaceTopography")
    else:
        monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    (tmp_path / name).write_text("# a map\nx,y,z\n1,2,3\n4,5,6\n7,8,9\n")
    with pytest.raises(FileFormatError, match=r"line 2 holds .x.*start comments with #"):
        surfaces.read(tmp_path / name, unit="um", spacing=1e-6)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 2 3\n4 5\n6 7 8\n", "line 2 has 2 numbers where the first row has 3"),
        ("1 2 3\n4 x 6\n7 8 9\n", "line 2 holds 'x', which is no number"),
        ("# only a comment\n\n", "no rows of numbers"),
        ("1 2\n3 4\n", "at least 3 points"),
        ("inf 2 3\n4 5 6\n7 8 9\n", "infinite"),
        ("1 2 3\n4 1_0 6\n7 8 9\n", "line 2 holds '1_0', which is no number"),
        ("1 2 3\n4 \u0662 6\n7 8 9\n", "line 2 holds '\u0662', which is no number"),
        ("# spacing = 1_0 1\n1 2 3\n4 5 6\n7 8 9\n", "spacing = 1_0 1 is not DY DX"),
        ("# unit = um\n1 2 3\n4 5 6\n7 8 9\n# unit = nm\n", "line 5 states unit = 'nm' and one"),
        ("# spacing = 1 2\n# Spacing: 2 2\n1 2 3\n4 5 6\n7 8 9\n", "line 2 states spacing"),
    ],
)
def test_bad_text(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "a.txt"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message) as caught:
        surfaces.read(path, unit="um", spacing=1e-6)
    assert str(caught.value).count(str(path)) == 1


@pytest.mark.parametrize("end", ["", "trailing"])
@pytest.mark.parametrize(("separator", "mark"), [(";", ","), (";", "."), ("\t", ","), (",", ".")])
def test_empty_cells_are_missing_wherever_they_stand(
    tmp_path: Path, separator: str, mark: str, end: str
) -> None:
    """The first row tells neither the decimal mark nor whether rows end in a separator."""
    no = np.nan
    heights = np.array([[1, 2, no], [no, 1.5, 2.25], [no, no, no], [no, 2, 3.5]])
    cells = [["" if np.isnan(z) else f"{z:g}".replace(".", mark) for z in row] for row in heights]
    text = "".join(separator.join(row) + (separator if end else "") + "\n" for row in cells)
    (tmp_path / "a.csv").write_text("# unit = m\n; spacing = 1\n;\n\n" + text)
    np.testing.assert_array_equal(surfaces.read(tmp_path / "a.csv").heights, heights)


def test_a_spreadsheet_mark_of_a_missing_point_is_no_comment(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("#1,2,3\n1,2,3\n#N/A,2,3\n4,5,6\n7,8,9\n")
    hm = surfaces.read(tmp_path / "a.csv", unit="m", spacing=1)
    np.testing.assert_array_equal(hm.heights[:, 0], [1, np.nan, 4, 7])


@pytest.mark.parametrize("row", ["1.234;2;3", "1.234,5;2;3"])
def test_decimal_marks_that_change_are_refused(tmp_path: Path, row: str) -> None:
    (tmp_path / "a.csv").write_text(f"1,5;2;3\n4;5;6\n{row}\n")
    with pytest.raises(FileFormatError, match=r"line 3 holds '.' where rows above have ','"):
        surfaces.read(tmp_path / "a.csv", unit="m", spacing=1)


@pytest.mark.parametrize("wrap", [np.array, lambda text: np.array([text.encode()])])
def test_npz_may_state_its_facts_in_arrays_of_one(tmp_path: Path, wrap) -> None:
    facts = {"unit": wrap("um"), "name": wrap("scan"), "periodic": np.array([1.0])}
    np.savez(tmp_path / "a.npz", heights=HEIGHTS, spacing=SPACING, **facts)
    hm = surfaces.read(tmp_path / "a.npz")
    np.testing.assert_array_equal(hm.heights, HEIGHTS * 1e-6)
    assert (hm.name, hm.periodic) == ("scan", True)


@pytest.mark.parametrize(
    ("facts", "message"),
    [
        ({"unit": 5}, "5 is not a unit of length; known are m,"),
        ({"spacing": [1.0, 2.0, 3.0]}, r"spacing is array.*give the pixel size"),
        ({"periodic": 2}, "periodic is 2; it must be true or false"),
        ({"heights": None}, "no array 'heights'; the file holds unit, spacing; name"),
    ],
)
def test_bad_facts_of_an_npz(tmp_path: Path, facts: dict, message: str) -> None:
    stated = {"unit": "um", "spacing": 1e-6, "heights": HEIGHTS} | facts
    held = {key: value for key, value in stated.items() if value is not None}
    np.savez(tmp_path / "a.npz", **held)
    with pytest.raises(InputError, match=message):
        surfaces.read(tmp_path / "a.npz")


def test_npz_with_several_arrays_lists_them(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    np.savez(path, z=HEIGHTS, w=HEIGHTS * 2)
    with pytest.raises(FileFormatError, match=r"holds z, w; name the heights with --dataset"):
        surfaces.read(path, unit="um", spacing=1e-6)
    twice = surfaces.read(path, dataset="w", unit="um", spacing=1e-6)
    np.testing.assert_allclose(twice.heights, HEIGHTS * 2e-6)


@pytest.mark.parametrize("cut", [1, 8, 100, 700])
@pytest.mark.parametrize("name", ["a.npy", "a.npz"])
def test_truncated_arrays(tmp_path: Path, name: str, cut: int) -> None:
    path = tmp_path / name
    (as_npy if name.endswith("npy") else as_npz)(path)
    path.write_bytes(path.read_bytes()[:cut])
    with pytest.raises(FileFormatError, match="damaged or not a plain"):
        surfaces.read(path, unit="um", spacing=1e-6)


def npy_that_promises(shape: tuple[int, ...]) -> bytes:
    buffer = io.BytesIO()
    header = {"shape": shape, "fortran_order": False, "descr": "<f8"}
    np.lib.format.write_array_header_1_0(buffer, header)
    return buffer.getvalue() + b"\x00" * 800


def test_arrays_that_promise_more_than_they_hold(tmp_path: Path) -> None:
    content = npy_that_promises((10**7, 10**7))
    (tmp_path / "a.npy").write_bytes(content)
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("heights.npy", content)
    for name in ("a.npy", "a.npz"):
        with pytest.raises(FileFormatError, match=r"damaged|promises"):
            surfaces.read(tmp_path / name, unit="um", spacing=1e-6)


@pytest.mark.parametrize("suffix", [".npy", ".npz", ".mat", ".txt", ".csv"])
def test_mutated_arrays_read_or_raise_one_sentence(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    if suffix == ".npy":
        np.save(path, HEIGHTS)
    elif suffix == ".mat":
        savemat(path, {"z": HEIGHTS, "unit": "um", "spacing": [1e-6, 1e-6]})
    else:
        surfaces.write(sample(), path)
    content = path.read_bytes()
    options = {"unit": "um", "spacing": 1e-6} if suffix == ".npy" else {}
    raised = 0
    for case in range(40):
        path.write_bytes(mutate_bytes(content, np.random.default_rng([5, case])))
        try:
            surfaces.read(path, **options)
        except InputError as error:
            raised += 1
            assert str(error).startswith(str(path)) and "\n" not in str(error)
    assert raised > 5


def test_objects_are_never_unpickled(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.array([[{}] * 4] * 4, dtype=object), allow_pickle=True)
    with pytest.raises(FileFormatError, match="damaged or not a plain npy"):
        surfaces.read(tmp_path / "a.npy", unit="um", spacing=1e-6)


@pytest.mark.parametrize("values", [np.zeros((4, 4), complex), np.full((4, 4), "a"), np.zeros(9)])
def test_arrays_that_are_no_heights(tmp_path: Path, values: np.ndarray) -> None:
    np.save(tmp_path / "a.npy", values)
    with pytest.raises(FileFormatError, match="heights are real numbers, 2-D"):
        surfaces.read(tmp_path / "a.npy", unit="um", spacing=1e-6)


def test_empty_and_unknown_files(tmp_path: Path) -> None:
    (tmp_path / "empty.txt").touch()
    with pytest.raises(FileFormatError, match="the file is empty"):
        surfaces.read(tmp_path / "empty.txt")
    with pytest.raises(SurfaceError, match=r"written as \.h5"):
        surfaces.write(sample(), tmp_path / "a.npy")


def test_hdf5_is_known_by_its_content(tmp_path: Path) -> None:
    surfaces.write(sample(), tmp_path / "a.h5")
    (tmp_path / "a.h5").rename(tmp_path / "a.scan")
    assert surfaces.read(tmp_path / "a.scan").digest == sample().digest


@pytest.mark.parametrize("suffix", [".h5", ".npz", ".csv"])
@pytest.mark.parametrize("name", ["dataset", "unit"])
def test_names_that_are_no_texts_are_refused(tmp_path: Path, suffix: str, name: str) -> None:
    surfaces.write(sample(), tmp_path / f"a{suffix}")
    for given in (np.ones(2), 3.0):
        with pytest.raises(InputError, match=rf"{name} is .*; give a text, or leave it out"):
            surfaces.read(tmp_path / f"a{suffix}", **{name: given})


def test_a_row_of_missing_points_may_come_first(tmp_path):
    """Of tabs alone it counted as a blank line, and the map was a row shorter."""
    for mark, name in (("\t", "a.tsv"), (",", "a.csv")):
        rows = [["", "", ""], ["1", "2", "3"], ["", "", ""], ["4", "5", "6"], ["7", "8", "9"]]
        (tmp_path / name).write_text("\n".join(mark.join(row) for row in rows) + "\n")
        found = surfaces.read(tmp_path / name, unit="um", spacing=1e-6)
        assert found.shape == (5, 3) and np.isnan(found.heights[[0, 2]]).all()


def test_a_region_of_an_array_is_given_as_of_hdf5(tmp_path):
    hm = surfaces.self_affine((12, 16), (12e-6, 16e-6), hurst=0.8, rms_slope=0.1)
    surfaces.write(hm, tmp_path / "a.npz")
    assert surfaces.read(tmp_path / "a.npz", rows=(0, 12)).digest == hm.digest
    assert surfaces.read(tmp_path / "a.npz", columns=np.array([0, 8])).shape == (12, 8)
    with pytest.raises(surfaces.SurfaceError, match="rows"):
        surfaces.read(tmp_path / "a.npz", rows=())


@pytest.mark.parametrize("name", ["x" * 300 + ".h5", "x" * 300 + ".npz"])
def test_names_that_no_file_can_have(name):
    with pytest.raises(FileFormatError, match="no such file"):
        surfaces.read(name)
    assert "no such file" in str(surfaces.validate(name)[0])
    with pytest.raises(InputError, match="zero byte"):
        surfaces.read("a\0" + name)


def test_empty_facts_state_nothing(tmp_path):
    surfaces.write(surfaces.HeightMap(np.eye(4), 1e-6), tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        file["heights"].attrs["name"] = np.zeros(0)
    assert surfaces.read(tmp_path / "a.h5").shape == (4, 4)
    np.savez(tmp_path / "a.npz", heights=np.eye(4), unit="um", spacing=1e-6, name=np.zeros(0))
    assert surfaces.read(tmp_path / "a.npz").name == "a"
    np.savez(tmp_path / "a.npz", heights=np.eye(4), unit=np.array(["um", "nm"]), spacing=1e-6)
    with pytest.raises(surfaces.FileFormatError, match="is not a unit of length"):
        surfaces.read(tmp_path / "a.npz")
