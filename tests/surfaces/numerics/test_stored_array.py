"""Sections of columns on disk give back what was written, by rows or by sections."""

from __future__ import annotations

import gc
import os
import sys
import threading
import warnings
from pathlib import Path

import numpy as np
import pytest

from surfaces.errors import InputError
from surfaces.numerics.stored_array import Sections, StoredArray, drop_pages, spans


@pytest.mark.parametrize("kind", [np.complex128, np.float32])
@pytest.mark.parametrize("width", [1, 3, 7, 50])
def test_written_by_rows_and_read_by_sections_and_the_reverse(
    tmp_path: Path, width: int, kind: type
) -> None:
    values = np.random.default_rng(0).normal(size=(11, 7)).astype(kind) * kind(1.5)
    by_rows, by_sections = (Sections(values.shape, width, kind, tmp_path) for _ in range(2))
    for first, last in spans(11, 4):
        by_rows.write_rows(first, values[first:last])
    for section, columns in enumerate(by_sections.columns):
        by_sections.write(section, 0, values[:, slice(*columns)])
    for section, columns in enumerate(by_rows.columns):
        for stored in (by_rows, by_sections):
            found = stored.read(section)
            np.testing.assert_array_equal(found, values[:, slice(*columns)])
            np.testing.assert_array_equal(stored.read(section, 3, 5), found[3:5])
    assert [*by_rows.columns] == spans(7, width)
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.posix_fallocate", full)
    for folder, remedy in ((tmp_path, "make room there"), (None, "set TMPDIR to a folder")):
        with pytest.raises(InputError, match=rf"has no room for 0\.0016 GB.*{remedy}"):
            Sections((1000, 100), 100, np.complex128, folder)


def test_a_file_is_closed_without_a_warning_also_when_it_is_part_of_a_cycle() -> None:
    stored = StoredArray((3, 4), float)
    stored.write(0, np.ones((3, 4)))
    number = stored._file.fileno()
    stored.itself = stored.each(np.negative)  # type: ignore[attr-defined]
    stored.itself.back = stored
    with warnings.catch_warnings(record=True) as leaked:
        warnings.simplefilter("always")
        del stored
        gc.collect()
    assert not leaked
    with pytest.raises(OSError):
        os.fstat(number)


def test_pages_are_dropped_while_another_thread_maps_arrays():
    kept = StoredArray((8, 8), np.float64)
    kept.write(0, np.zeros((8, 8)))
    done, before = threading.Event(), sys.getswitchinterval()

    def map_anew():
        while not done.is_set():
            held = [kept.each(np.negative).mapped for _ in range(50)]
            assert len(held) == 50

    sys.setswitchinterval(1e-6)
    mapper = threading.Thread(target=map_anew)
    mapper.start()
    try:
        for _ in range(2000):
            drop_pages()
    finally:
        done.set()
        mapper.join()
        sys.setswitchinterval(before)
