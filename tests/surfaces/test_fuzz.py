"""Damaged files: no traceback, no hang, no memory blow-up, and never another map."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import surfaces
from surfaces.errors import FileFormatError

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = Path(__file__).with_name("fuzz_hdf5.py")


def test_mutated_files_read_correctly_or_raise_one_sentence() -> None:
    """ASPERITY_FUZZ sets the number of files; the bar is 5000."""
    count = os.environ.get("ASPERITY_FUZZ", "120")
    done = subprocess.run(
        [sys.executable, SCRIPT, "--count", count, "--verbose"],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout.splitlines()[-1:] + done.stderr.splitlines()[-3:]
    assert "ours bytes: other" not in done.stdout
    assert "ours bytes: same" in done.stdout and "FileFormatError" in done.stdout


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the guard needs fork")
def test_a_heap_that_hangs_the_library_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Zeros in the heap of the text attributes send HDF5 into an endless loop."""
    monkeypatch.setattr("surfaces.files._container.CPU_SECONDS", 1)
    path = tmp_path / "a.h5"
    surfaces.write(surfaces.HeightMap(np.eye(5, 7), 1e-6), path)
    content = bytearray(path.read_bytes())
    heap = content.find(b"GCOL")
    assert heap > 0
    content[heap + 16 : heap + 4096] = bytes(4080)
    path.write_bytes(content)
    with pytest.raises(FileFormatError, match="hang or crash the HDF5 library"):
        surfaces.read(path)
    assert "hang or crash" in str(surfaces.validate(path)[0])


def test_our_own_files_are_read_without_a_child_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their metadata have checksums, and the heaps of their texts end where they say."""

    def refused() -> int:
        raise AssertionError("a process was forked")

    monkeypatch.setattr(os, "fork", refused, raising=False)
    for length in (1, 2, 3, 5, 8, 4000, 70_000):
        history = ({"step": "note", "text": "µ" * length}, {"step": "stylus", "source": "a stylus"})
        hm = surfaces.HeightMap(np.eye(5, 7), 1e-6, name="Å" * length, history=history)
        surfaces.write(hm, tmp_path / "a.h5")
        found = surfaces.read(tmp_path / "a.h5")
        assert (found.name, found.history[: len(history)]) == (hm.name, history)
        assert found.digest == hm.digest
