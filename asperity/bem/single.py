"""One microcontact by the free-space boundary-element method: the reference of the laws."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from asperity.errors import Flag, InputError, cautious, warn_once
from asperity.halfspace.material import HalfSpace, require_half_space
from asperity.halfspace.scene import modulus_warning
from surfaces.arrays import Array
from surfaces.errors import as_count, as_numbers

from .certificate import Certificate
from .memory import require_memory
from .profile_map import Profile, gap, map_of, sampled, section_box
from .solution import BemSolution
from .solve import bem_solve

__all__ = ["BemIndentation", "indent_bem"]

_COARSE_POINTS = 64
"""Points per axis of the grid that finds the contact."""

_MARGIN = 1.1
"""Sides of the fine grid over those of the box about the contact found."""

_MEAN_PROFILE_RAYS = 256
"""Rays of the mean profile, from which the first approach to a load is taken."""

_RADII = np.geomspace(1e-12, 1e3, 181)
"""Radii [m] among which that of a contact is first looked for."""

_MAX_APPROACHES = 30
"""Approaches tried for a load."""

_PLACEMENTS = 4
"""How often the fine grid is widened when the contact reaches its rim."""


@dataclass(frozen=True, eq=False)
class BemIndentation:
    """Indentation by one profile, from the boundary-element method.

    Attributes
    ----------
    approach
        Rigid-body approach d [m], a number or shape (n,); the fields below have its shape.
    force
        Normal force [N].
    contact_area
        Contact area corrected for the pixels at its edge [m^2].
    converged
        Whether the certificate is within the tolerance.
    valid
        Converged, and the contact stays inside the radius where the profile is known.
    solutions
        The full solution of each approach, with pressure, gap and certificate.
    summit
        Where the profile's origin lies on the map of each solution, (x, y) [m].

    Examples
    --------
    >>> import asperity, surfaces
    >>> tip = surfaces.PowerLawProfile(2.0, 0.5)
    >>> one = asperity.indent_bem(tip, asperity.HalfSpace.from_modulus(1.0), 0.01, grid=32)
    >>> one.pressure_map.shape, bool(one.pressure(0.0, 0.0) > one.force / one.contact_area)
    ((32, 32), True)
    """

    approach: Any
    force: Any
    contact_area: Any
    converged: Any
    valid: Any
    solutions: tuple[BemSolution, ...]
    summit: tuple[tuple[float, float], ...]

    @property
    def flags(self) -> Any:
        """Bits of `asperity.microcontact.Flag`: where the contact leaves the known profile."""
        return np.where(self.converged & ~self.valid, Flag.BEYOND_RADIUS, 0).astype(np.uint8)[()]

    @property
    def certificate(self) -> Certificate:
        """Certificate of the worst of the solutions."""
        return max((s.certificate for s in self.solutions), key=lambda c: c.worst)

    @property
    def radius(self) -> Any:
        """Radius of the circle with the contact's area [m]."""
        return np.sqrt(self.contact_area / np.pi)

    @property
    def pressure_map(self) -> Array:
        """Pressure [Pa] at the last approach, shape (grid, grid)."""
        return self.solutions[-1].pressure

    @property
    def x(self) -> Array:
        """Columns of `pressure_map` from the summit [m]."""
        return self.solutions[-1].surface.x - self.summit[-1][0]

    @property
    def y(self) -> Array:
        """Rows of `pressure_map` from the summit [m]."""
        return self.solutions[-1].surface.y - self.summit[-1][1]

    def pressure(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Pressure [Pa] at places from the summit [m] (broadcast), bilinear between the pixels.

        Shape `(*approach.shape, *places.shape)`.
        """
        return self._each(lambda one, at: sampled(one.pressure, one.spacing, at, x, y))

    def contour(self, phi: ArrayLike) -> Array:
        """Distance of the contact's edge from the summit [m] at angles `phi` [rad].

        Shape `(*approach.shape, *phi.shape)`.

        Notes
        -----
        First crossing of one half by the bilinear indicator of the contact, with the pixel bias
        of the area taken out of the radius.
        """
        angle = as_numbers("phi", phi)
        return self._each(lambda one, at: _edge(one, at, angle))

    def _each(self, field: Callable[[BemSolution, tuple[float, float]], Array]) -> Array:
        found = np.array([field(*one) for one in zip(self.solutions, self.summit, strict=True)])
        return found.reshape(np.shape(self.approach) + found.shape[1:])


def _edge(solution: BemSolution, summit: tuple[float, float], angle: Array) -> Array:
    """Distance of the edge from the summit [m], see `BemIndentation.contour`."""
    reach = float(np.hypot(*np.multiply(solution.pressure.shape, solution.spacing)))
    r = np.linspace(0.0, reach, 4 * max(solution.pressure.shape))
    x, y = r * np.cos(angle[..., None]), r * np.sin(angle[..., None])
    inside = sampled(solution.contact.astype(float), solution.spacing, summit, x, y)
    out = np.argmax(inside < 0.5, axis=-1)
    out = np.maximum(out, 1)
    rows = np.arange(out.size).reshape(out.shape)
    flat = inside.reshape(-1, r.size)
    before, after = flat[rows, out - 1], flat[rows, out]
    step = np.clip((before - 0.5) / np.maximum(before - after, 1e-300), 0.0, 1.0)
    edge = r[out - 1] + step * (r[1] - r[0])
    bias = solution.contact_area / max(solution.contact_area_raw, 1e-300)
    return np.asarray(edge * np.sqrt(bias) * (before > 0.5))


@cautious
def indent_bem(
    profile: Profile,
    material: HalfSpace,
    approach: ArrayLike | None = None,
    *,
    load: ArrayLike | None = None,
    grid: int = 256,
    tolerance: float = 1e-6,
) -> BemIndentation:
    """Indentation of a half-space by one rigid profile: force, area, contour and pressure.

    Parameters
    ----------
    profile
        Gap at first touch f(r, phi) [m], zero at the summit and growing on every ray.
    material
        Elastic half-space, homogeneous or graded.
    approach
        Rigid-body approach d [m], positive, a number or shape (n,).
    load
        Normal force [N] in place of the approach; the approach is then part of the solution.
    grid
        Points per axis, 16 or more; the grid is fitted to the contact.
    tolerance
        Bound on each entry of the certificate [-].

    Raises
    ------
    InputError
        If neither or both of approach and load are given, one is not positive, the grid is too
        small or does not fit, the profile never rises to the approach, or an argument is unusable.

    Examples
    --------
    >>> import asperity, surfaces
    >>> sphere = surfaces.PowerLawProfile(2.0, 1.0)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> found = asperity.indent_bem(sphere, steel, 1e-6, grid=32)
    >>> bool(found.converged), f"{found.force / (steel.modulus * 1e-6**1.5):.2f}"
    (True, '0.94')
    """
    if not callable(profile):
        raise InputError(f"profile must be a gap f(r, phi), got {type(profile).__name__}")
    require_half_space(material)
    warn_once(modulus_warning(material))
    points = as_count("grid", grid, 16)
    require_memory((points, points), "free")
    if (approach is None) == (load is None):
        raise InputError("give either approach or load")
    name = "approach" if load is None else "load"
    depths = as_numbers(name, approach if load is None else load)
    if depths.size == 0 or not (depths > 0.0).all():
        unit = "[m]" if load is None else "[N]"
        raise InputError(f"{name} must be positive and finite {unit}")
    found = [_one(profile, material, name, float(d), points, tolerance) for d in depths.ravel()]
    solutions, summits, inside, reached = zip(*found, strict=True)
    converged = _shaped([s.converged for s in solutions], depths)
    return BemIndentation(
        approach=_shaped(list(reached), depths),
        force=_shaped([s.load for s in solutions], depths),
        contact_area=_shaped([s.contact_area for s in solutions], depths),
        converged=converged,
        valid=converged & _shaped(list(inside), depths),
        solutions=solutions,
        summit=summits,
    )


def _shaped(values: list[Any], like: Array) -> Any:
    return np.array(values).reshape(like.shape)[()]


def _one(
    profile: Profile, material: HalfSpace, name: str, value: float, grid: int, tolerance: float
) -> tuple[BemSolution, tuple[float, float], bool, float]:
    """Solve on a coarse grid around {f < d}, then on a fine one around the contact found."""
    if name == "approach":
        depth, (coarse, place) = value, _coarse_solution(profile, material, value)
    else:
        depth, coarse, place = _coarse_solution_at_load(profile, material, value)
    rows, cols = (np.flatnonzero(coarse.contact.any(axis=axis)) for axis in (1, 0))
    edges: list[float] = []
    for found, d, start in zip((cols, rows), coarse.spacing[::-1], place, strict=True):
        low, high = found[0] * d - d, (found[-1] + 2) * d
        half, middle = 0.5 * _MARGIN * (high - low), 0.5 * (high + low)
        edges += [middle - half - start, middle + half - start]
    for _ in range(_PLACEMENTS):
        hm, summit = map_of(profile, tuple(edges), grid, depth)
        mean = float(hm.heights.mean())
        prescribed = {"pressure": value / hm.area}
        if name == "approach":
            prescribed = {"separation": -value - mean}
        x, y = np.meshgrid(hm.x - summit[0], hm.y - summit[1])
        first = sampled(coarse.pressure, coarse.spacing, place, x, y)
        solution = bem_solve(
            hm, material, **prescribed, tolerance=tolerance, boundary="free", guess=first
        )
        contact = solution.contact
        whole = not (contact[[0, -1]].any() or contact[:, [0, -1]].any())
        if whole:
            break
        grow = 0.1 * (edges[1] - edges[0]), 0.1 * (edges[3] - edges[2])
        edges = [edges[0] - grow[0], edges[1] + grow[0], edges[2] - grow[1], edges[3] + grow[1]]
    radius = getattr(profile, "radius", np.inf)
    farthest = np.hypot(x, y)[contact].max(initial=0.0)
    reached = value if name == "approach" else -float(solution.separation) - mean
    return solution, summit, bool(farthest <= radius and whole), reached


def _coarse_solution(
    profile: Profile, material: HalfSpace, approach: float
) -> tuple[BemSolution, tuple[float, float]]:
    """Coarse solution in the box of {f < d}."""
    hm, summit = map_of(profile, section_box(profile, approach), _COARSE_POINTS, approach)
    level = -approach - float(hm.heights.mean())
    return bem_solve(hm, material, separation=level, tolerance=1e-2, boundary="free"), summit


def _coarse_solution_at_load(
    profile: Profile, material: HalfSpace, load: float
) -> tuple[float, BemSolution, tuple[float, float]]:
    """Approach [m] and coarse solution that carry the load to 2 %, by secants in logarithms."""
    radius = getattr(profile, "radius", np.inf)
    phi = np.linspace(0.0, 2.0 * np.pi, _MEAN_PROFILE_RAYS, endpoint=False)
    # the radius a at which E* a^(1+m) times the mean gap is about the load
    radii = np.geomspace(1e-3 * radius, radius / 8, 64) if np.isfinite(radius) else _RADII
    gaps = [float(np.mean(gap(profile, np.full(phi.shape, each), phi))) for each in radii]
    with np.errstate(divide="ignore", over="ignore"):
        forces = np.log(material.modulus * radii ** (1 + material.m) * gaps)
    depth = gaps[int(np.argmin(np.abs(forces - np.log(load))))]
    power, last = 1.5, None
    for _ in range(_MAX_APPROACHES):
        coarse, summit = _coarse_solution(profile, material, depth)
        force = coarse.load
        if abs(force / load - 1) < 0.02:
            return depth, coarse, summit
        point = (np.log(depth), np.log(force))
        if last is not None and abs(point[0] - last[0]) > 1e-6:
            power = float(np.clip((point[1] - last[1]) / (point[0] - last[0]), 0.5, 6.0))
        last = point
        depth *= float((load / force) ** (1 / power))
    raise InputError(f"no approach was found that carries {load:g} N; check its unit")
