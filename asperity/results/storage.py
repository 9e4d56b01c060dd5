"""Results files (HDF5, schema "asperity/1") and the plain tables beside them.

Layout: one group per curve under ``/curves``, with one dataset per quantity over the load points,
``extra/`` for further arrays, and attributes ``model``, ``version``, ``settings`` and ``seconds``
(JSON).  ``/tables`` holds compound datasets (microcontacts, error against run time), ``/maps``
two-dimensional fields, and the root attribute ``about`` a JSON mapping about the input.  A file is
written beside its final place and renamed, so that a reader never sees half of it.  HDF5 checks a
sum of every part as it is read: datasets have one by a filter, attributes by the version of their
headers.  Text has a fixed length; of any length it would lie in a heap without such a sum.
"""

from __future__ import annotations

import csv
import functools
import json
import math
import os
import platform
import shlex
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity import __version__
from asperity.errors import FileFormatError, InputError
from surfaces.errors import as_path
from surfaces.files.atomic import replacing

from .interpolation import POINT_FIELDS

if TYPE_CHECKING:
    import h5py

__all__ = [
    "SCHEMA",
    "ResultFile",
    "columns",
    "flat_columns",
    "json_text",
    "provenance",
    "read_about",
    "read_results",
    "structured",
    "write_csv",
    "write_results",
]


SCHEMA = "asperity/1"

MADE_BY = "make one with asperity solve, curve, bem or compare"

LIBRARIES = ("numpy", "scipy", "numba")

ATTRIBUTES = ("model", "version", "settings", "seconds")

DERIVED = "mean_contact_pressure"
"""Column that files hold for other programs; here it follows from load and area."""

Curve = TypeVar("Curve")
"""What holds a curve: `ContactCurve`, which this module does not know."""


def structured(columns: Mapping[str, Any]) -> NDArray[np.void]:
    """One structured array from columns of equal length.

    A column of several numbers per row becomes several columns, ``name_0``, ``name_1``, ..., so
    that ``pandas.DataFrame(table)`` holds every field, of a table in a results file as well.
    """
    arrays = {name: np.asarray(column) for name, column in flat_columns(columns)}
    rows = len(next(iter(arrays.values())))
    table = np.empty(rows, [(name, a.dtype) for name, a in arrays.items()])
    for name, array in arrays.items():
        table[name] = array
    return table


def columns(table: NDArray[np.void]) -> dict[str, NDArray[Any]]:
    """The named columns of a structured array."""
    return {name: table[name] for name in table.dtype.names or ()}


@dataclass
class ResultFile(Generic[Curve]):
    """What a results file holds.

    Attributes
    ----------
    curves
        Contact curves by name: "asperity", "bem", "anchored" ...
    tables
        Structured arrays by name, such as "microcontacts"; ``pandas.DataFrame`` takes them.
    maps
        Arrays (ny, nx) by name.
    about
        JSON-able facts: input map, material, preparation; how the file was made (`provenance`) is
        added where it lacks.
    """

    curves: dict[str, Curve] = field(default_factory=dict)
    tables: dict[str, NDArray[Any]] = field(default_factory=dict)
    maps: dict[str, NDArray[Any]] = field(default_factory=dict)
    about: dict[str, Any] = field(default_factory=dict)


def provenance() -> dict[str, str]:
    """Date (UTC), command line or name of the script, and versions, as text."""
    return {
        "date": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "command": _command(),
        "versions": _versions(),
    }


@functools.cache
def _versions() -> str:
    """Versions of the package and what it computes with; looking them up takes 5 ms."""
    from importlib.metadata import version

    versions = {name: version(name) for name in LIBRARIES}
    versions = {"asperity": __version__, "Python": platform.python_version()} | versions
    return ", ".join(f"{name} {version}" for name, version in versions.items())


def _command() -> str:
    """The command as it was typed; of another program its name alone."""
    program = Path(sys.argv[0] if sys.argv else "")
    ours = program.name == "asperity" or program.parts[-2:] == ("asperity", "__main__.py")
    return shlex.join(["asperity", *sys.argv[1:]]) if ours else program.name or "python"


def write_results(path: str | os.PathLike[str], results: ResultFile[Any]) -> None:
    """Write a results file through a temporary file and an atomic rename; refused if the folder
    does not exist, has no room or cannot be written.

    The HDF5 library fills it in memory: where a disk is full it fails as it closes a file, and may
    take the program with it.
    """
    import h5py

    in_memory: dict[str, Any] = {"driver": "core", "backing_store": False}
    with (
        replacing(path) as partial,
        h5py.File(partial, "w", libver=("v110", "v110"), **in_memory) as file,
    ):
        about = {"made": provenance()} | results.about
        _write_text(file, {"schema": SCHEMA, "version": __version__, "about": json_text(about)})
        curves, tables, maps = (_ordered(file, part) for part in ("curves", "tables", "maps"))
        for name, curve in results.curves.items():
            _write_curve(curves.create_group(_storable_name(name)), curve)
        for name, table in results.tables.items():
            _write_array(tables, name, table)
        for name, array in results.maps.items():
            packed = {"compression": "gzip", "compression_opts": 3, "shuffle": True}
            _write_array(maps, name, array, **packed)
        file.flush()
        partial.write_bytes(file.id.get_file_image())


def read_results(path: str | os.PathLike[str], kind: Callable[..., Curve]) -> ResultFile[Curve]:
    """Read a results file, see `asperity.read_results`; `kind` makes a curve of its columns."""
    with _results(path) as (file, about):
        return ResultFile(
            curves={
                name: _read_curve(group, f"{path}: curve {name!r}", kind)
                for name, group in _members(file, "curves")
            },
            tables={k: _plain(d[()]) for k, d in _members(file, "tables")},
            maps={k: d[()] for k, d in _members(file, "maps")},
            about=about,
        )


def read_about(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The facts about the input of a results file alone, see `ResultFile`; errors as there."""
    with _results(path) as (_, about):
        return about


@contextmanager
def _results(path: str | os.PathLike[str]) -> Iterator[tuple[h5py.File, dict[str, Any]]]:
    """A results file, opened, and the facts about its input."""
    import h5py

    if not as_path(path).is_file():
        raise FileFormatError(f"{path}: no such results file; {MADE_BY}")
    try:
        with h5py.File(path, "r") as file:
            text = _read_text(file)
            schema = text.get("schema")
            if schema != SCHEMA:
                held = "a height map" if "heights" in file else f"of schema {schema!r}"
                raise FileFormatError(
                    f"{path} is {held}, no results file of schema {SCHEMA!r}; {MADE_BY}"
                )
            yield file, dict(json.loads(text.get("about", "{}")))
    except (OSError, KeyError, TypeError, ValueError, RuntimeError) as error:
        if isinstance(error, FileFormatError):
            raise
        raise FileFormatError(f"{path} is not a readable results file: {error}") from error


def write_csv(path: str | os.PathLike[str], columns: Mapping[str, Any]) -> None:
    """Write columns of equal length to a comma-separated file with a header line.

    A column of several numbers per row becomes several columns, as in `structured`. NaN is left
    empty.
    """
    columns = dict(flat_columns(columns))
    cells = ([_cell(value) for value in np.asarray(c).tolist()] for c in columns.values())
    with replacing(path) as partial, open(partial, "w", newline="", encoding="utf-8") as handle:
        writer = csv.writer(handle)
        writer.writerow(columns)
        writer.writerows(zip(*cells, strict=True))


def _cell(value: Any) -> Any:
    return "" if isinstance(value, float) and math.isnan(value) else value


def flat_columns(columns: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Columns by name, those of several numbers per row parted into one for each."""
    for name, column in columns.items():
        if np.ndim(column) == 2:
            yield from ((f"{name}_{i}", part) for i, part in enumerate(np.transpose(column)))
        else:
            yield name, column


def _write_curve(group: h5py.Group, curve: Any) -> None:
    facts = {name: getattr(curve, name) for name in ATTRIBUTES}
    _write_text(group, {k: v if isinstance(v, str) else json_text(v) for k, v in facts.items()})
    for name in (*POINT_FIELDS, DERIVED):
        _write_array(group, name, getattr(curve, name))
    _write_array(group, "reasons", np.array(curve.reasons, np.str_))
    extra = _ordered(group, "extra")
    for name, array in curve.extra.items():
        _write_array(extra, name, array)


def _ordered(group: h5py.Group, name: str) -> h5py.Group:
    """A new group within a group, whose parts are read back in the order in which they came."""
    return group.create_group(name, track_order=True)


def _write_text(group: h5py.Group, attributes: Mapping[str, str]) -> None:
    for name, text in attributes.items():
        group.attrs[name] = np.bytes_(text.encode())


def _write_array(group: h5py.Group, name: str, array: ArrayLike, **packed: Any) -> None:
    name = _storable_name(name)
    group.create_dataset(name, data=_storable(np.asarray(array)), fletcher32=True, **packed)


def _storable_name(name: str) -> str:
    """The name of a part of a file; others would be read as a path."""
    if name in ("", ".") or "/" in name or "\0" in name:
        raise InputError(f"{name!r} is no name in a results file; give one without /")
    return name


def _read_text(group: h5py.Group) -> dict[str, str]:
    """Attributes by name; files of earlier versions hold text of any length."""
    held = group.attrs.items()
    return {k: v.decode() if isinstance(v, bytes) else str(v) for k, v in held}


def _members(group: h5py.Group, name: str = ".") -> Iterator[tuple[str, Any]]:
    """What a group within a group holds, if there is one; `items` gives None for damaged parts."""
    inner = group[name] if name in group else {}
    return ((part, inner[part]) for part in inner)


def _read_curve(group: h5py.Group, source: str, kind: Callable[..., Curve]) -> Curve:
    """A curve; raises FileFormatError if a part of it is missing or of the wrong kind."""
    text = _read_text(group)
    held = {
        name: _plain(part[()]) for name, part in _members(group) if name not in ("extra", "reasons")
    }
    extra = {name: _plain(part[()]) for name, part in _members(group, "extra")}
    reasons = tuple(group["reasons"].asstr("utf-8")[()].tolist())
    facts = {k: json.loads(v) if k in ("settings", "seconds") else v for k, v in text.items()}
    missing = [name for name in POINT_FIELDS if name not in held]
    missing += [name for name in ATTRIBUTES if name not in facts]
    if missing:
        raise FileFormatError(f"{source} lacks {', '.join(missing)}; make it again")
    for name, column in held.items():
        if column.dtype.kind not in "biuf":
            raise FileFormatError(f"{source}: column {name} holds no numbers")
    told = {name: facts[name] for name in ATTRIBUTES}
    try:
        columns = {name: held[name] for name in POINT_FIELDS}
        return kind(**columns, **told, extra=extra, reasons=reasons)
    except InputError as error:
        raise FileFormatError(f"{source}: {error}") from error


def _storable(array: NDArray[Any]) -> NDArray[Any]:
    """Text as fixed-width bytes, which HDF5 can hold inside compound types."""
    return _recoded(np.asarray(array), "U", np.char.encode)


def _plain(array: NDArray[Any]) -> NDArray[Any]:
    """Inverse of `_storable`: fixed-width bytes back to text."""
    return _recoded(array, "S", np.char.decode)


def _recoded(
    array: NDArray[Any], kind: str, convert: Callable[[NDArray[Any], str], NDArray[Any]]
) -> NDArray[Any]:
    if array.dtype.names is None:
        return convert(array, "utf-8") if array.dtype.kind == kind else array
    return structured({k: _recoded(v, kind, convert) for k, v in columns(array).items()})


def json_text(value: Mapping[str, Any]) -> str:
    """JSON of a mapping that may hold arrays; what JSON has no form for is told by its name.

    Examples
    --------
    >>> import numpy as np
    >>> from asperity.results.storage import json_text
    >>> json_text({"load": np.array([1.0, np.nan]), "converged": np.True_})
    '{"load": [1.0, NaN], "converged": true}'
    """

    def plain(item: Any) -> Any:
        if isinstance(item, Mapping):
            return dict(item)
        return item.tolist() if isinstance(item, np.generic | np.ndarray) else str(item)

    return json.dumps(value, default=plain)
