"""Boundary condition of a map: periodic, or a free half-space."""

from __future__ import annotations

from typing import Literal, TypeGuard

from asperity.errors import InputError
from surfaces.heightmap import HeightMap

__all__ = ["Boundary", "chosen_boundary", "known_boundary"]

Boundary = Literal["periodic", "free"]


def chosen_boundary(hm: HeightMap, asked: str | None) -> Boundary:
    """The boundary asked for, or the one that the map states."""
    return known_boundary(("periodic" if hm.periodic else "free") if asked is None else asked)


def known_boundary(name: str) -> Boundary:
    """The name of a boundary.

    Raises
    ------
    InputError
        If there is none of this name.
    """
    if _is_boundary(name):
        return name
    raise InputError(f'boundary is {name!r}; choose "periodic" or "free"')


def _is_boundary(name: str) -> TypeGuard[Boundary]:
    return name in ("periodic", "free")
