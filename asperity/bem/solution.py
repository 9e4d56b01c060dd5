"""The result of one boundary-element solution, and what its pressure says of the contact."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from asperity.halfspace.scene import Boundary
from surfaces.arrays import Array, Mask
from surfaces.drawing import draw_field
from surfaces.heightmap import HeightMap
from surfaces.patches import count_patches, label_patches

from .certificate import Certificate

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["BemSolution", "contours", "read_contact"]

AREA_FACTOR = (math.pi - 1.0 + math.log(2.0)) / 24.0
"""Correction of the contact area per edge pixel (Yastrebov, Anciaux, Molinari 2017)."""


@dataclass(frozen=True, eq=False)
class BemSolution:
    """Pressure and gap of a rough contact, with the certificate of how exact they are.

    Attributes
    ----------
    surface
        The undeformed map.
    pressure
        Contact pressure [Pa], shape (ny, nx), compression positive.
    gap
        Gap between the surfaces [m], shape (ny, nx); zero in the contact.
    plastic_depth
        How far the surface has yielded [m], shape (ny, nx): positive where the pressure is the
        hardness, else zero.
    separation
        Distance of the rigid flat from the mean plane of the undeformed map [m]; in a periodic cell
        the mean gap less the mean plastic depth.
    mean_pressure, load
        Load over nominal area [Pa] and normal load [N].
    area_fraction, contact_area
        Contact area corrected for the pixels at its edge, over the nominal area [-] and [m^2].
    contact_area_raw
        Contact area counted in pixels [m^2]; too large by 3-16 % on rough maps.
    contacts
        Number of separate contact patches.
    stiffness
        Minus the slope of mean pressure over separation [Pa/m]; infinite in full contact of a
        periodic cell, NaN if not converged.
    error_estimate, area_error_estimate
        Bounds on the relative errors of the load at equal separation and of the contact area at
        equal load.
    elastic_energy
        Elastic energy stored by the contact, ``1/2 int p u dA`` [J], displacements measured from
        the mean plane (periodic) or from infinity (free).
    certificate
        Errors recomputed in float64 from `pressure` alone.
    converged, status, reason
        Whether the certificate is within the tolerance; "converged" or "stagnated"; why not.
    iterations, fft_pairs
        Conjugate-gradient steps on all grids, and transform pairs on the full grid.
    seconds
        Run time by stage [s].
    boundary, spacing, settings
        "periodic" or "free"; pixel size (dy, dx) [m]; everything needed to repeat the run.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> found = asperity.bem_solve(hm, steel, pressure=1e9)
    >>> bool(found.gap.min() > -1e-6 * hm.rms_height), bool(0.0 < found.area_fraction < 1.0)
    (True, True)
    """

    surface: HeightMap
    pressure: Array
    gap: Array
    plastic_depth: Array
    separation: float
    mean_pressure: float
    load: float
    area_fraction: float
    contact_area: float
    contact_area_raw: float
    contacts: int
    stiffness: float
    error_estimate: float
    area_error_estimate: float
    elastic_energy: float
    certificate: Certificate
    converged: bool
    status: str
    reason: str
    iterations: int
    fft_pairs: int
    seconds: Mapping[str, float]
    boundary: Boundary
    spacing: tuple[float, float]
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def contact(self) -> Mask:
        """Pixels under pressure, shape (ny, nx)."""
        return self.pressure > 0.0

    @property
    def hardness(self) -> float:
        """Largest pressure that the surface bears [Pa]; infinite if none limits it."""
        return float(self.settings.get("hardness", math.inf))

    @property
    def saturated(self) -> Mask:
        """Pixels whose pressure is the hardness, shape (ny, nx)."""
        return self.pressure >= self.hardness

    @property
    def plastic_share(self) -> float:
        """Area under a pressure of the hardness over the contact area [-]."""
        held = np.count_nonzero(self.saturated) * self.spacing[0] * self.spacing[1]
        return min(held / self.contact_area, 1.0) if held else 0.0

    def unloaded(self) -> HeightMap:
        """The surface after the load is taken off: the map less the plastic depth.

        The shape that yielded stays, all else springs back; pressed again by the same load, it
        carries the same pressure elastically.
        """
        heights = self.surface.heights - self.plastic_depth
        step = {"step": "unload", "mean_pressure": self.mean_pressure, "hardness": self.hardness}
        return self.surface.replace(heights=heights, step=step)

    @property
    def mean_gap(self) -> float:
        """Mean of the gap over the map [m]."""
        return float(self.gap.mean())

    @cached_property
    def patches(self) -> NDArray[np.int32]:
        """Labels 1..n of the contact patches, joined across a periodic seam, shape (ny, nx)."""
        return label_patches(self.contact, periodic=self.boundary == "periodic")[0]

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Draw the pressure in true proportions, on new axes if None; `style` goes to ``imshow``.

        Examples
        --------
        >>> import asperity, surfaces
        >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1)
        >>> asperity.bem_solve(hm, asperity.HalfSpace(210e9, 0.3), pressure=1e9).plot().get_xlabel()
        'x'
        """
        return draw_field(ax, self.pressure, self.surface.size, "pressure", "Pa", **style)

    def outlines(self) -> list[Array]:
        """Outlines of the patches, polygons (x, y) [m], shape (n, 2) each."""
        return contours(self.contact, self.spacing)

    def __str__(self) -> str:
        ny, nx = self.pressure.shape
        c = self.certificate
        share = f", {100 * self.plastic_share:.4g} % of it at the hardness"
        plastic = share if math.isfinite(self.hardness) else ""
        lines = [
            f"BEM contact      {ny} x {nx}, {self.boundary}, {self.status}",
            f"mean pressure    {self.mean_pressure:.6g} Pa      load {self.load:.6g} N",
            f"separation       {self.separation:.6g} m      mean gap {self.mean_gap:.6g} m",
            f"contact          {100 * self.area_fraction:.4g} % (corrected) in "
            f"{self.contacts} patches{plastic}",
            f"certificate      load {c.load:.1e}, complementarity {c.complementarity:.1e}, "
            f"penetration {c.penetration:.1e}" + (f", lift {c.lift:.1e}" if c.lift else ""),
            f"bounds           load {100 * self.error_estimate:.2g} %, "
            f"area {100 * self.area_error_estimate:.2g} %",
            f"cost             {self.fft_pairs} transform pairs, {self.iterations} iterations, "
            f"{sum(self.seconds.values()):.3g} s",
        ]
        lines += [f"warning          {why}" for why in self.settings.get("warnings", ())]
        if self.reason:
            lines.append(f"not converged    {self.reason}")
        return "\n".join(lines)

    __repr__ = __str__


def read_contact(
    pressure: Array, spacing: tuple[float, float], nx: int, hardness: float, *, periodic: bool
) -> tuple[float, float, int]:
    """Contact area [m^2] in pixels, the same corrected for the pixels at its edge, and the number
    of patches, of a pressure with nx columns or more. Hardness has the unit of the pressure.

    Notes
    -----
    ``A = A_px - (pi - 1 + ln 2)/24 P d`` (Yastrebov, Anciaux, Molinari 2017), where P d is the
    number of edges times the pixel area, so that it holds for pixels that are not square. The area
    is never less than the load over the hardness.
    """
    contact = pressure[:, :nx] > 0.0
    pixels, patches = np.count_nonzero(contact), count_patches(contact, periodic=periodic)
    edges = _edges(contact, periodic) + _edges(contact.T, periodic)
    pixel = spacing[0] * spacing[1]
    least = float(pressure.sum()) / hardness if math.isfinite(hardness) else 0.0
    return pixels * pixel, max(pixels - AREA_FACTOR * edges, least) * pixel, patches


def _edges(contact: Mask, periodic: bool) -> int:
    """Edges along the first axis between pixels of the contact and others, also across the seam of
    a periodic map. The border of a free map cuts contacts where the pixels end: it is none."""
    seam = np.count_nonzero(contact[0] != contact[-1]) if periodic else 0
    return int(np.count_nonzero(contact[1:] != contact[:-1]) + seam)


def contours(contact: Mask, spacing: tuple[float, float]) -> list[Array]:
    """Outlines of the patches as closed polygons of pixel centres (x, y) [m], shape (n, 2) each.

    A patch that crosses the seam of a periodic map gives one outline on each side of it.
    """
    import cv2

    found, _ = cv2.findContours(
        np.ascontiguousarray(contact).view(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE
    )
    scale = np.array([spacing[1], spacing[0]])
    return [(outline[:, 0, :] + 0.5) * scale for outline in found]
