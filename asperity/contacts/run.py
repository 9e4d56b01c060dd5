"""A contact curve with the load points behind it, for maps and tables."""

from __future__ import annotations

import operator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.curve import solve_loads
from asperity.errors import ConvergenceError, InputError, cautious, warn_once
from asperity.progress import Progress
from asperity.results.curve import ContactCurve
from surfaces.arrays import Array, Mask
from surfaces.drawing import draw_field

from .fields import pressure_map
from .spots import spot_table
from .table import microcontacts

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from asperity.halfspace.material import HalfSpace
    from asperity.model.decomposition import Decomposition
    from asperity.model.load_point import LoadPoint
    from asperity.model.plan import Plan
    from surfaces.heightmap import HeightMap

__all__ = ["ContactRun", "solve_contacts"]


@dataclass(frozen=True, eq=False)
class ContactRun:
    """A contact curve with the decomposition and load points behind it.

    Attributes
    ----------
    curve
        The contact curve.
    decomposition
        The decomposed surface.
    points
        The load points with the state of all microcontacts, in the order of the curve.

    Raises
    ------
    ConvergenceError
        If a table or a map is asked for at a load point that did not converge.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> run = asperity.solve_contacts(hm, steel, pressures=[1e9])
    >>> run.pressure_map().shape
    (32, 48)
    """

    curve: ContactCurve
    decomposition: Decomposition
    points: tuple[LoadPoint, ...]

    def microcontacts(self, point: int = -1) -> NDArray[np.void]:
        """Table of the contacts that carry load at a load point, see `contacts.table`."""
        return microcontacts(self.decomposition, self._point(point))

    def spots(self, point: int = -1) -> NDArray[np.void]:
        """Table of the separate spots at a load point, see `contacts.spots`."""
        return spot_table(self.decomposition, self._point(point))

    def contact_map(self, point: int = -1) -> Mask:
        """Pixels in contact at a load point, shape (ny, nx): those under pressure."""
        return self.pressure_map(point) > 0

    def pressure_map(self, point: int = -1) -> Array:
        """Pressure [Pa] of every pixel at a load point, shape (ny, nx)."""
        return pressure_map(self.decomposition, self._point(point))

    def plot(self, point: int = -1, ax: Axes | None = None, **style: Any) -> Axes:
        """Draw the pressure at a load point in true proportions, on new axes if None; `style` goes
        to ``imshow``. Of the curve: ``run.curve.plot()``.

        Examples
        --------
        >>> import asperity, surfaces
        >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1)
        >>> run = asperity.solve_contacts(hm, asperity.HalfSpace(210e9, 0.3), pressures=[1e9])
        >>> run.plot().get_xlabel()
        'x'
        """
        size = self.decomposition.hm.size
        return draw_field(ax, self.pressure_map(point), size, "pressure", "Pa", **style)

    def __str__(self) -> str:
        return f"{self.curve}\nsummits         {len(self.decomposition.summits)}"

    __repr__ = __str__

    def _point(self, point: int) -> LoadPoint:
        try:
            found = self.points[operator.index(point)]
        except (IndexError, TypeError):
            raise InputError(
                f"point is {point!r}; the load points are numbered 0 to {len(self.points) - 1}"
            ) from None
        if not found.converged:
            raise ConvergenceError(f"load point {point} cannot be used: {found.reason}")
        return found


@cautious
def solve_contacts(
    hm: HeightMap,
    material: HalfSpace,
    plan: Plan | None = None,
    *,
    pressures: ArrayLike | None = None,
    separations: ArrayLike | None = None,
    progress: Progress = None,
) -> ContactRun:
    """Run `contact_curve` by a plan and keep the load points (for maps and tables).

    Arguments are those of `contact_curve`; without a plan one is made with its defaults.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> run = asperity.solve_contacts(hm, steel, pressures=[1e9])
    >>> f"{run.microcontacts()['force'].sum() / run.curve.load[0]:.6f}"
    '1.000000'
    """
    run = ContactRun(
        *solve_loads(
            hm, material, plan, pressures=pressures, separations=separations, progress=progress
        )
    )
    warn_once(run.curve.settings["warnings"])
    return run
