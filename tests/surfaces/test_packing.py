"""Chunks packed by threads: the library's format, its checksums, its empty places."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

import surfaces
from surfaces.errors import FileFormatError
from surfaces.files._packing import FILTERS

SPACING = (2e-6, 3e-6)


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("shape", [(300, 530), (1, 257), (256, 4)])
def test_the_library_reads_what_threads_packed_and_the_reverse(tmp_path, dtype, shape) -> None:
    """Checksums are the library's: it refuses others. Chunks at the border are whole ones."""
    heights = np.random.default_rng(1).normal(0.0, 1e-7, (shape[0] + 2, shape[1])).astype(dtype)
    heights[-1] = 0.0
    path, library = tmp_path / "ours.h5", tmp_path / "library.h5"
    surfaces.write_blocks(path, heights.shape, SPACING, [heights], dtype=dtype)
    with h5py.File(path) as file, h5py.File(library, "w") as copy:
        np.testing.assert_array_equal(file["heights"], heights)
        made = copy.create_dataset(
            "heights", data=heights, chunks=file["heights"].chunks, **FILTERS
        )
        made.attrs.update(dict(file["heights"].attrs))
    for stored in (path, library):
        with surfaces.open(stored) as file:
            np.testing.assert_array_equal(file.heights(), heights.astype(np.float64))
            np.testing.assert_array_equal(file.heights((1, 3), (2, 4)), heights[1:3, 2:4])


def test_each_flipped_bit_of_a_chunk_is_told_or_harmless(tmp_path: Path) -> None:
    """Bits of codes that no height uses are harmless, and few."""
    path = tmp_path / "b.h5"
    heights = np.random.default_rng(2).normal(size=(300, 300))
    surfaces.write_blocks(path, (300, 300), SPACING, [heights])
    with h5py.File(path) as file:
        chunk = file["heights"].id.get_chunk_info_by_coord((256, 0))
    content, told = path.read_bytes(), 0
    for at in np.linspace(0, chunk.size - 1, 40).astype(int):
        damaged = bytearray(content)
        damaged[chunk.byte_offset + at] ^= 1
        path.write_bytes(damaged)
        with surfaces.open(path) as file:
            np.testing.assert_array_equal(file.heights((0, 256)), heights[:256])
            try:
                np.testing.assert_array_equal(file.heights(), heights)
            except FileFormatError as error:
                assert "of dataset /heights are damaged" in str(error)
                told += 1
    assert told > 30


def test_chunks_that_were_never_written_are_missing_points(tmp_path: Path) -> None:
    path = tmp_path / "b.h5"
    surfaces.write_blocks(path, (300, 300), SPACING, [np.eye(300)])
    with h5py.File(path, "r+") as file:
        old = file["heights"]
        new = file.create_dataset(
            "h", old.shape, old.dtype, chunks=old.chunks, fillvalue=np.nan, **FILTERS
        )
        new[:256] = old[:256]
        new.attrs.update(dict(old.attrs))
    hm = surfaces.read(path, dataset="h")
    assert hm.missing == 44 * 300 and np.isnan(hm.heights[256:]).all()
