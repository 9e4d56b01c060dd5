"""Jobs of a sweep: surfaces times materials times settings, each known by a digest."""

from __future__ import annotations

import argparse
import functools
import glob
import hashlib
import inspect
import json
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import asperity
import surfaces
from asperity.compilation import CURVE
from asperity.errors import InputError
from asperity.halfspace.material import HalfSpace, require_half_space
from surfaces.errors import as_choice
from surfaces.files.atomic import make_folder
from surfaces.files.zarr_array import is_zarr
from surfaces.heightmap import HeightMap

__all__ = ["METHODS", "Job", "Jobs", "Surface", "method"]

METHODS = {
    "curve": ("contact_curve", CURVE),
    "bem": ("bem_curve", ("bem",)),
    "solve": ("solve", (*CURVE, "bem")),
}
"""What solves a job, the default first: the public function, and the parts that are compiled for it
(`asperity.compilation`)."""

OWN = {"hm", "material", "plan", "progress", "checkpoint", "paths", "judge"}
"""Arguments of the methods that a sweep sets, or that cannot be told from others."""

LIMITS = ("memory",)
"""Options of the command line that change no result: those of finished jobs may be others."""

BODY = ("E", "nu", "m", "hardness", "modulus")
"""Columns of a table that make a material."""


class Surface(NamedTuple):
    """A surface that a worker makes or reads: what the index calls it, and what makes it, a
    function of a module or a `functools.partial` of one."""

    name: str
    load: Callable[[], HeightMap]


@dataclass(frozen=True)
class Job:
    """One surface, material and set of settings.

    The settings are ``method``, a key of `METHODS`, and keyword arguments of that function;
    ``loads`` [N] in place of its pressures, ``prepare`` for those of `surfaces.prepare`. The digest
    tells whether two jobs are the same: of the content of all files, the material, the settings and
    the version of the package.
    """

    surface: Surface
    material: HalfSpace
    settings: Mapping[str, Any]
    digest: str

    @property
    def file(self) -> str:
        """Name of its results file."""
        stem = re.sub(r"[^\w.-]+", "_", Path(self.surface.name).stem)[:60]
        return f"{stem}-{self.digest}.h5"

    @property
    def row(self) -> dict[str, str | float]:
        """What the index tells of it before it is run."""
        body = {name: value for name, value in asdict(self.material).items() if value is not None}
        told = {k: v for k, v in self.settings.items() if isinstance(v, str | int | float)}
        flags = {k: str(v) for k, v in told.items() if isinstance(v, bool)}
        return {"surface": self.surface.name} | body | told | flags | {"digest": self.digest}


@dataclass
class Jobs:
    """Makes jobs; each file is read for its digest once, and maps that are in memory are written to
    the folder, for the workers to read."""

    folder: Path
    _digests: dict[str, str] = field(default_factory=dict)

    def job(self, surface: Surface, material: HalfSpace, settings: Mapping[str, Any]) -> Job:
        """One job; refused if the material or a setting is none."""
        require_half_space(material)
        chosen = _chosen(settings)
        told = [self._plain(surface.load), asdict(material), self._plain(chosen, files=False)]
        text = json.dumps([*told, asperity.__version__], sort_keys=True)
        return Job(surface, material, chosen, hashlib.sha256(text.encode()).hexdigest()[:16])

    def product(self, given: Any, materials: Any, settings: Any) -> list[Job]:
        """Jobs of all surfaces with all materials and all settings, see `asperity.sweep`."""
        if materials is None:
            return list(self._of_table(given, settings))
        bodies = [_body(one) for one in _several(materials, HalfSpace, Mapping)]
        # all are checked before a map is written
        choices = [_chosen(one) for one in _several({} if settings is None else settings, Mapping)]
        return [
            self.job(surface, body, choice)
            for surface in self.surfaces(given)
            for body in bodies
            for choice in choices
        ]

    def surfaces(self, given: Any) -> Iterator[Surface]:
        """Surfaces of paths, globs, maps and functions; what is none of these is refused."""
        for one in _several(given, str, os.PathLike, HeightMap, Surface):
            if isinstance(one, Surface):
                yield one
            elif isinstance(one, HeightMap):
                yield Surface(one.name or one.digest[:8], self._written(one))
            elif callable(one):
                yield Surface(_label(one), one)
            elif isinstance(one, str | os.PathLike):
                word = os.fspath(one)
                known = [word] if os.path.exists(word) else sorted(glob.glob(word, recursive=True))
                for path in known or [word]:
                    yield Surface(path, functools.partial(surfaces.read, os.path.abspath(path)))
            else:
                raise InputError(
                    f"a surface is a path, a glob, a HeightMap or a function that makes one, not "
                    f"{type(one).__name__}"
                )

    def _of_table(self, table: Any, settings: Mapping[str, Any] | None) -> Iterator[Job]:
        """A job for each row of a table: its columns are surface, those of the body, and settings.

        Empty cells (None, NaN) are left out.
        """
        rows = table.to_dict("records") if hasattr(table, "to_dict") else table
        table_of_rows = isinstance(rows, Sequence) and all(isinstance(row, Mapping) for row in rows)
        if not (table_of_rows and rows):
            raise InputError("a sweep needs materials, or a table with a row for each job")
        for number, row in enumerate(rows):
            absent = {k for k, v in row.items() if v is None or (isinstance(v, float) and v != v)}
            cells = {k: v for k, v in row.items() if k not in absent}
            if "surface" not in cells:
                raise InputError(f"row {number} of the table has no surface")
            body = _body({name: cells.pop(name) for name in BODY if name in cells})
            for surface in self.surfaces(cells.pop("surface")):
                yield self.job(surface, body, {**(settings or {}), **cells})

    def _written(self, hm: HeightMap) -> Callable[[], HeightMap]:
        """A map in memory, written for the workers."""
        path = self.folder / "maps" / f"{hm.digest}.h5"
        if not path.exists():
            make_folder(path.parent)
            surfaces.write(hm, path)
        return functools.partial(surfaces.read, os.path.abspath(path))

    def _plain(self, value: Any, files: bool = True) -> Any:
        """A value as JSON holds it, a file as the digest of its content."""
        if isinstance(value, functools.partial):
            inner = self._plain([value.func, value.args, value.keywords], files)
            return {"call": inner}
        if isinstance(value, argparse.Namespace):
            return self._plain(vars(value) | dict.fromkeys(LIMITS), files)
        if isinstance(value, str | os.PathLike):
            return self._content(os.fspath(value)) if files else os.fspath(value)
        if isinstance(value, Mapping):
            return {str(name): self._plain(one, files) for name, one in value.items()}
        if isinstance(value, np.ndarray | np.generic):
            return value.tolist()
        if isinstance(value, list | tuple):
            return [self._plain(one, files) for one in value]
        if value is None or isinstance(value, bool | int | float):
            return value
        if inspect.ismethod(value):  # what it makes is told by its object as well
            return [self._plain(value.__self__, files), value.__func__.__qualname__]
        name = getattr(value, "__qualname__", "<")
        if not callable(value) or "<" in name:
            raise InputError(
                f"{value!r} cannot be told from another by a later run; give a function of a "
                "module, or functools.partial of one with numbers and texts"
            )
        return f"{value.__module__}.{name}"

    def _content(self, text: str) -> str:
        """Digest of a file that can be read, or of a Zarr's files, else the text itself."""
        if text not in self._digests:
            try:
                self._digests[text] = _digest(text)
            except (OSError, ValueError):  # the latter of a zero byte
                self._digests[text] = text
        return self._digests[text]


def _digest(path: str) -> str:
    """Digest of the content of a file, or of the names and the contents of the files of a Zarr."""
    if not is_zarr(Path(path)):
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    files = (one for one in sorted(Path(path).rglob("*")) if one.is_file())
    held = [f"{one.relative_to(path)} {_digest(str(one))}" for one in files]
    return hashlib.sha256(os.fsencode("\n".join(held))).hexdigest()


def method(name: str) -> Callable[..., Any]:
    """The function that solves a job."""
    found: Callable[..., Any] = getattr(asperity, METHODS[name][0])
    return found


def _chosen(given: Any) -> dict[str, Any]:
    """Settings with their method; refused if it is unknown or does not take them."""
    if not isinstance(given, Mapping):
        raise InputError(f"settings are keywords of a method, not {type(given).__name__}")
    settings = {"method": next(iter(METHODS)), **given}
    as_choice("method", settings["method"], METHODS)
    if not isinstance(settings.get("prepare", {}), Mapping):
        raise InputError("prepare holds the keywords of surfaces.prepare")
    loads = {"loads", "pressures", "separations"} & settings.keys()
    if len(loads) > 1:
        raise InputError(f"give one of {', '.join(sorted(loads))}")
    takes = inspect.signature(method(settings["method"])).parameters.keys() - OWN
    known = takes | {"method", "loads", "prepare"}
    for name in settings:
        if name not in known:
            raise InputError(
                f"{name} is no setting of the method {settings['method']}; it takes "
                f"{', '.join(sorted(known))}"
            )
    return settings


def _body(given: Any) -> HalfSpace:
    """A material of itself or of its keywords."""
    if isinstance(given, HalfSpace):
        return given
    if not isinstance(given, Mapping):
        raise InputError(f"a material is a HalfSpace or its keywords, not {type(given).__name__}")
    given = dict(given)
    try:
        if "modulus" in given:
            return HalfSpace.from_modulus(**given)
        return HalfSpace(given.pop("E", None), given.pop("nu", None), **given)
    except TypeError:
        names = ", ".join(map(str, given))
        raise InputError(
            f"a material is E and nu, or modulus, with m and hardness, not {names}"
        ) from None


def _several(given: Any, *kinds: Any) -> list[Any]:
    """The things given, also where there is one alone."""
    alone = isinstance(given, kinds) or callable(given) or not isinstance(given, Iterable)
    things = [given] if alone else list(given)
    if not things:
        raise InputError("a sweep needs at least one surface, one material and one set of settings")
    return things


def _label(load: Callable[[], HeightMap]) -> str:
    """Name of a surface that a function makes: the file it is of, and what is special."""
    if not isinstance(load, functools.partial):
        return getattr(load, "__name__", "surface")
    files = [str(one) for one in load.args if isinstance(one, str | os.PathLike)]
    shown = {k: v for k, v in load.keywords.items() if k in ("seed", "rows", "columns")}
    name = Path(files[0]).name if files else load.func.__name__
    return " ".join([name, *(f"{k} {v}" for k, v in shown.items())])
