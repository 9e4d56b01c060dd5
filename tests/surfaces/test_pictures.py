"""Height maps in grey pictures: numbers as they are stored, and what is none refused."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

import surfaces
from surfaces.errors import FileFormatError

NUMBERS = np.random.default_rng(4)
GREY = NUMBERS.integers(0, 65536, (12, 17)).astype(np.uint16)


@pytest.mark.parametrize("kind", [np.uint8, np.int16, np.int32, np.float32])
def test_numbers_of_a_tiff(tmp_path: Path, kind: type) -> None:
    values = NUMBERS.integers(0, 200, (5, 7)).astype(kind)
    assert cv2.imwrite(str(tmp_path / "a.tiff"), values)
    hm = surfaces.read(tmp_path / "a.tiff", unit="um", spacing=1e-6)
    np.testing.assert_array_equal(hm.heights, values.astype(float) * 1e-6)


def test_what_is_no_grey_picture_is_refused(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((5, 6, 3), np.uint8))
    cv2.imwritemulti(str(tmp_path / "b.tif"), [GREY, GREY])
    for name in ("a.png", "b.tif"):
        with pytest.raises(FileFormatError, match="in color, of several pages or fewer"):
            surfaces.read(tmp_path / name, unit="um", spacing=1e-6)


def test_a_damaged_png_is_told_of_once(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.png"
    cv2.imwrite(str(path), NUMBERS.integers(0, 60000, (16, 21)).astype(np.uint16))
    content = path.read_bytes()
    assert surfaces.read(path, unit="nm", spacing=1e-6).shape == (16, 21)
    for at in (20, 30, 60, len(content) - 20):
        path.write_bytes(content[:at] + bytes([content[at] ^ 255]) + content[at + 1 :])
        with pytest.raises(FileFormatError, match="as a picture, it is damaged"):
            surfaces.read(path, unit="nm", spacing=1e-6)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(("side", "bits"), [(60000, 8), (5, 4)])
def test_pictures_too_large_or_too_coarse_are_refused(tmp_path: Path, side: int, bits: int) -> None:
    """OpenCV raises its own error on the first, and stretches grey levels of 4 bits to 8."""
    parts = {
        b"IHDR": struct.pack(">IIBBBBB", side, side, bits, 0, 0, 0, 0),
        b"IDAT": zlib.compress(b"\0\x12\x34\x50" * 5),
        b"IEND": b"",
    }
    chunks = (
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in parts.items()
    )
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunks))
    with pytest.raises(FileFormatError, match="damaged, in color, of several pages or fewer than"):
        surfaces.read(tmp_path / "a.png", unit="nm", spacing=1e-6)


def test_pictures_that_call_zero_white_are_refused(tmp_path: Path) -> None:
    """The library turns those of 8 bits over, and leaves others."""
    path = tmp_path / "a.tif"
    cv2.imwrite(str(path), np.arange(64, dtype=np.uint8).reshape(8, 8))
    content = bytearray(path.read_bytes())
    surfaces.read(path, unit="nm", spacing=1e-6)
    order = "little" if content[:2] == b"II" else "big"
    first = int.from_bytes(content[4:8], order)
    for entry in range(int.from_bytes(content[first : first + 2], order)):
        at = first + 2 + 12 * entry
        if int.from_bytes(content[at : at + 2], order) == 262:
            content[at + 8 : at + 10] = b"\0\0"
    path.write_bytes(content)
    with pytest.raises(FileFormatError, match="0 is white"):
        surfaces.read(path, unit="nm", spacing=1e-6)
