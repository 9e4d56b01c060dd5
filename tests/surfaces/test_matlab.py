"""MATLAB files: matrices as they are shown, and faults in one sentence."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

import surfaces
from surfaces.errors import FileFormatError

HEIGHTS = np.random.default_rng(4).normal(0.0, 5.0, (12, 17))


def test_a_matlab_matrix_is_as_it_is_shown(tmp_path: Path) -> None:
    """One row for each y, without any extra."""
    heights, path = HEIGHTS[:, :9], tmp_path / "a.mat"
    savemat(path, {"z": heights, "unit": "um", "spacing": [1e-6, 3e-6], "periodic": True})
    hm = surfaces.read(path)
    np.testing.assert_allclose(hm.heights, heights * 1e-6, rtol=1e-15)
    assert (hm.spacing, hm.periodic) == ((1e-6, 3e-6), True)
    savemat(path, {"z": heights.T, "other": np.eye(3)}, do_compression=True)
    with pytest.raises(FileFormatError, match="the file holds z, other; name the heights"):
        surfaces.read(path, unit="um", spacing=1e-6)
    assert surfaces.read(path, dataset="z", unit="um", spacing=1e-6).shape == (9, 12)


@pytest.mark.parametrize(
    ("value", "message"),
    [(HEIGHTS * 1j, "complex128"), ("text", "real numbers"), (1.0, "real numbers")],
)
def test_matlab_variables_that_are_no_heights(tmp_path: Path, value, message: str) -> None:
    savemat(tmp_path / "a.mat", {"z": value})
    with pytest.raises(FileFormatError, match=message):
        surfaces.read(tmp_path / "a.mat", unit="um", spacing=1e-6)


def test_matlab_files_of_another_kind(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    header = b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM"
    path.write_bytes(header.ljust(512, b"\0") + b"\x89HDF\r\n\x1a\n" + bytes(64))
    with pytest.raises(FileFormatError, match=r"MATLAB 7\.3; save it with -v7"):
        surfaces.read(path)
    savemat(path, {"z": HEIGHTS})
    for content in (path.read_bytes()[:300], b"no matrix"):
        path.write_bytes(content)
        with pytest.raises(FileFormatError, match="damaged, or not as its format says"):
            surfaces.read(path)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no child processes are forked here")
def test_a_matlab_file_that_crashes_its_reader(tmp_path: Path, monkeypatch) -> None:
    savemat(tmp_path / "a.mat", {"z": HEIGHTS})
    monkeypatch.setattr("scipy.io.loadmat", lambda *_, **__: os.kill(os.getpid(), 9))
    with pytest.raises(FileFormatError, match="damaged, it crashes the library"):
        surfaces.read(tmp_path / "a.mat", unit="um", spacing=1e-6)
