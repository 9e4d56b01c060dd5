"""Summits with their contact laws and places, and the half-space that couples them."""

from __future__ import annotations

import copy
from bisect import bisect_left
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike

from asperity.errors import InputError
from asperity.halfspace.footprint import Footprints
from asperity.halfspace.material import require_half_space
from asperity.halfspace.scene import known_boundary
from asperity.interaction.newton.laws import Laws
from asperity.parameters import DEFAULTS, Parameters
from surfaces.arrays import Array, Index
from surfaces.errors import as_numbers, as_sizes
from surfaces.numerics.memory import on_disk

from .elongation import Elongation

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.microcontact.law_table import LawTable, LazyTable

__all__ = ["ContactSystem"]


class ContactSystem:
    """Input of a coupled solve: summits, contact laws and half-space.

    Parameters
    ----------
    x, y
        Places of the summits [m], shape (n,).
    height
        Heights [m] above the mean plane of the map, shape (n,).
    table
        Contact laws of the summits; a lazy table makes those that are needed.
    cell
        Nominal area (Ly, Lx) [m].
    boundary
        "periodic" or "free".
    material
        Elastic half-space.
    interaction
        False: the classical sum of independent contacts.
    curvature, angle
        Principal curvatures [1/m], (n, 2), the larger first, and directions of the long axis [rad],
        (n,), of the summits; round footprints if not given.
    parameters
        Constants of the model, and its switches. With `contact_shift` coupled contacts stand at the
        centres that their laws give, and move under the slope of their neighbors' field; with
        `elongation` footprints are elongated.

    Attributes
    ----------
    by_height
        Summits with a usable law from the highest down, shape (m,).

    Raises
    ------
    InputError
        If lengths disagree or a value is not usable.
    """

    def __init__(
        self,
        *,
        x: ArrayLike,
        y: ArrayLike,
        height: ArrayLike,
        table: LawTable | LazyTable,
        cell: tuple[float, float],
        boundary: str,
        material: HalfSpace,
        interaction: bool = True,
        curvature: ArrayLike | None = None,
        angle: ArrayLike | None = None,
        parameters: Parameters = DEFAULTS,
    ) -> None:
        self.x, self.y, self.height = (
            _column(value, name) for value, name in ((x, "x"), (y, "y"), (height, "height"))
        )
        if not len(self.x) == len(self.y) == len(self.height) == len(table):
            raise InputError(
                f"x, y, height and table have {len(self.x)}, {len(self.y)}, {len(self.height)} "
                f"and {len(table)} rows; they must agree"
            )
        if len(self.x) == 0:
            raise InputError("the population has no summit; lower the height to segment above")
        sides = as_sizes("cell", cell)
        if not (sides.shape == (2,) and sides.min() > 0):
            raise InputError(f"cell must be two positive lengths, got {cell!r}")
        require_half_space(material)
        self.boundary, self.material = known_boundary(boundary), material
        self.cell = (float(sides[0]), float(sides[1]))
        self.interaction = interaction and self._can_interact
        self.parameters = parameters
        self.contact_shift = parameters.corrections.contact_shift
        self.footprints = Footprints(material.modulus, material.m)
        self.laws = Laws(table, self.footprints)
        self.table = self.laws.table
        self.elongation: Elongation | None = None
        long = parameters.corrections.elongation
        if long and curvature is not None and angle is not None:
            forms = as_numbers("curvature", curvature), as_numbers("angle", angle)
            if not (forms[0].shape == (len(self), 2) and forms[1].shape == (len(self),)):
                raise InputError(
                    f"curvature and angle have the shapes {forms[0].shape} and {forms[1].shape}; "
                    f"give two curvatures and one angle for each of {len(self)} summits"
                )
            elongation = Elongation.of(*forms, self.footprints, parameters.elongation)
            self.elongation = on_disk(elongation) if self.table.stored else elongation
        usable = np.flatnonzero(self.laws.usable)
        if len(usable) == 0:
            raise InputError("no summit of the population has a usable contact law")
        self.by_height: Index = usable[np.argsort(-self.height[usable], kind="stable")]

    def __len__(self) -> int:
        return len(self.height)

    @property
    def _can_interact(self) -> bool:
        """Whether there is a second contact to interact with: another summit, or an image."""
        return self.boundary == "periodic" or len(self) > 1

    def coupled(self) -> Self:
        """A system of these summits and laws with interaction."""
        other = copy.copy(self)
        other.interaction = self._can_interact
        return other

    @property
    def has_centres(self) -> bool:
        """Whether contacts stand at the centres that their laws give."""
        return self.contact_shift and self.table.has_centres

    @property
    def nominal_area(self) -> float:
        """Area of the cell [m^2]."""
        return self.cell[0] * self.cell[1]

    @property
    def highest(self) -> float:
        """Height [m] of the highest summit, where the flat first touches."""
        return float(self.height[self.by_height[0]])

    def above(self, level: float, rows: Index | None = None) -> Index:
        """Summits above a height [m], of `rows`, which are in the order of `by_height`, or of all
        if None."""
        rows = self.by_height if rows is None else rows
        return rows[: bisect_left(rows, -level, key=lambda row: -self.height[row])]


def _column(value: ArrayLike, name: str) -> Array:
    array = np.ascontiguousarray(as_numbers(name, value, copy=False))
    if array.ndim != 1:
        raise InputError(f"{name} must be one-dimensional, got shape {array.shape}")
    return array
