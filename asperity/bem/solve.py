"""One rough contact, solved by the boundary-element method and certified."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surfaces.heightmap import HeightMap

from ..errors import InputError, SurfaceError
from ..threads import threads as thread_count
from ..threads import use_numba
from ._grid_kernels import finish
from .correction import Level, Outcome
from .grids import CoarseMaps, level_shapes, prolong
from .kernel import ElasticHalfSpace
from .load_search import LoadSearch
from .operator import Boundary, HalfSpaceOperator
from .solution import BemSolution

__all__ = ["ContactProblem", "bem_solve"]

_COARSE_TOLERANCE = 1e-2
_FIRST_LOAD = 1e-3


def bem_solve(
    hm: HeightMap,
    mat: ElasticHalfSpace,
    *,
    pressure: float | None = None,
    separation: float | None = None,
    tolerance: float = 1e-6,
    boundary: Boundary | None = None,
    guess: BemSolution | ArrayLike | None = None,
) -> BemSolution:
    """Full boundary-element solution of a rough map against a rigid flat, without friction.

    Parameters
    ----------
    hm
        Height map without missing points; it is the elastic body (or the composite roughness of
        two bodies).
    mat
        Elastic half-space, homogeneous or graded (`modulus`, `m`).
    pressure
        Prescribed mean pressure [Pa], non-negative; or
    separation
        prescribed separation [m]: periodic, the mean gap, positive; free, the distance of the
        flat from the mean plane of the undeformed map.
    tolerance
        Bound on each entry of the certificate [-], 1e-12 to 1e-1.
    boundary
        "periodic" (the cell repeats) or "free" (finite punch on a half-space); by default the
        map's own `periodic` flag.
    guess
        Start: an earlier solution on the same grid, or a pressure [Pa], shape (ny, nx).

    Returns
    -------
    BemSolution
        Marked `converged = False` with a reason if the certificate missed the tolerance.

    Raises
    ------
    SurfaceError
        If the map has missing points.
    InputError
        If an argument is out of its range, or both or neither of the loads are given.

    Notes
    -----
    Solves ``p >= 0, g >= 0, p g = 0`` with ``g = u - h - min(u - h)``, ``u = K p`` (theory sheet,
    section 6). The certificate is recomputed from the returned pressure with the exact operator
    in float64.
    """
    problem = ContactProblem(hm, mat, tolerance=tolerance, boundary=boundary, once=True)
    return problem.solve(pressure=pressure, separation=separation, guess=guess)


class ContactProblem:
    """A map, a material and a boundary, planned once and solved at many loads.

    Parameters
    ----------
    hm, mat, tolerance, boundary
        As in `bem_solve`.
    once
        Solved at one load only: the result takes over the buffers instead of copying them.
    """

    def __init__(
        self,
        hm: HeightMap,
        mat: ElasticHalfSpace,
        *,
        tolerance: float = 1e-6,
        boundary: Boundary | None = None,
        once: bool = False,
    ) -> None:
        if hm.missing:
            raise SurfaceError(
                f"{hm.name or 'the map'} has {hm.missing} missing points of {hm.heights.size}; "
                'fill them first, for example surfaces.prepare(hm, fill="harmonic")'
            )
        if not 1e-12 <= tolerance <= 0.1:
            raise InputError(f"tolerance is {tolerance!r}; give a number from 1e-12 to 0.1")
        if boundary is None:
            boundary = "periodic" if hm.periodic else "free"
        start = time.perf_counter()
        self.hm, self.mat, self.tolerance = hm, mat, float(tolerance)
        self._last = once
        self._threads = thread_count()
        use_numba(self._threads)
        exact = HalfSpaceOperator(hm.shape, hm.spacing, mat, boundary, threads=self._threads)
        self.boundary: Boundary = boundary
        self.compliance = exact.compliance
        self.level = Level(hm.heights, exact)
        self._mean_height = float(hm.heights.mean())
        self.setup_seconds = time.perf_counter() - start

    def solve(
        self,
        *,
        pressure: float | None = None,
        separation: float | None = None,
        guess: BemSolution | ArrayLike | None = None,
    ) -> BemSolution:
        """Solve at one mean pressure [Pa] or separation [m]; see `bem_solve`."""
        load, offset = self._checked(pressure, separation)
        start = time.perf_counter()
        self.level.exact.pairs = 0
        self.level.pressure[:] = 0.0
        iterations = 0
        search = None
        touching = load > 0.0 if offset is None else -offset < float(self.hm.heights.max())
        if touching:
            if offset is not None:
                search = LoadSearch(offset, _FIRST_LOAD * self.level.rms_height)
            if guess is not None:
                self._begin(guess, search.mean if search else load)
            else:
                iterations = self._nested(load, search)
        middle = time.perf_counter()
        outcome = self.level.solve(search or load, self.tolerance)
        seconds = {
            "setup": self.setup_seconds,
            "coarse grids": middle - start,
            "fine grid": time.perf_counter() - middle,
        }
        return self._solution(outcome, offset, iterations, seconds)

    def _checked(
        self, pressure: float | None, separation: float | None
    ) -> tuple[float, float | None]:
        """Mean of p~ [m] and level of u - h in the contact [m], if that is prescribed."""
        if (pressure is None) == (separation is None):
            raise InputError("give exactly one of pressure and separation")
        if pressure is not None:
            if not (math.isfinite(pressure) and pressure >= 0.0):
                raise InputError(
                    f"pressure is {pressure!r} Pa; give a finite mean pressure, not negative"
                )
            return pressure * self.compliance, None
        if separation is None or not math.isfinite(separation):
            raise InputError(f"separation is {separation!r} m; give a finite distance")
        if self.boundary == "periodic" and separation <= 0.0:
            raise InputError(
                f"separation is {separation:.4g} m; in a periodic cell it is the mean gap, which "
                "is positive below full contact; prescribe a pressure instead"
            )
        return 0.0, -separation - self._mean_height

    def _begin(self, guess: BemSolution | ArrayLike, mean: float) -> None:
        """Start from a given pressure, scaled to the load."""
        given = guess.pressure if isinstance(guess, BemSolution) else np.asarray(guess, np.float64)
        if given.shape != self.hm.shape or not np.isfinite(given).all():
            raise InputError(
                f"guess has shape {given.shape}; give finite pressures of shape {self.hm.shape}"
            )
        pressure = self.level.pressure
        np.maximum(given, 0.0, out=pressure)
        start = float(pressure.mean())
        if start > 0.0:
            pressure *= mean / start
        else:
            pressure[:] = mean

    def _nested(self, load: float, search: LoadSearch | None) -> int:
        """Start from the coarser grids; returns the iterations spent on them."""
        shapes = level_shapes(self.hm.shape)[:-1]
        pair = self.level.exact.transform
        maps = CoarseMaps(self.hm.heights, pair, self.boundary, shapes)
        iterations = 0
        coarse: Level | None = None
        ly, lx = self.hm.size
        for index, (ny, nx) in enumerate(shapes):
            spacing = (ly / ny, lx / nx)
            exact = HalfSpaceOperator(
                (ny, nx), spacing, self.mat, self.boundary, threads=self._threads
            )
            heights = maps.level(index, (ny, nx), exact.transform)
            level = Level(heights, exact)
            ratio = exact.compliance / self.compliance
            if search and -search.offset >= float(heights.max()):
                continue
            if search:
                search.rescale(ratio)
            self._start(level, coarse, ratio * load, search)
            tolerance = max(_COARSE_TOLERANCE, self.tolerance)
            iterations += level.solve(search or ratio * load, tolerance).iterations
            if search:
                search.rescale(1.0 / ratio)
            coarse = level
        self._start(self.level, coarse, load, search)
        return iterations

    def _start(
        self, level: Level, coarse: Level | None, load: float, search: LoadSearch | None
    ) -> None:
        """First pressure of a grid, at its load: from the coarser grid if there is one."""
        mean = search.mean if search else load
        if coarse is not None:
            prolong(
                coarse.exact.pressure,
                coarse.heights.shape,
                level.exact.pressure,
                level.heights.shape,
                self.boundary,
                mean,
            )
        elif search:
            highest = np.unravel_index(level.heights.argmax(), level.heights.shape)
            level.pressure[highest] = mean * level.heights.size
        else:
            level.pressure[:] = mean

    def _solution(
        self,
        outcome: Outcome,
        offset: float | None,
        coarse: int,
        seconds: dict[str, float],
    ) -> BemSolution:
        exact, reading = self.level.exact, outcome.reading
        grids = exact.pressure, exact.transform.grid
        out = grids if self._last else (np.empty(self.hm.shape), np.empty(self.hm.shape))
        level = reading.level if offset is None else offset
        finish(*grids, self.hm.heights, 1.0 / self.compliance, level, *out)
        pressure, gap = (grid[:, : self.hm.shape[1]] for grid in out)
        mean = float(pressure.mean())
        cell = self.hm.spacing[0] * self.hm.spacing[1]
        return BemSolution(
            pressure=pressure,
            gap=gap,
            separation=-reading.level - self._mean_height,
            mean_pressure=mean,
            load=mean * self.hm.area,
            elastic_energy=0.5 * reading.moment / self.compliance * cell,
            certificate=reading.certificate,
            converged=outcome.converged,
            status="converged" if outcome.converged else "stagnated",
            reason=outcome.reason,
            iterations=coarse + outcome.iterations,
            fft_pairs=exact.pairs,
            seconds=seconds,
            boundary=self.boundary,
            spacing=self.hm.spacing,
            settings=self.settings(),
        )

    def settings(self) -> dict[str, Any]:
        """Everything needed to repeat a run."""
        return {
            "model": "bem",
            "boundary": self.boundary,
            "tolerance": self.tolerance,
            "modulus": float(self.mat.modulus),
            "m": float(self.mat.m),
            "shape": self.hm.shape,
            "spacing": self.hm.spacing,
            "threads": self._threads,
        }
