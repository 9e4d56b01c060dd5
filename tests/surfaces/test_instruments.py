"""Files of instruments, read by other libraries."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from samples import SPACING

import surfaces
from surfaces.errors import FileFormatError, InputError, SurfaceError

HEIGHTS = np.random.default_rng(4).normal(0.0, 5.0, (12, 17))


def test_missing_extra_gives_the_pip_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    (tmp_path / "a.sur").write_bytes(b"DIGITAL SURF")
    with pytest.raises(FileFormatError, match=r"pip install 'asperity\[formats\]'"):
        surfaces.read(tmp_path / "a.sur")


@pytest.mark.parametrize("failure", [RuntimeError("numpy ABI"), OSError("libz.so"), SyntaxError()])
def test_broken_extra_gives_the_pip_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failure: Exception
) -> None:
    class Broken:
        def find_spec(self, name: str, path: object, target: ModuleType | None = None) -> None:
            if name == "SurfaceTopography":
                raise failure

    for name in [name for name in sys.modules if name.split(".")[0] == "SurfaceTopography"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "meta_path", [Broken(), *sys.meta_path])
    (tmp_path / "a.sur").write_bytes(b"DIGITAL SURF")
    with pytest.raises(FileFormatError, match=r"is broken .*--force-reinstall"):
        surfaces.read(tmp_path / "a.sur")


TWINS = {
    "al3d-1.al3d": "focusvar_small_steep.h5",
    "KautschukInfiniteFocus.x3p": "optical_rubber_missing.h5",
    "di-3.di": "afm_10um_rough.h5",
}


@pytest.mark.parametrize("raw", TWINS)
def test_instrument_files_equal_their_twins(measured: Path, raw: str) -> None:
    pytest.importorskip("SurfaceTopography")
    twin = surfaces.read(measured / TWINS[raw])
    hm = surfaces.read(measured / "raw" / raw)
    offset = twin.history[0]["height_offset_removed"]
    rounding = 2.0**-23 * np.nanmax(np.abs(twin.heights)) + 2.0**-50 * abs(offset)
    np.testing.assert_allclose(hm.heights - offset, twin.heights, rtol=0, atol=rounding)
    assert hm.spacing == pytest.approx(twin.spacing, rel=1e-7)
    assert hm.missing == twin.missing


def test_instrument_text_without_size_takes_it_from_the_options(tmp_path: Path) -> None:
    pytest.importorskip("SurfaceTopography")
    rows = "\n".join(" ".join(f"{v:.3f}" for v in row) for row in np.nan_to_num(HEIGHTS))
    (tmp_path / "a.asc").write_text("made by a machine\n" + rows)
    with pytest.raises(FileFormatError, match="states no unit; pass --unit"):
        surfaces.read(tmp_path / "a.asc", spacing=SPACING)
    with pytest.raises(FileFormatError, match="states no pixel size; pass --spacing"):
        surfaces.read(tmp_path / "a.asc", unit="um")
    with pytest.raises(SurfaceError, match="give the pixel size"):
        surfaces.read(tmp_path / "a.asc", unit="um", spacing="fine")
    hm = surfaces.read(tmp_path / "a.asc", unit="um", spacing=SPACING)
    assert hm.spacing == pytest.approx(SPACING)


def test_what_the_library_computes_with_no_numbers_is_not_warned_of(tmp_path: Path) -> None:
    pytest.importorskip("SurfaceTopography")
    (tmp_path / "a.csv").write_text("a,b\n1,2\n")
    with pytest.raises(FileFormatError, match="states no unit"):
        surfaces.read(tmp_path / "a.csv")


def test_digital_surf(measured: Path) -> None:
    pytest.importorskip("SurfaceTopography")
    hm = surfaces.read(measured / "raw" / "test_uncompressed.sur")
    assert hm.shape == (512, 512)
    assert hm.size == pytest.approx((10.025e-6, 10.02e-6), rel=5e-4)
    assert hm.rms_height == pytest.approx(119.1e-9, rel=1e-3)


def test_damaged_instrument_files(measured: Path, tmp_path: Path) -> None:
    pytest.importorskip("SurfaceTopography")
    for source in sorted((measured / "raw").iterdir()):
        content = source.read_bytes()
        for keep in (0.02, 0.5):
            path = tmp_path / source.name
            path.write_bytes(content[: int(keep * len(content))])
            with pytest.raises(InputError, match=source.name):
                surfaces.read(path)
