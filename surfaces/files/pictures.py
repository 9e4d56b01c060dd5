"""Height maps in grey pictures, TIFF and PNG, whose scales come from the caller."""

from __future__ import annotations

import zlib
from pathlib import Path
from typing import Any, Literal

import cv2
from numpy.typing import ArrayLike, NDArray

from surfaces.errors import FileFormatError
from surfaces.heightmap import HeightMap

from .arrays import as_map, require_unnamed
from .instruments import read_instrument

__all__ = ["read_picture"]

_PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_INTERPRETATION = 262  # tag of a TIFF: 0 if white is zero
_PNG_DEPTH = 24  # place of the bits per grey level


def read_picture(
    path: Path, dataset: str | None, unit: str | None, spacing: ArrayLike | None
) -> HeightMap:
    """Heights from a grey picture; the first row of the picture is the first row of the map.

    PNG of 8 or 16 bits, or TIFF of whole or floating-point numbers, NaN where missing. A picture
    never states its unit, the height of one grey level, such as 2.5nm. What is no grey picture of
    one page may still be a format of an instrument.
    """
    content = path.read_bytes()
    if _white_is_zero(content):
        raise FileFormatError(
            f"{path}: states that 0 is white, and so leaves open whether bright is high; save it "
            "with 0 as black"
        )
    grey = _only_page(str(path), content)
    if grey is None or grey.ndim != 2:
        hint = "; as a picture, it is damaged, in color, of several pages or fewer than 8 bits"
        return read_instrument(path, dataset, unit, spacing, hint)
    require_unnamed(path, dataset)
    if unit is None:
        raise FileFormatError(
            f"{path}: states no unit; pass the height of one grey level, such as --unit 2.5nm "
            '(unit="2.5nm")'
        )
    return as_map(grey, path, unit, spacing, {})


def _only_page(path: str, content: bytes) -> NDArray[Any] | None:
    """The picture of a file with this content; None if it holds several or fewer than 8 bits, which
    OpenCV stretches to 8, or is damaged."""
    log: Any = getattr(cv2.utils, "logging", cv2)  # since OpenCV 5
    told = log.setLogLevel(0)
    try:
        if _is_sound(content) and cv2.haveImageReader(path) and cv2.imcount(path) == 1:
            return cv2.imread(path, cv2.IMREAD_UNCHANGED)
        return None
    except cv2.error:  # a header that states more points than the library takes
        return None
    finally:
        log.setLogLevel(told)


def _white_is_zero(content: bytes) -> bool:
    """Whether the first page of a TIFF says so: the library turns such pictures of 8 bits over, and
    leaves others."""
    if content[:4] not in (b"II*\0", b"MM\0*"):
        return False
    order: Literal["little", "big"] = "little" if content[:1] == b"I" else "big"

    def number(at: int, size: int) -> int:
        return int.from_bytes(content[at : at + size], order)

    first = number(4, 4)
    entries = (first + 2 + 12 * entry for entry in range(number(first, 2)))
    return any(number(at, 2) == _INTERPRETATION and number(at + 8, 2) == 0 for at in entries)


def _is_sound(content: bytes) -> bool:
    """Whether a picture is no PNG, or a PNG of 8 bits or more with sound checksums: of others the
    library writes to the terminal."""
    at = len(_PNG_SIGNATURE)
    if content[:at] != _PNG_SIGNATURE:
        return True
    if content[_PNG_DEPTH : _PNG_DEPTH + 1] < b"\x08":
        return False
    while at + 12 <= len(content):  # each part: length, kind of four letters, data, checksum
        end = at + 8 + int.from_bytes(content[at : at + 4])
        if zlib.crc32(content[at + 4 : end]) != int.from_bytes(content[end : end + 4]):
            return False
        if content[at + 4 : at + 8] == b"IEND":
            return True
        at = end + 4
    return False
