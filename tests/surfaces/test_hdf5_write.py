"""Height maps written as HDF5, whole and in blocks."""

from __future__ import annotations

import resource
from pathlib import Path

import numpy as np
import pytest
from samples import SPACING, bumps

import surfaces
from surfaces.errors import InputError, SurfaceError


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    surfaces.write(bumps(), tmp_path / "bumps.h5")
    return tmp_path / "bumps.h5"


def test_writing_in_blocks_equals_writing_at_once(tmp_path: Path) -> None:
    hm = bumps()
    parts = (hm.heights[:11], hm.heights[11:33], hm.heights[33:])
    surfaces.write_blocks(tmp_path / "b.h5", hm.shape, hm.spacing, parts, periodic=True)
    assert surfaces.read(tmp_path / "b.h5").digest == hm.digest


def test_masked_points_of_a_block_are_missing(tmp_path: Path) -> None:
    block = np.ma.masked_less(np.arange(16).reshape(4, 4), 2)
    surfaces.write_blocks(tmp_path / "a.h5", (4, 4), 1e-6, [block])
    np.testing.assert_array_equal(
        surfaces.read(tmp_path / "a.h5").heights[0], [np.nan] * 2 + [2, 3]
    )


@pytest.mark.parametrize("block", [np.ones((4, 4)) * 1j, [["a"] * 4] * 4])
def test_blocks_of_no_real_numbers_are_refused(tmp_path: Path, block: object) -> None:
    with pytest.raises(surfaces.InputError, match=r"block at row 0 is .* array of numbers"):
        surfaces.write_blocks(tmp_path / "a.h5", (4, 4), 1e-6, [block])


@pytest.mark.parametrize("suffix", [".h5", ".txt"])
def test_names_that_no_file_can_hold(tmp_path: Path, suffix: str) -> None:
    hm = bumps().replace(name="a\0b\ud800", history=({"step": "read", "source": "c\0"},))
    surfaces.write(hm, tmp_path / f"a{suffix}")
    assert surfaces.read(tmp_path / f"a{suffix}").name == hm.name == "a?b?"


def test_an_interrupted_write_leaves_the_old_file(stored: Path) -> None:
    def failing():
        yield bumps().heights[:20]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        surfaces.write_blocks(stored, (40, 57), SPACING, failing())
    assert surfaces.read(stored).digest == bumps().digest
    assert [path.name for path in stored.parent.iterdir()] == ["bumps.h5"]


def test_too_few_rows_are_refused(tmp_path: Path) -> None:
    with pytest.raises(SurfaceError, match="10 of 40 rows"):
        surfaces.write_blocks(tmp_path / "b.h5", (40, 57), SPACING, [np.zeros((10, 57))])
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("shape", "spacing", "match"),
    [
        ((2, 4), SPACING, "at least 3"),
        ((3, 4), (1e-6, -1e-6), "pixel size"),
        ((3, 4), SPACING, "inf"),
    ],
)
def test_what_could_not_be_read_again_is_not_written(tmp_path: Path, shape, spacing, match) -> None:
    blocks = [np.zeros((2, 4)), np.full((1, 4), np.inf)]
    with pytest.raises(InputError, match=match):
        surfaces.write_blocks(tmp_path / "b.h5", shape, spacing, blocks)
    assert list(tmp_path.iterdir()) == []


def test_missing_folder_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written"):
        surfaces.write(bumps(), tmp_path / "none" / "b.h5")


@pytest.mark.parametrize(
    ("argument", "value", "match"),
    [
        ("shape", 4, "shape is"),
        ("shape", (4, None), "shape is"),
        ("shape", (4.0, np.nan), "shape is"),
        ("blocks", None, "blocks is None"),
        ("history", None, "history is None; it is a sequence"),
        ("history", ["level"], "it is a sequence of mappings"),
        ("history", [{(1, 2): 3}], "history cannot be stored as JSON"),
        ("periodic", "no", "periodic is 'no'; it must be True or False"),
        ("path", None, "path of a file"),
    ],
)
def test_arguments_of_no_map_are_refused(tmp_path: Path, argument: str, value, match: str) -> None:
    given = {"path": tmp_path / "b.h5", "shape": (4, 4), "spacing": 1e-6, "blocks": [np.eye(4)]}
    with pytest.raises(InputError, match=match):
        surfaces.write_blocks(**(given | {argument: value}))
    assert list(tmp_path.iterdir()) == []


def test_float32_is_refused_where_an_offset_takes_its_digits(tmp_path: Path) -> None:
    """Heights of 20 nm at 50 mm had a curvature twice theirs."""
    hm = surfaces.self_affine((32, 40), (32e-6, 40e-6), hurst=0.8, rms_height=2e-8, seed=1)
    high = hm.replace(heights=hm.heights + 0.05)
    surfaces.write(high, tmp_path / "b.h5")
    surfaces.write(hm, tmp_path / "c.h5", dtype="float32")
    with pytest.raises(SurfaceError, match="float32 would change heights"):
        surfaces.write(high, tmp_path / "d.h5", dtype="float32")
    assert not (tmp_path / "d.h5").exists()
    single = high.replace(heights=high.heights.astype(np.float32))
    surfaces.write(single, tmp_path / "d.h5", dtype="float32")  # has no more to lose


def test_whole_numbers_of_points_may_be_floats(tmp_path: Path) -> None:
    surfaces.write_blocks(tmp_path / "b.h5", (4.0, 4.0), 1e-6, [np.eye(4)])
    assert surfaces.read(tmp_path / "b.h5").shape == (4, 4)


@pytest.mark.parametrize("suffix", [".h5", ".npz", ".csv", ".txt"])
def test_a_file_in_the_way_is_left_alone(tmp_path: Path, suffix: str) -> None:
    target = tmp_path / f"b{suffix}"
    target.mkdir()
    with pytest.raises(InputError, match="cannot be written"):
        surfaces.write(bumps(), target)
    assert [path.name for path in tmp_path.iterdir()] == [target.name]


@pytest.mark.parametrize("dtype", ["int8", "float16", "heights"])
def test_heights_are_not_stored_in_types_that_lose_them(tmp_path: Path, dtype: str) -> None:
    with pytest.raises(InputError, match="float64, float32"):
        surfaces.write(bumps(), tmp_path / "b.h5", dtype=dtype)
    assert list(tmp_path.iterdir()) == []


def test_a_generator_may_fill_its_blocks_into_one_array(tmp_path):
    """Rows that did not fill a chunk were held as a view of it, and overwritten."""

    def blocks():
        rows = np.empty((8, 32))
        for value in range(4):
            rows[:] = value
            yield rows

    surfaces.write_blocks(tmp_path / "a.h5", (32, 32), (1e-6, 1e-6), blocks())
    assert surfaces.read(tmp_path / "a.h5").heights[::8, 0].tolist() == [0.0, 1.0, 2.0, 3.0]


@pytest.mark.parametrize(("value", "why"), [(np.nan, "missing"), (1e40, "no calculation can hold")])
def test_blocks_that_no_map_can_hold_leave_no_file(tmp_path, value, why):
    with pytest.raises(surfaces.SurfaceError, match=why):
        surfaces.write_blocks(tmp_path / "a.h5", (4, 4), 1e-6, [np.full((4, 4), value)])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("share", [0.0, 0.01, 0.5, 0.99])
def test_a_full_disk_is_one_sentence(stored, share):
    """However much of the file it takes; the HDF5 library fails when it closes such a file."""
    known, (soft, hard) = surfaces.read(stored).digest, resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(share * stored.stat().st_size), hard))
    try:
        with pytest.raises(InputError, match=r"bumps\.h5: cannot be written"):
            surfaces.write(bumps(), stored)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert surfaces.read(stored).digest == known
    assert list(stored.parent.iterdir()) == [stored]
