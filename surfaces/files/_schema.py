"""Schema of a height-map dataset: its header, and every fault of a file."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike

from surfaces.errors import InputError, checked_spacing, shown
from surfaces.units import chosen_unit

from ._damage import DAMAGED, brief

Tell = Callable[..., None]
"""Adds a fault of a dataset to those found: its text without the name, and whether it is fatal."""

SCHEMA = "surface/1"

_TRUTH = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False, "": False}

_MAX_ATTRIBUTE = 1 << 20  # bytes
_MAX_CHUNK = 1 << 30  # bytes
_KNOWN_FILTERS = {1: "gzip", 2: "shuffle", 3: "fletcher32", 4: "szip", 5: "nbit", 6: "scaleoffset"}
_KNOWN_FILTERS[32000] = "lzf"


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong with a file.

    Attributes
    ----------
    text
        What is wrong, where, and how to mend it, in one sentence.
    fatal
        True if the heights cannot be read safely as the file stands.

    Examples
    --------
    >>> import surfaces
    >>> str(surfaces.Fault("no unit").text)
    'no unit'
    """

    text: str
    fatal: bool = True

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True)
class Packing:
    """How stored numbers stand for heights: ``scale number + offset`` in the unit, or missing if
    they are among `blanks`. The attributes are those of the netCDF conventions."""

    scale: float = 1.0
    offset: float = 0.0
    blanks: tuple[float, ...] = ()


@dataclass(frozen=True)
class Chunks:
    """The chunks of a dataset of which some are not stored: their points are read as `fill`."""

    shape: tuple[int, int]
    corners: Sequence[tuple[int, int]]
    """First row and column of each that is stored."""

    total: int
    fill: float


@dataclass(frozen=True)
class Header:
    """What a dataset says about its heights, checked; lengths in metres."""

    shape: tuple[int, int]
    spacing: tuple[float, float]
    unit: str
    periodic: bool
    name: str
    history: tuple[Mapping[str, Any], ...]
    notes: Mapping[str, Any]
    packing: Packing
    chunks: Chunks | None = None


def read_header(
    dataset: h5py.Dataset,
    *,
    unit: str | None = None,
    spacing: tuple[float, float] | None = None,
) -> tuple[Header | None, list[Fault]]:
    """Header of a dataset and all its faults; the header is None if a fault is fatal.

    The unit of the heights and the spacing (dy, dx) [m] are needed where the file states none.
    """
    faults, chunks = list(array_faults(dataset)), None
    if not any(fault.fatal for fault in faults):
        faults += _storage_faults(dataset, f"dataset {dataset.name}")
    if not any(fault.fatal for fault in faults):
        chunks = _chunks(dataset)
    attributes = _attributes(dataset, f"dataset {dataset.name}", faults)
    return header_of(dataset, attributes, faults, chunks, unit=unit, spacing=spacing)


def header_of(
    dataset: Any,
    attributes: dict[str, Any],
    faults: list[Fault],
    chunks: Chunks | None,
    *,
    unit: str | None,
    spacing: tuple[float, float] | None,
) -> tuple[Header | None, list[Fault]]:
    """As `read_header`, of the attributes of an array whose other faults are known, and its chunks
    if some are not stored."""

    def tell(text: str, fatal: bool = True) -> None:
        faults.append(Fault(f"dataset {dataset.name}{text}", fatal))

    def read(name: str, find: Callable[[Any], Any], default: Any) -> Any:
        absent = "" if name in attributes else holds
        try:
            return find(attributes.pop(name, None))
        except InputError as error:
            tell(f": {error}{absent}")
            return default

    attributes = {key: stated_value(value) for key, value in attributes.items()}
    holds = f" (its attributes: {', '.join(attributes) or 'none'})"[:200]
    pixel = read("spacing", lambda stated: one_spacing(stated, spacing), (0.0, 0.0))
    stated = read("unit", lambda stated: chosen_unit(stated, unit), "")
    if "periodic" not in attributes:
        tell(" has no attribute periodic; it is read as False", False)
    periodic = read("periodic", lambda stated: stated is not None and truth(stated), False)
    schema = attributes.pop("schema", None)
    if schema is None:
        tell(f' has no attribute schema; schema 1 files say "{SCHEMA}"', False)
    elif not isinstance(schema, str) or schema != SCHEMA:
        tell(f" has schema {shown(schema)}; this version reads {SCHEMA!r}")
    history = _history(attributes.pop("history", None), tell)
    packing = _packing(attributes, tell)
    if chunks and not (math.isnan(chunks.fill) or chunks.fill in packing.blanks):
        tell(
            f" holds {len(chunks.corners)} of its {chunks.total} chunks; write the others, even if "
            f"all in them is {chunks.fill:g} (Zarr: write_empty_chunks), or name that _FillValue "
            "if it means a missing point"
        )
    if any(fault.fatal for fault in faults):
        return None, faults
    shape = (int(dataset.shape[0]), int(dataset.shape[1]))
    name = str(attributes.pop("name", ""))
    facts = shape, pixel, stated, periodic, name, history, attributes, packing, chunks
    return Header(*facts), faults


def array_faults(dataset: Any) -> Iterator[Fault]:
    """Faults of the shape and the type of an array, which HDF5 or Zarr may hold."""
    where = f"dataset {dataset.name}"
    shape, kind = dataset.shape, dataset.dtype.kind
    if shape is None or len(shape) != 2 or min(shape) < 3:
        yield Fault(f"{where} has shape {shape}; a height map needs two axes of at least 3 points")
        return
    if kind not in "fiu":
        yield Fault(f"{where} holds {dataset.dtype}; heights must be real numbers")
        return
    if dataset.dtype.itemsize > 8:
        yield Fault(f"{where} holds {dataset.dtype}; store float32 or float64")
    elif kind != "f" or dataset.dtype.itemsize < 4:
        yield Fault(f"{where} holds {dataset.dtype}; schema 1 stores float32 or float64", False)


def _storage_faults(dataset: h5py.Dataset, where: str) -> Iterator[Fault]:
    """Faults that would make a read allocate or invent what the file does not hold."""
    if dataset.is_virtual or dataset.external:
        yield Fault(f"{where} keeps its heights in other files; copy it with h5repack first")
        return
    filters = dataset.id.get_create_plist()
    for index in range(filters.get_nfilters()):
        code = filters.get_filter(index)[0]
        if code not in _KNOWN_FILTERS or not h5py.h5z.filter_avail(code):
            yield Fault(
                f"{where} is compressed by filter {code}, which is not available here; "
                "repack it with h5repack -f GZIP=4"
            )
            return
    declared = math.prod(dataset.shape) * dataset.dtype.itemsize
    if dataset.chunks is None:
        stored = dataset.id.get_storage_size()
        if stored != declared:
            yield Fault(f"{where} declares {declared} bytes of heights and stores {stored}")
        return
    if math.prod(dataset.chunks) * dataset.dtype.itemsize > _MAX_CHUNK:
        yield Fault(f"{where} has chunks of {dataset.chunks} points; rechunk it to under 1 GiB")


def _chunks(dataset: h5py.Dataset) -> Chunks | None:
    """The chunks of a sound dataset if some are not stored."""
    if dataset.chunks is None:
        return None
    total = math.prod(-(-n // c) for n, c in zip(dataset.shape, dataset.chunks, strict=True))
    if dataset.id.get_num_chunks() == total:
        return None
    corners: list[tuple[int, int]] = []
    dataset.id.chunk_iter(lambda chunk: corners.append(chunk.chunk_offset))
    return Chunks(dataset.chunks, corners, total, float(dataset.fillvalue))


def _attributes(dataset: h5py.Dataset, where: str, faults: list[Fault]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name in dataset.attrs:
        try:
            stored = dataset.attrs.get_id(name)
            if stored.get_space().get_simple_extent_npoints() == 0:
                continue  # states nothing, as netCDF stores an empty text
            if stored.get_storage_size() > _MAX_ATTRIBUTE:
                raise ValueError("it is larger than 1 MiB")
            value = dataset.attrs[name]
        except DAMAGED as error:
            faults.append(Fault(f"{where}: attribute {name} cannot be read ({brief(error)})"))
            continue
        found[str(name)] = value
    return found


def one_spacing(stated: Any, given: ArrayLike | None) -> tuple[float, float]:
    """Pixel size (dy, dx) [m] that a file states, or the caller gives where it does not; refused if
    neither does, or they differ."""
    if stated is None and given is None:
        raise InputError("states no pixel size; pass --spacing DY DX (spacing=...) in m")
    pixel = checked_spacing(given if stated is None else stated)
    if given is not None and not np.allclose(pixel, checked_spacing(given), rtol=1e-9, atol=0.0):
        raise InputError(
            f"states spacing ({pixel[0]:.6g}, {pixel[1]:.6g}) m; leave out the other --spacing"
        )
    return pixel


def _packing(attributes: dict[str, Any], tell: Tell) -> Packing:
    """What the attributes of packing state, which are taken out."""
    found = {"scale_factor": 1.0, "add_offset": 0.0, "_FillValue": math.nan}
    found["missing_value"] = math.nan
    for name in found.keys() & attributes.keys():
        stated = attributes.pop(name)
        if isinstance(stated, int | float):
            found[name] = float(stated)
        else:
            tell(f": {name} is {shown(stated)}; it must be a number")
    scale, offset, *blanks = found.values()
    if not (math.isfinite(scale) and scale and math.isfinite(offset)):
        tell(f": scale_factor is {scale} and add_offset {offset}; they give no heights")
    return Packing(scale, offset, tuple(blank for blank in blanks if not math.isnan(blank)))


def _history(stated: Any, tell: Tell) -> tuple[Mapping[str, Any], ...]:
    if stated is None:
        return ()
    try:
        steps = json.loads(str(stated))
    except (ValueError, RecursionError):
        steps = None
    if not isinstance(steps, list) or not all(isinstance(step, dict) for step in steps):
        tell(": history is not a JSON list of steps; it is kept as text", False)
        return ({"step": "history", "text": str(stated)},)
    return tuple(steps)


def stated_value(value: Any) -> Any:
    """What a file states, in plain Python: bytes as text, the element of an array of one, None of
    an empty one."""
    if isinstance(value, np.ndarray) and value.size == 0:
        return None
    if isinstance(value, np.ndarray | np.generic) and value.size == 1:
        value = value.item()
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


def truth(stated: Any) -> bool:
    """Whether a file states that its map is periodic: by a truth value, 0 or 1, or a word."""
    number = isinstance(stated, int | float) and stated in (0, 1)
    value = bool(stated) if number else _TRUTH.get(str(stated).strip().lower())
    if value is None:
        raise InputError(f"periodic is {shown(stated)}; it must be true or false")
    return value


def plain(value: Any) -> Any:
    """A NumPy value as plain Python, for JSON."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, str | int | float):
        return value
    return value.item() if isinstance(value, np.generic) else str(value)
