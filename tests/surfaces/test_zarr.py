"""Zarr arrays are read as HDF5 datasets are: in parts, in metres, each fault told."""

from __future__ import annotations

import base64
import struct
import sys
from pathlib import Path

import numpy as np
import pytest

import surfaces
from surfaces.errors import FileFormatError

HEIGHTS = np.random.default_rng(2).normal(size=(70, 53)).astype(np.float32)


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    zarr = pytest.importorskip("zarr", reason="the extra for Zarr is not installed")
    array = zarr.create_array(tmp_path / "scan.zarr", data=HEIGHTS, chunks=(16, 32))
    array.attrs.update({"schema": "surface/1", "spacing": [1e-6, 2e-6], "unit": "um"})
    array.attrs["periodic"] = True
    return tmp_path / "scan.zarr"


def edit(path: Path, **attributes: object) -> Path:
    zarr = pytest.importorskip("zarr")
    array = zarr.open(path, mode="r+")
    for name, value in attributes.items():
        del array.attrs[name]
        if value is not None:
            array.attrs[name] = value
    return path


def test_an_array_is_a_map(stored: Path) -> None:
    hm = surfaces.read(stored)
    np.testing.assert_array_equal(hm.heights, HEIGHTS.astype(np.float64) * 1e-6)
    assert (hm.spacing, hm.periodic, hm.name) == ((1e-6, 2e-6), True, "scan")
    assert surfaces.validate(stored) == []
    part = surfaces.read(stored, rows=(3, 40), columns=(10, 50))
    np.testing.assert_array_equal(part.heights, hm.heights[3:40, 10:50])


def test_shards_that_reach_past_the_border(tmp_path: Path) -> None:
    zarr = pytest.importorskip("zarr", reason="the extra for Zarr is not installed")
    array = zarr.create_array(tmp_path / "a.zarr", data=HEIGHTS, chunks=(8, 8), shards=(16, 32))
    array.attrs.update({"spacing": [1e-6, 2e-6], "unit": "m"})
    hm = surfaces.read(tmp_path / "a.zarr")
    np.testing.assert_array_equal(hm.heights, HEIGHTS.astype(np.float64))


def test_blocks_cover_the_map_once(stored: Path) -> None:
    with surfaces.open(stored) as file:
        starts, blocks = zip(*file.blocks(rows=32), strict=True)
        found = surfaces.describe(file.on_disk())
    assert starts == (0, 32, 64)
    np.testing.assert_array_equal(np.vstack(blocks), surfaces.read(stored).heights)
    assert found.heights["Sq"] == pytest.approx(surfaces.read(stored).rms_height)


def test_a_group_holds_heights(tmp_path: Path) -> None:
    zarr = pytest.importorskip("zarr", reason="the extra for Zarr is not installed")
    zarr.create_group(tmp_path / "scans.zarr")
    for name in ("heights", "other"):
        zarr.create_array(tmp_path / "scans.zarr", name=name, data=HEIGHTS)
    options = {"unit": "nm", "spacing": 1e-6}
    assert surfaces.read(tmp_path / "scans.zarr", **options).shape == HEIGHTS.shape
    assert surfaces.read(tmp_path / "scans.zarr", dataset="other", **options).shape == HEIGHTS.shape
    with pytest.raises(FileFormatError, match="no array 'z'; the group holds heights, other"):
        surfaces.open(tmp_path / "scans.zarr", dataset="z")


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ({"unit": None}, "states no unit; pass --unit"),
        ({"spacing": [1e-6, -1.0]}, "spacing is "),
        ({"schema": "surface/9"}, "schema 'surface/9'"),
    ],
)
def test_each_bad_attribute_has_its_sentence(stored: Path, attributes, message) -> None:
    edit(stored, **attributes)
    with pytest.raises(FileFormatError, match=message):
        surfaces.read(stored)
    assert any(fault.fatal and message in str(fault) for fault in surfaces.validate(stored))


def test_damage_is_told(stored: Path) -> None:
    (stored / "c" / "1" / "0").write_bytes(b"garbage")
    with pytest.raises(FileFormatError, match="are damaged"):
        surfaces.read(stored)
    (stored / "c" / "1" / "0").unlink()
    with pytest.raises(FileFormatError, match="holds 9 of its 10 chunks"):
        surfaces.read(stored)
    (stored / "zarr.json").write_text("{")
    with pytest.raises(FileFormatError, match="damaged Zarr"):
        surfaces.read(stored)


@pytest.mark.parametrize("form", [2, 3])
def test_a_missing_point_is_known_where_xarray_states_it(tmp_path: Path, form: int) -> None:
    """In the fill value of format 2, which marks chunks of missing points by their absence, and in
    base64 of a double in format 3."""
    zarr = pytest.importorskip("zarr", reason="the extra for Zarr is not installed")
    numbers = np.arange(120, dtype="f4").reshape(10, 12)
    numbers[:4, :5] = numbers[8, 7] = -9999
    array = zarr.create_array(
        tmp_path / "a.zarr",
        shape=numbers.shape,
        dtype="f4",
        chunks=(4, 5),
        fill_value=-9999,
        zarr_format=form,
    )
    array[:] = numbers
    array.attrs.update({"unit": "um", "spacing": [1e-6, 1e-6]})
    coded = base64.b64encode(struct.pack("<d", -9999)).decode()
    array.attrs.update({"_ARRAY_DIMENSIONS": "yx"} if form == 2 else {"_FillValue": coded})
    expected = np.where(numbers == -9999, np.nan, numbers)
    np.testing.assert_allclose(surfaces.read(tmp_path / "a.zarr").heights, 1e-6 * expected)


@pytest.mark.parametrize("form", [2, 3])
def test_hardly_anything_of_a_huge_array_is_stored(tmp_path: Path, form: int) -> None:
    zarr = pytest.importorskip("zarr", reason="the extra for Zarr is not installed")
    array = zarr.create_array(
        tmp_path / "a.zarr",
        shape=(2**40, 2**40),
        dtype="f8",
        chunks=(2**8, 2**8),
        fill_value=np.nan,
        zarr_format=form,
    )
    array.attrs.update({"unit": "m", "spacing": [1e-6, 1e-6], "periodic": False})
    array[2**39 : 2**39 + 3, 5:8] = [[1, 2, 3]] * 3
    part = surfaces.read(tmp_path / "a.zarr", rows=(2**39, 2**39 + 4), columns=(5, 8))
    np.testing.assert_array_equal(part.heights, [[1, 2, 3]] * 3 + [[np.nan] * 3])
    assert not any(fault.fatal for fault in surfaces.validate(tmp_path / "a.zarr"))
    array[2**39, 5] = np.inf
    assert "1 heights are infinite" in str(surfaces.validate(tmp_path / "a.zarr")[-1])
    with pytest.raises(surfaces.SurfaceError, match="no room for"):
        surfaces.read(tmp_path / "a.zarr")


def test_without_the_library_it_is_named(stored: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "zarr", None)
    with pytest.raises(FileFormatError, match=r"pip install 'asperity\[zarr\]'"):
        surfaces.read(stored)
