"""Pictures, columns of points, SDF and X3P: what was written is read, without any extra."""

from __future__ import annotations

import contextlib
import re
import sys
import zipfile
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
import sdfio
import x3pio
from hypothesis import given, settings
from hypothesis import strategies as st

import surfaces
from surfaces.errors import FileFormatError, InputError, SurfaceError
from surfaces.files.columns import gridded

from .fuzz_hdf5 import mutate_bytes

SPACING = (2e-6, 3e-6)
NUMBERS = np.random.default_rng(4)
HEIGHTS = NUMBERS.normal(0.0, 5e-6, (12, 17))
HEIGHTS[2, 3] = np.nan
GREY = NUMBERS.integers(0, 65536, (12, 17)).astype(np.uint16)


@pytest.fixture(autouse=True)
def without_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)


def as_sdf(path: Path, **options: object) -> None:
    double = sdfio.Metadata(
        data_type=sdfio.DataType.BINARY64, revision=sdfio.Revision.ISO_1_0, manufacturer_id="x"
    )
    sdfio.write(path, HEIGHTS, x_scale=3e-6, y_scale=2e-6, metadata=double, **options)


def as_text_sdf(path: Path) -> None:
    as_sdf(path, format=sdfio.FileFormat.ASCII)


def as_x3p(path: Path) -> None:
    revision = x3pio.Revision.ISO5436_2000
    x3pio.write(path, HEIGHTS, x_scale=3e-6, y_scale=2e-6, revision=revision)


def as_tiff(path: Path) -> None:
    assert cv2.imwrite(str(path), HEIGHTS)


def as_png(path: Path) -> None:
    assert cv2.imwrite(str(path), GREY)


def as_points(path: Path) -> None:
    y, x = np.meshgrid(*(d * np.arange(n) for d, n in zip(SPACING, (12, 17), strict=True)))
    points = np.column_stack([x.T.ravel(), y.T.ravel(), HEIGHTS.ravel()])
    points = np.random.default_rng(0).permutation(points[np.isfinite(points[:, 2])])
    np.savetxt(path, points, header="unit = m")


MAKERS = {
    "a.sdf": as_sdf,
    "text.sdf": as_text_sdf,
    "a.x3p": as_x3p,
    "a.tif": as_tiff,
    "a.png": as_png,
    "a.xyz": as_points,
}


@pytest.mark.parametrize("name", ["a.sdf", "text.sdf", "a.x3p", "a.xyz"])
def test_files_that_state_their_lengths(tmp_path: Path, name: str) -> None:
    MAKERS[name](tmp_path / name)
    hm = surfaces.read(tmp_path / name)
    np.testing.assert_allclose(hm.heights, HEIGHTS, rtol=0, atol=1e-18)
    assert hm.spacing == pytest.approx(SPACING, rel=1e-12)
    assert hm.missing == 1 and hm.history[0]["unit"] == "m"
    with pytest.raises(FileFormatError, match="states unit 'm'; leave out --unit um"):
        surfaces.read(tmp_path / name, unit="um")


def test_a_text_sdf_may_begin_with_the_mark_of_utf_8(tmp_path: Path) -> None:
    as_text_sdf(tmp_path / "a.sdf")
    hm = surfaces.read(tmp_path / "a.sdf")
    (tmp_path / "a.sdf").write_bytes(b"\xef\xbb\xbf" + (tmp_path / "a.sdf").read_bytes())
    assert surfaces.read(tmp_path / "a.sdf").digest == hm.digest


@pytest.mark.parametrize("scale", ["0.0", "-1.0", "nan"])
def test_a_scale_of_sdf_that_gives_no_heights_is_refused(tmp_path: Path, scale: str) -> None:
    as_text_sdf(tmp_path / "a.sdf")
    text = (tmp_path / "a.sdf").read_text()
    (tmp_path / "a.sdf").write_text(re.sub("Zscale = .*", f"Zscale = {scale}", text))
    with pytest.raises(FileFormatError, match=f"Zscale is {scale}; it must be positive"):
        surfaces.read(tmp_path / "a.sdf")


@pytest.mark.parametrize(
    ("old", "new"), [(r"(?m)^Xscale = ", "Xscale = 1_0"), (r"\*\s*-?\d", "*\n1_0")]
)
def test_numbers_of_a_programming_language_in_sdf_are_refused(tmp_path: Path, old, new) -> None:
    """1_0 was read as 10; names may hold what they like."""
    as_sdf(tmp_path / "a.sdf", format=sdfio.FileFormat.ASCII)
    text = (tmp_path / "a.sdf").read_text().replace("ManufacID = x", "ManufacID = x1_0")
    assert surfaces.read(_written(tmp_path, text)).missing == 1
    with pytest.raises(FileFormatError, match=r"a.sdf: holds '1_0.*', which is no number"):
        surfaces.read(_written(tmp_path, re.sub(old, new, text, count=1)))


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("again", ["Zscale = 1e-6", " ZSCALE=1e-6", "Xscale = 1.0"])
def test_a_header_of_sdf_that_states_a_thing_twice_is_refused(tmp_path: Path, end, again) -> None:
    """The last one was taken: a thousand times the heights."""
    as_text_sdf(tmp_path / "a.sdf")
    lines = (tmp_path / "a.sdf").read_text().splitlines()
    (tmp_path / "a.sdf").write_bytes(end.join([lines[0], again, *lines[1:], ""]).encode())
    with pytest.raises(FileFormatError, match=r"its header states [xz]scale more than once"):
        surfaces.read(tmp_path / "a.sdf")


def _written(folder: Path, text: str) -> Path:
    (folder / "a.sdf").write_text(text)
    return folder / "a.sdf"


def test_a_matrix_of_x3p_larger_than_memory_is_refused(tmp_path: Path, monkeypatch) -> None:
    as_x3p(tmp_path / "a.x3p")
    monkeypatch.setattr("surfaces.numerics.memory.available_bytes", lambda: 12 * 17 * 16)
    with pytest.raises(SurfaceError, match=r"a map of 204 points needs .* GB .* save a part of it"):
        surfaces.read(tmp_path / "a.x3p")


@pytest.mark.parametrize("name", ["a.sdf", "a.x3p", "a.npz", "a.txt", "a.csv", "a.h5"])
def test_a_spacing_that_contradicts_the_file_is_refused(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    if name in MAKERS:
        MAKERS[name](path)
    else:
        surfaces.write(surfaces.HeightMap(HEIGHTS, SPACING), path)
    hm = surfaces.read(path)
    assert surfaces.read(path, spacing=SPACING).spacing == pytest.approx(hm.spacing, rel=1e-12)
    with pytest.raises(FileFormatError, match=r"states spacing .* leave out the other --spacing"):
        surfaces.read(path, spacing=2e-6)


@pytest.mark.parametrize(
    ("points", "scale", "message"),
    [
        ([(17, 12)], 0.0, "height of one step is 0.0 in its header"),
        ([(17, 12)], 1.0, r"states spacing \(2e-06, 3e-06\) m; leave out"),
        ([(17,)], 1.0, "holds a line of heights; a map needs two axes"),
        ([], 1.0, "holds no heights in a unit of length"),
    ],
)
def test_instrument_files_of_no_such_map(
    tmp_path: Path, monkeypatch, points, scale, message
) -> None:
    channels = [
        SimpleNamespace(unit="um", physical_sizes=(51.0, 24.0), nb_grid_pts=n, name="a",
                        height_scale_factor=scale)
        for n in points
    ]  # fmt: skip
    content = SimpleNamespace(default_channel=next(iter(channels), None), channels=channels)
    reader = contextlib.nullcontext(content)
    errors = SimpleNamespace(CannotDetectFileFormat=KeyError, ReadFileError=KeyError)
    library = SimpleNamespace(open_topography=lambda _: reader, Exceptions=errors)
    monkeypatch.setitem(sys.modules, "SurfaceTopography", library)
    (tmp_path / "a.sur").write_bytes(b"DIGITAL SURF")
    with pytest.raises(FileFormatError, match=message):
        surfaces.read(tmp_path / "a.sur", spacing=2e-6)


def test_pixels_of_nanometres_that_differ_are_told_apart(tmp_path: Path) -> None:
    surfaces.write(surfaces.HeightMap(HEIGHTS, 1e-9), tmp_path / "a.h5")
    with pytest.raises(FileFormatError, match="leave out the other --spacing"):
        surfaces.read(tmp_path / "a.h5", spacing=5e-9)


@pytest.mark.parametrize(
    ("name", "values"), [("a.png", GREY), ("a.tif", HEIGHTS)], ids=["png", "tiff"]
)
def test_pictures_take_their_scales_from_the_caller(
    tmp_path: Path, name: str, values: np.ndarray
) -> None:
    MAKERS[name](tmp_path / name)
    hm = surfaces.read(tmp_path / name, unit="2.5nm", spacing=SPACING)
    np.testing.assert_allclose(hm.heights, 2.5e-9 * values, rtol=1e-15)
    assert hm.spacing == SPACING
    with pytest.raises(FileFormatError, match="height of one grey level, such as --unit"):
        surfaces.read(tmp_path / name, spacing=SPACING)
    with pytest.raises(FileFormatError, match="states no pixel size; pass --spacing"):
        surfaces.read(tmp_path / name, unit="nm")


@settings(max_examples=30, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 999),
    offset=st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)),
    kept=st.floats(0.8, 1.0),
)
def test_points_in_any_order_give_their_map(seed: int, offset: tuple, kept: float) -> None:
    """Rounded places, rows left out and shuffled."""
    draw = np.random.default_rng(seed)
    z = draw.normal(size=(7, 11))
    y, x = np.mgrid[:7, :11] * np.array([0.5, 0.3])[:, None, None]
    rounding = 0.01 * draw.uniform(-1.0, 1.0, (2, 77))
    points = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    points[:, :2] += rounding.T + np.array(offset)
    keep = draw.random(77) < kept
    keep[[0, -1]] = True
    z.ravel()[~keep] = np.nan
    found = gridded(draw.permutation(points[keep]))
    assert found is not None
    np.testing.assert_array_equal(found[0], z)
    assert found[1] == pytest.approx((0.5, 0.3), rel=0.02)


def test_columns_of_points_with_a_hole_are_a_map(tmp_path):
    """A hole wider than ten pixels hid the lines; repeated points made a map of three columns."""
    y, x = (place.ravel() for place in np.mgrid[:30, :40])
    points = np.stack([x, y, np.sin(x) + y], axis=1).astype(float)
    np.savetxt(tmp_path / "hole.txt", points[(x < 10) | (x >= 22)])
    found = surfaces.read(tmp_path / "hole.txt", unit="um")
    assert found.shape == (30, 40) and found.missing == 12 * 30
    np.savetxt(tmp_path / "twice.txt", np.vstack([points, points[:1]]))
    with pytest.raises(surfaces.FileFormatError, match="repeatedly"):
        surfaces.read(tmp_path / "twice.txt", unit="um", spacing=1e-6)


def test_columns_of_another_unit_take_the_spacing(tmp_path: Path) -> None:
    as_points(tmp_path / "a.txt")
    text = (tmp_path / "a.txt").read_text().replace("# unit = m\n", "")
    (tmp_path / "a.txt").write_text(text)
    with pytest.raises(FileFormatError, match="states no unit"):
        surfaces.read(tmp_path / "a.txt")
    hm = surfaces.read(tmp_path / "a.txt", unit="mm", spacing=SPACING)
    assert hm.spacing == SPACING
    np.testing.assert_allclose(hm.heights, 1e-3 * HEIGHTS)
    assert surfaces.read(tmp_path / "a.txt", unit="mm").spacing == pytest.approx((2e-9, 3e-9))


def test_points_on_no_grid(tmp_path: Path) -> None:
    table = np.random.default_rng(1).random((60, 3))
    assert gridded(table) is None
    np.savetxt(tmp_path / "a.xyz", table)
    with pytest.raises(FileFormatError, match="on no even grid"):
        surfaces.read(tmp_path / "a.xyz", unit="um")


def test_layers_of_x3p(tmp_path: Path) -> None:
    x3pio.write(tmp_path / "a.x3p", np.stack([HEIGHTS, 2 * HEIGHTS]), x_scale=3e-6, y_scale=2e-6)
    hm = surfaces.read(tmp_path / "a.x3p", dataset="1")
    np.testing.assert_allclose(hm.heights, 2 * HEIGHTS)
    with pytest.raises(FileFormatError, match=r"no layer 'z'; the file holds 0, 1"):
        surfaces.read(tmp_path / "a.x3p", dataset="z")
    x3pio.write(tmp_path / "b.x3p", np.zeros(9), x_scale=1e-6)
    with pytest.raises(FileFormatError, match="needs an even grid"):
        surfaces.read(tmp_path / "b.x3p")


def test_increments_that_x3p_does_not_state_are_asked_for(tmp_path: Path) -> None:
    """A metre was taken for each, of pixels and of the steps of whole numbers."""
    whole = {"z_scale": 1e-9, "z_type": x3pio.DataType.INT16}
    heights = 1e-9 * np.arange(12.0).reshape(3, 4)
    x3pio.write(tmp_path / "a.x3p", heights, x_scale=2e-6, y_scale=2e-6, **whole)
    hm = surfaces.read(tmp_path / "a.x3p")
    with (
        zipfile.ZipFile(tmp_path / "a.x3p") as old,
        zipfile.ZipFile(tmp_path / "b.x3p", "w") as new,
    ):
        main = re.sub("<Increment>.*?</Increment>", "", old.read("main.xml").decode())
        new.writestr("main.xml", main)
        new.writestr("bindata/data.bin", old.read("bindata/data.bin"))
    for part in ({}, {"unit": "1nm"}, {"spacing": 2e-6}):
        with pytest.raises(FileFormatError, match=r"states no (unit|pixel size); pass --"):
            surfaces.read(tmp_path / "b.x3p", **part)
    found = surfaces.read(tmp_path / "b.x3p", unit="1nm", spacing=2e-6)
    assert found.spacing == hm.spacing
    np.testing.assert_allclose(found.heights, hm.heights, rtol=1e-12)


def test_rotations_of_x3p(tmp_path: Path) -> None:
    """A turn in the plane and a slight tilt leave the heights; one that turns them over does not,
    nor does a mirror, which the standard forbids and files state nevertheless."""

    def turned(axis: list[float], angle: float) -> surfaces.HeightMap:
        place = x3pio.Placement.from_axis_angle(axis, angle)
        view = {"placement": place, "coordinate_system": x3pio.CoordinateSystem.VIEW}
        x3pio.write(tmp_path / "a.x3p", HEIGHTS, x_scale=3e-6, y_scale=2e-6, **view)
        return surfaces.read(tmp_path / "a.x3p")

    for axis, angle in (([0, 0, 1], 0.3), ([0, 0, 1], np.pi), ([1, 0, 0], 0.05)):
        np.testing.assert_array_equal(turned(axis, angle).heights, HEIGHTS)
    for axis, angle in (([1, 0, 0], np.pi), ([0, 1, 0], 2.0)):
        with pytest.raises(FileFormatError, match=r"turns them over.*export it without"):
            turned(axis, angle)
    turned([0, 0, 1], np.pi)
    mirror = tmp_path / "b.x3p"
    with zipfile.ZipFile(tmp_path / "a.x3p") as old, zipfile.ZipFile(mirror, "w") as new:
        for name in set(old.namelist()) - {"md5checksum.hex"}:
            new.writestr(name, re.sub(rb"(?<=<r22>)[^<]*", b"1", old.read(name)))
    with pytest.raises(FileFormatError, match="mirrors"):
        surfaces.read(mirror)


@pytest.mark.parametrize("name", MAKERS)
def test_mutated_files_read_or_raise_one_sentence(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    MAKERS[name](path)
    content = path.read_bytes()
    options = {"unit": "um", "spacing": 1e-6} if name in ("a.tif", "a.png") else {}
    for case in range(60):
        path.write_bytes(mutate_bytes(content, np.random.default_rng([6, case])))
        try:
            surfaces.read(path, **options)
        except InputError as error:
            assert str(error).startswith(str(path)) and "\n" not in str(error)


def test_x3p_of_an_instrument_equals_its_twin(measured: Path) -> None:
    twin = surfaces.read(measured / "optical_rubber_missing.h5")
    hm = surfaces.read(measured / "raw" / "KautschukInfiniteFocus.x3p")
    offset = twin.history[0]["height_offset_removed"]
    np.testing.assert_allclose(hm.heights - offset, twin.heights, rtol=0, atol=5e-12)
    assert hm.spacing == pytest.approx(twin.spacing, rel=1e-7)
