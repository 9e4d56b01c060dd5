"""Height maps in plain arrays: npy, npz and text, whose units come from the caller or a comment."""

from __future__ import annotations

import codecs
import contextlib
import math
import re
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surfaces.errors import FileFormatError, as_text, shown
from surfaces.heightmap import HeightMap
from surfaces.numerics.memory import require_memory
from surfaces.units import chosen_unit, metres_per

from ._damage import naming_damage
from ._schema import one_spacing, stated_value, truth
from .atomic import replacing
from .columns import gridded

__all__ = [
    "as_map",
    "heading",
    "named_map",
    "read_npy",
    "read_npz",
    "read_text",
    "require_unnamed",
    "write_npz",
    "write_text",
]

_MISSING = {"", "nan", "na", "n/a", "#n/a", "bad", "none", "null"}
_MISSING |= {"-", "--", "---", "*", "**", "***"}
_COMMENT = "#%;/!"
_SHAPE = re.compile(r"\W*(\d{1,15})\W+(\d{1,15})\W*")
_HEAD = 2**16  # bytes that tell how a text is encoded

_STATED = re.compile(r"^\W*(spacing|unit|periodic|name|shape)\s*[:=]\s*(\S.*?)\s*$", re.IGNORECASE)


def read_npy(
    path: Path, dataset: str | None, unit: str | None, spacing: ArrayLike | None
) -> HeightMap:
    """Heights from an npy file; `unit` and `spacing` must be given."""
    require_unnamed(path, dataset)
    with naming_damage(path, "damaged or not a plain npy array"):
        array = np.load(path, mmap_mode="r", allow_pickle=False)
    return as_map(array, path, unit, spacing, {})


def read_npz(
    path: Path, dataset: str | None, unit: str | None, spacing: ArrayLike | None
) -> HeightMap:
    """Heights from one array of an npz file; arrays ``unit`` and ``spacing`` in it are used."""
    with naming_damage(path, "damaged or not a plain npz file"):
        with zipfile.ZipFile(path) as archive:
            names = [name.removesuffix(".npy") for name in archive.namelist()]
            for name in archive.namelist():
                with archive.open(name) as member:
                    _check_npy_header(member, archive.getinfo(name).file_size, name)
        with np.load(path, allow_pickle=False) as arrays:
            return named_map(names, arrays, path, dataset, unit, spacing)


def named_map(
    names: list[str],
    arrays: Mapping[str, NDArray[Any]],
    path: Path,
    dataset: str | None,
    unit: str | None,
    spacing: ArrayLike | None,
) -> HeightMap:
    """The map in one of some arrays with names, of which some may state its facts."""
    facts = {"unit", "spacing", "periodic", "name"} & {*names}
    planes = [name for name in names if name not in facts]
    alone = planes[0] if len(planes) == 1 else "heights"
    wanted = dataset or ("heights" if "heights" in names else alone)
    if wanted not in names:
        raise FileFormatError(
            f"{path}: no array {dataset or 'heights'!r}; the file holds "
            f"{', '.join(names) or 'none'}; name the heights with --dataset (dataset=...)"
        )
    stated = {key: stated_value(arrays[key]) for key in facts}
    return as_map(np.asarray(arrays[wanted]), path, unit, spacing, stated)


def heading(path: Path) -> str | None:
    """What of a text is no row of numbers before the first: None if nothing, "" if it is no text.

    Comments do not count.
    """
    try:
        with _opened(path) as file:
            for number, _, cells in _lines(file):
                if cells is not None:
                    word = next((cell for cell in cells if not _is_number(cell)), None)
                    return None if word is None else _no_number(number, word)
    except UnicodeError:
        return ""
    return None


def read_text(
    path: Path, dataset: str | None, unit: str | None, spacing: ArrayLike | None
) -> HeightMap:
    """Heights from rows of numbers; comment lines ``unit = um``, ``spacing = DY DX`` are used.

    Columns x, y, z of the points of an even grid are understood. The unit is that of all three,
    unless a spacing is given. A comment ``shape = NY NX`` tells three columns of heights from them,
    and whether the text is whole.
    """
    require_unnamed(path, dataset)
    require_memory(
        12 * path.stat().st_size, f"{path}: reading the text", "convert it to HDF5 in pieces"
    )
    try:
        stated, rows = _parsed(path)
    except UnicodeError as error:
        raise FileFormatError(f"{path}: damaged text ({error})") from error
    if "spacing" in stated:
        try:
            stated["spacing"] = [_number(word) for word in re.split(r"[,\s]+", stated["spacing"])]
        except ValueError:
            raise FileFormatError(f"{path}: spacing = {stated['spacing']} is not DY DX") from None
    heights = np.vstack(rows)
    whole = _SHAPE.fullmatch(stated.pop("shape", ""))
    shape = (int(whole[1]), int(whole[2])) if whole else None
    points = None if shape == heights.shape else gridded(heights)
    if points is not None:
        heights, pixel = points
        unit = chosen_unit(stated.get("unit"), unit)
        if spacing is None:  # else the unit of x and y is unknown
            stated.setdefault("spacing", [step * metres_per(unit) for step in pixel])
    elif path.suffix.lower() == ".xyz":
        raise FileFormatError(f"{path}: its points x, y, z lie on no even grid")
    if shape and math.prod(shape) != heights.size:
        raise FileFormatError(
            f"{path}: states {shape[0]} x {shape[1]} points and holds {heights.shape[0]} x "
            f"{heights.shape[1]}; copy it again from its source"
        )
    hm = as_map(heights, path, unit, spacing, stated)
    if points is not None and not np.isclose(np.divide(*hm.spacing), np.divide(*pixel), rtol=1e-3):
        raise FileFormatError(
            f"{path}: a spacing of {hm.spacing[0]:g} x {hm.spacing[1]:g} m was given as (dy, dx), "
            f"but its points are {pixel[0]:g} x {pixel[1]:g} apart along y and x"
        )
    return hm


def write_npz(hm: HeightMap, path: Path) -> None:
    """Write heights [m], spacing, unit, periodic and name as the arrays of an npz file."""
    with replacing(path) as part, part.open("wb") as file:
        np.savez_compressed(
            file,
            heights=hm.heights,
            spacing=np.array(hm.spacing),
            unit=np.array("m"),
            periodic=np.array(hm.periodic),
            name=np.array(hm.name),
        )


def write_text(hm: HeightMap, path: Path) -> None:
    """Write heights [m] as rows of numbers below comment lines with spacing and unit."""
    dy, dx = hm.spacing
    name = " ".join(as_text(hm.name).split())
    ny, nx = hm.shape
    header = (
        f"unit = m\nspacing = {dy!r} {dx!r}\nshape = {ny} {nx}\nperiodic = {hm.periodic}\n"
        f"name = {name}"
    )
    separator = "," if path.suffix.lower() == ".csv" else " "
    with replacing(path) as part:
        np.savetxt(
            part, hm.heights, fmt="%.17g", delimiter=separator, header=header, encoding="utf-8"
        )


def require_unnamed(path: Path, dataset: str | None) -> None:
    """Refuse the name of a dataset for a file that holds one array."""
    if dataset is not None:
        raise FileFormatError(f"{path}: holds one array without a name; leave out --dataset")


def _opened(path: Path) -> IO[str]:
    """The text, in the encoding that its first bytes tell; a single byte is a letter otherwise."""
    with path.open("rb") as file:
        head = file.read(_HEAD)
    if b"\0" in head and not head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        raise UnicodeError("zero bytes")
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return path.open(encoding="utf-16")
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return path.open(encoding="latin-1")
    return path.open(encoding="utf-8-sig")


def _parsed(path: Path) -> tuple[dict[str, Any], list[NDArray[np.float64]]]:
    """What the comments state, and the rows of numbers."""
    stated: dict[str, Any] = {}
    rows: list[NDArray[np.float64]] = []
    widths: set[int] = set()
    with _opened(path) as file:
        for number, line, cells in _lines(file):
            if cells is None:
                if match := _STATED.match(line):
                    key, word = match[1].lower(), match[2]
                    if stated.setdefault(key, word) != word:
                        raise FileFormatError(
                            f"{path}: line {number} states {key} = {shown(word)} and one above "
                            f"{shown(stated[key])}; leave one"
                        )
                continue
            # an empty last cell is a missing point, or none if every row ends in a separator
            fits = {len(cells), len(cells) - (cells[-1] == "")}
            if rows and not widths & fits:
                raise FileFormatError(
                    f"{path}: line {number} has {min(fits)} numbers where the first row has "
                    f"{min(widths)}; write missing points as nan"
                )
            widths = widths & fits if rows else fits
            rows.append(_numbers(cells, path, number))
    if not rows:
        raise FileFormatError(f"{path}: there are no rows of numbers")
    return stated, [row[: min(widths)] for row in rows]


def as_map(
    array: NDArray[Any],
    path: Path,
    unit: str | None,
    spacing: ArrayLike | None,
    stated: dict[str, Any],
    **origin: str,
) -> HeightMap:
    """The map of an array from what a file states of it and what the caller says; its history
    begins with the file, its unit and the rest of its `origin`."""
    if array.dtype.kind not in "fiu" or array.ndim != 2:
        raise FileFormatError(
            f"{path}: holds {array.dtype} of shape {array.shape}; heights are real numbers, 2-D"
        )
    chosen = chosen_unit(stated.get("unit"), unit)
    pixel = one_spacing(stated.get("spacing"), spacing)
    require_memory(24 * array.size, f"{path}: a map of {array.shape}", "crop it first")
    with np.errstate(all="ignore"):
        heights = np.asarray(array, dtype=np.float64) * metres_per(chosen)
    return HeightMap(
        heights,
        pixel,
        periodic=truth(stated.get("periodic", False)),
        name=str(stated.get("name") or path.stem),
        history=({"step": "read", "file": path.name, **origin, "unit": chosen},),
    )


def _check_npy_header(member: IO[bytes], size: int, name: str) -> None:
    """Refuse an array whose header promises more than the archive holds."""
    version = np.lib.format.read_magic(member)
    reader = (
        np.lib.format.read_array_header_1_0
        if version == (1, 0)
        else np.lib.format.read_array_header_2_0
    )
    shape, _, dtype = reader(member)
    points = math.prod(int(n) for n in shape)
    promised = points * dtype.itemsize
    if dtype.hasobject or promised > size:
        raise FileFormatError(f"array {name} promises {promised} bytes and the file holds {size}")
    require_memory(24 * points, f"array {name} of shape {shape}", "save a part of it")


def _lines(file: Iterable[str]) -> Iterator[tuple[int, str, list[str] | None]]:
    """Number and text of each line, and its cells if it is a row: None of comments and blanks."""
    separator, mark = "", ""
    for number, line in enumerate(file, start=1):
        # a blank is any white space
        by = separator or next((mark for mark in ";\t," if mark in line.strip(" \r\n")), " ")
        marks = "".join(m for m in ",." if m in line) if by in ";\t" else ""
        numbers = line.replace(",", ".") if marks == "," else line
        cells = [cell.strip() for cell in numbers.strip(" \r\n").split(None if by == " " else by)]
        # a row may begin with a missing point, which is a blank or looks like a comment
        looks_like_none = line.strip()[:1] in _COMMENT
        if looks_like_none and not (len(cells) > 2 and all(map(_is_number, cells))):
            yield number, line, None
            continue
        if mark and (other := marks.replace(mark, "")):
            raise FileFormatError(
                f"line {number} holds {other!r} where rows above have {mark!r} as decimal mark"
            )
        separator, mark = by, mark or marks
        yield number, line, cells


def _number(cell: str) -> float:
    """The number of a cell; 1_0 and digits of other scripts are numbers in Python alone."""
    if "_" in cell or not cell.isascii():
        raise ValueError
    return float(cell)


def _is_number(cell: str) -> bool:
    try:
        _number(cell)
    except ValueError:
        return cell.lower() in _MISSING
    return True


def _no_number(line: int, cell: str) -> str:
    return f"line {line} holds {cell[:20]!r}, which is no number; start comments with #"


def _numbers(cells: list[str], path: Path, line: int) -> NDArray[np.float64]:
    line_of_cells = "".join(cells)
    if "_" not in line_of_cells and line_of_cells.isascii():
        with contextlib.suppress(ValueError):
            return np.array(cells, dtype=np.float64)
    bad = next((cell for cell in cells if not _is_number(cell)), None)
    if bad is not None:
        raise FileFormatError(f"{path}: {_no_number(line, bad)}")
    return np.array([np.nan if c.lower() in _MISSING else float(c) for c in cells])
