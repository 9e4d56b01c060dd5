"""A scratch file gives back what was written, by rows or by columns, and says when it is full."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest

from surfaces.errors import InputError
from surfaces.numerics.scratch import Scratch, spans


@pytest.mark.parametrize("width", [1, 3, 7, 50])
def test_written_by_rows_and_read_by_columns_and_the_reverse(tmp_path: Path, width: int) -> None:
    values = np.random.default_rng(0).normal(size=(11, 7, 2)).view(np.complex128)[..., 0]
    with Scratch(values.shape, width, tmp_path) as scratch:
        for first, last in spans(11, 4):
            for left, right in scratch.sections:
                scratch.write((left, right), first, values[first:last, left:right])
        for left, right in scratch.sections:
            found = scratch.read((left, right), (0, 11))
            np.testing.assert_array_equal(found, values[:, left:right])
            np.testing.assert_array_equal(scratch.read((left, right), (3, 5)), found[3:5])
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no file that is always full")
def test_a_full_disk_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "TemporaryFile", lambda dir: open("/dev/full", "r+b"))
    with (
        Scratch((1000, 100), 100, tmp_path) as scratch,
        pytest.raises(InputError, match=r"temporary file of 0\.0016 GB cannot be written"),
    ):
        scratch.write((0, 100), 0, np.zeros((1000, 100), np.complex128))
