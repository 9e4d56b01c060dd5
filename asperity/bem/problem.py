"""One contact problem without its load: checks, operators, and the start from coarser grids."""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.fft

from asperity.errors import InputError
from asperity.halfspace.influence import influence, symbol_quadrant
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import chosen_boundary
from surfaces.arrays import Array
from surfaces.errors import as_number
from surfaces.heightmap import HeightMap, require_full
from surfaces.numerics.parallel import threads as thread_count

from .certificate import Prescribed
from .correction import GridSolution, NestedGrid, PressureOrigin
from .grids import coarse_maps, nested_shapes, prolong
from .memory import require_memory
from .operator import HalfSpaceOperator
from .solution import read_contact
from .stiffness import contact_stiffness

__all__ = ["ContactProblem"]

_COARSE_TOLERANCE = 1e-2
"""Bound on the certificate on the coarser grids."""

_FIRST_LOAD = 1e-3
"""First mean of p~ tried for a prescribed separation, over the rms height; for a flat map this
is at least the same part of how far it is pressed in."""

_PLAIN_HEIGHTS = 1e-9, 1e9
"""Rms heights [m] that the solver takes as they are: loops in single precision hold their squares,
and those of pressures far below them."""

_FLAT_UNIT = 1e-6
"""Unit inside of a flat map, over its pixels: it has no height of its own."""


class ContactProblem:
    """A rough contact before its load: checked, planned, with the finest grid ready.

    Arguments are those of `bem_solve`, and the share of the area that is expected in contact, on
    which the memory depends.

    Attributes
    ----------
    unit
        Unit of heights and displacements inside [m]: 1, or a power of two near the rms height.
    finest
        The finest grid, in that unit; its pressure is the state.
    compliance
        Unit of pressure inside [1/Pa]: p~ = compliance p, a displacement in units.
    own
        Displacement of a point by its own p~ of 1.
    """

    def __init__(
        self,
        hm: HeightMap,
        material: HalfSpace,
        *,
        tolerance: float = 1e-6,
        boundary: str | None = None,
        share: float | None = None,
    ) -> None:
        require_full(hm, "a solve by boundary elements")
        if not 1e-12 <= as_number("tolerance", tolerance) <= 0.1:
            raise InputError(f"tolerance is {tolerance!r}; give a number from 1e-12 to 0.1")
        self.boundary = chosen_boundary(hm, boundary)
        require_memory(hm.shape, self.boundary, share)
        self.hm, self.material, self.tolerance = hm, material, float(tolerance)
        exact = HalfSpaceOperator(hm.shape, hm.spacing, material, self.boundary)
        self.unit = _unit(hm.roughness.rms_height or _FLAT_UNIT * max(hm.spacing))
        self.compliance = exact.compliance / self.unit
        self.own = float(influence((1, 1), hm.spacing, exact.m)[0, 0])
        heights = hm.heights if self.unit == 1.0 else hm.heights / self.unit
        self.finest = NestedGrid(heights, exact, material.hardness * self.compliance)

    @functools.cached_property
    def full_contact(self) -> float:
        """Mean of p~ at which a periodic cell begins to touch everywhere, with no point at the
        hardness; infinite if there is none, and on a free half-space."""
        if self.boundary != "periodic":
            return math.inf
        ny, nx = self.hm.shape
        stiffness = symbol_quadrant((ny, nx), self.hm.spacing, 1.0 - self.finest.exact.m, 1.0)
        rows = np.minimum(np.arange(ny), ny - np.arange(ny))  # the symbol is even
        waves = scipy.fft.rfft2(self.finest.heights, workers=thread_count())
        waves *= stiffness[rows]
        flat = scipy.fft.irfft2(waves, (ny, nx), workers=thread_count())
        least, most = float(flat.min()), float(flat.max())
        return -least if most - least <= self.finest.cap else math.inf

    def prescribed(self, kind: str, value: float) -> Prescribed:
        """What is asked for, in units inside: a mean pressure [Pa] or a separation [m]."""
        if kind == "pressure":
            return Prescribed(mean=value * self.compliance)
        least = 0.0 if math.isinf(self.finest.cap) else -math.inf
        if self.boundary == "periodic" and (value <= least or value == 0.0):
            raise InputError(
                f"separation is {value:.4g} m; in a periodic cell it is the mean gap, which is "
                "positive below full contact and zero under all elastic loads from there on; "
                "prescribe a pressure instead"
            )
        return Prescribed(level=-value / self.unit - self.finest.mean_height)

    def touches(self, goal: Prescribed) -> bool:
        """Whether there is any contact at the prescribed load or level."""
        return goal.mean > 0.0 if goal.level is None else -goal.level < self.finest.highest

    def start(self, goal: Prescribed, given: Array | None = None) -> GridSolution | None:
        """First pressure of the finest grid, from a given pressure or from the coarser grids.

        Returns how it went on the last of these, with the iterations spent on all of them.
        """
        pressure = self.finest.pressure
        if not self.touches(goal):
            pressure[:] = 0.0
            return None
        if given is None:
            return self._nested(goal)
        most = self.material.hardness
        if goal.level is not None:  # a point's own displacement is at most the whole approach
            approach = goal.level + self.finest.highest
            most = min(most, approach / (self.own * self.compliance))
        np.clip(given, 0.0, most, out=pressure)
        if goal.level is not None:
            pressure *= self.compliance
        else:  # sums of what is given may overflow
            pressure /= pressure.max()
            pressure *= goal.mean / float(pressure.mean())
        return None

    def _nested(self, goal: Prescribed) -> GridSolution | None:
        """Start from the coarser grids."""
        mean = goal.mean
        if goal.level is not None:
            length = max(self.finest.rms_height, _FIRST_LOAD * (goal.level + self.finest.highest))
            mean = min(_FIRST_LOAD * length, 0.1 * self.finest.cap)
        shapes = nested_shapes(self.hm.shape)[:-1]
        fine, whole = self.finest.exact, self.finest.heights
        top = self.hm.roughness.summit if self.boundary == "periodic" else (0, 0)
        solution: GridSolution | None = None
        coarse: NestedGrid | None = None
        ly, lx = self.hm.size
        for heights in coarse_maps(whole, self.boundary, shapes, top):
            ny, nx = heights.shape
            spacing = (ly / ny, lx / nx)
            exact = HalfSpaceOperator((ny, nx), spacing, self.material, self.boundary)
            ratio = exact.compliance / fine.compliance
            grid = NestedGrid(heights, exact, ratio * self.finest.cap)
            if goal.level is not None and -goal.level >= grid.highest:
                continue
            self._start(grid, coarse, ratio * mean, goal)
            tolerance = max(_COARSE_TOLERANCE, self.tolerance)
            spent = solution.iterations if solution else 0
            solution = grid.solve(replace(goal, mean=ratio * goal.mean), tolerance)
            solution.iterations += spent
            if goal.level is not None:
                mean = solution.reading.total / heights.size / ratio
            coarse = grid
        self._start(self.finest, coarse, mean, goal, top)
        return solution

    def _start(
        self,
        grid: NestedGrid,
        coarse: NestedGrid | None,
        mean: float,
        goal: Prescribed,
        origin: tuple[int, int] = (0, 0),
    ) -> None:
        """First pressure of a grid, of this mean: from the coarser grid if there is one, which
        begins at the point `origin` of it."""
        if coarse is not None:
            prolong(coarse, grid, mean, origin)
        elif goal.level is not None and math.isinf(grid.cap):
            highest = np.unravel_index(grid.heights.argmax(), grid.heights.shape)
            grid.pressure[highest] = mean * grid.heights.size
        else:
            grid.pressure[:] = mean

    def solve(self, goal: Prescribed, tolerance: float, origin: PressureOrigin) -> GridSolution:
        """Solve on the finest grid, see `NestedGrid.solve`, with the area and the stiffness of the
        contact found."""
        finest, seam = self.finest, self.boundary == "periodic"
        solution = finest.solve(goal, tolerance, origin)
        solution.contact = read_contact(
            finest.exact.pressure, self.hm.spacing, self.hm.shape[1], finest.cap, periodic=seam
        )
        if solution.converged:
            solution.stiffness = contact_stiffness(finest, solution.reading)
        return solution

    def settings(self) -> dict[str, Any]:
        """Everything needed to repeat a run."""
        return {
            "model": "bem",
            "boundary": self.boundary,
            "tolerance": self.tolerance,
            **self.material.facts,
            "shape": list(self.hm.shape),
            "spacing": list(self.hm.spacing),
            "threads": thread_count(),
        }


def _unit(rms_height: float) -> float:
    """Unit of heights [m] in which none is very small or large."""
    low, high = _PLAIN_HEIGHTS
    if low <= rms_height <= high:
        return 1.0
    return math.ldexp(1.0, math.frexp(rms_height)[1])
