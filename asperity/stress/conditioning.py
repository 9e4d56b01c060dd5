"""Stress cases of conditioning: the work of boundary elements over grading, contact and size."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

from asperity.bem.solve import bem_solve
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import pressure_scale

from .case import BEM, Case
from .judges import refuse
from .maps import rough

__all__ = ["WORKS", "Work", "conditioning_cases"]

MOST_PAIRS, MOST_ITERATIONS = 15, 1000
"""Transform pairs on the full grid and steps on all grids that one load may take."""


@dataclass(frozen=True)
class Work:
    """One load on one rough map of `size` points per axis, graded by the exponent m: the load is a
    mean pressure over the one that flattens the roughness."""

    size: int
    m: float
    load: float

    def spent(self) -> tuple[float, int, int]:
        """Area fraction, iterations on all grids, and transform pairs on the full grid."""
        hm = rough((self.size, self.size))
        material = HalfSpace.from_modulus(1e9 * hm.spacing[0] ** -self.m, self.m)
        found = bem_solve(hm, material, pressure=self.load * pressure_scale(hm, material))
        refuse(found.reason)
        return found.area_fraction, found.iterations, found.fft_pairs


WORKS = [
    Work(size, m, load)
    for size in (64, 128, 256)
    for m in (-0.9, -0.5, 0.0, 0.5, 0.9)
    for load in (1e-3, 1e-2, 0.1, 1.0)
]
"""What is measured."""


def conditioning_cases() -> Iterator[Case]:
    """Cases of conditioning."""
    for work in WORKS:
        name = f"{work.size} x {work.size}, m = {work.m}, load of {work.load:g}"
        yield Case("conditioning", name, BEM, "bound on the work", partial(_share, work))


def _share(work: Work) -> float:
    """Transform pairs and iterations over those allowed."""
    _, iterations, pairs = work.spent()
    return max(pairs / MOST_PAIRS, iterations / MOST_ITERATIONS)
