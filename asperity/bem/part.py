"""A part of a solved map as a scene of its own, under what the rest of the map does to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asperity.halfspace.material import HalfSpace
from surfaces.arrays import Array
from surfaces.heightmap import HeightMap

from .operator import HalfSpaceOperator
from .problem import ContactProblem
from .solution import read_contact

__all__ = ["SolvedPart", "solved_part"]


POINTS = 160
"""Points along the sides of the part: enough contacts to tell what the pixels leave open, at a
small part of the time of a load (docs/development/verification.md)."""


@dataclass(frozen=True, eq=False)
class SolvedPart:
    """State of a solved load on a part of the map.

    Attributes
    ----------
    hm
        Heights of the part about the mean of the map.
    pressure, displacement
        Contact pressure [Pa], and displacement by the pressure on the whole map [m], shape
        (ny, nx).
    material
        Half-space that is pressed.
    """

    hm: HeightMap
    pressure: Array
    displacement: Array
    material: HalfSpace

    @property
    def contact_area(self) -> float:
        """Corrected contact area [m^2]."""
        hardness = self.material.hardness
        (_, nx), spacing = self.hm.shape, self.hm.spacing
        _, area, _ = read_contact(self.pressure, spacing, nx, hardness, periodic=True)
        return area

    def alone(self) -> HeightMap:
        """The part as a periodic cell: under its own load it bears the pressures, and is separated,
        as on the whole map, whose other pressures lower its heights by what they displace."""
        exact = HalfSpaceOperator(self.hm.shape, self.hm.spacing, self.material)
        ny, nx = self.hm.shape
        exact.pressure[:, :nx] = exact.compliance * self.pressure
        own = exact.apply()[:ny, :nx]
        return self.hm.replace(heights=self.hm.heights - (self.displacement - own))


def solved_part(problem: ContactProblem) -> SolvedPart:
    """State of the load solved last on the part about the highest point of the map."""
    hm, exact = problem.hm, problem.finest.exact
    lines = []
    for at, n in zip(hm.roughness.summit, hm.shape, strict=True):
        count = min(POINTS, n)
        first = at - count // 2
        if problem.boundary != "periodic":
            first = min(max(first, 0), n - count)
        lines.append((first + np.arange(count)) % n)
    rows, columns = lines

    def within(field: Array) -> Array:
        """The part of a field: whole rows first, in a third of the time of single points."""
        return field.take(rows, axis=0).take(columns, axis=1)

    return SolvedPart(
        HeightMap(within(hm.heights) - hm.roughness.mean, hm.spacing),
        within(problem.finest.pressure) / problem.compliance,
        within(exact.displacement) * problem.unit,
        problem.material,
    )
