"""Profiles f(r, phi) of one summit in polar coordinates about it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surfaces.arrays import Array

from .errors import InputError, as_number, as_numbers, shown

__all__ = ["PolarProfile", "PolynomialProfile", "PowerLawProfile", "PowerSumProfile"]

Angular = Callable[[Array], Any]


@dataclass(frozen=True, eq=False)
class PowerSumProfile:
    """Sum of power-law terms, f(r, phi) = sum_i r^k_i psi_i(phi).

    Parameters
    ----------
    powers
        Exponents k_i, positive.
    angular
        One angular factor psi_i per exponent: a vectorized function of phi [rad], a number, or an
        array of values at equispaced angles ``2 pi j / n`` (then interpolated by a periodic
        monotone cubic).
    corners
        Angles [rad] at which a factor has a kink (the corners of a polygon); angular means are
        then taken exactly between them.

    Raises
    ------
    InputError
        If the numbers of exponents and factors differ, or one of them is unusable.

    Notes
    -----
    The section changes with height unless there is one term. All radial integrals of such a
    profile are closed.

    Examples
    --------
    >>> import surfaces
    >>> tip = surfaces.PowerSumProfile([2.0, 4.0], [1.0, 0.5])
    >>> f"{float(tip(1.0, 0.0)):.2f}"
    '1.50'
    """

    powers: tuple[float, ...]
    angular: tuple[Angular, ...]
    corners: tuple[float, ...]

    def __init__(
        self, powers: Sequence[float], angular: Sequence[Any], *, corners: Sequence[float] = ()
    ) -> None:
        exponents = tuple(as_numbers("powers", powers).ravel().tolist())
        if not (np.iterable(angular) and 0 < len(exponents) == len(angular)):
            raise InputError(
                f"give one angular factor per exponent, not {shown(angular)} for {exponents}"
            )
        for k in exponents:
            if not k > 0:
                raise InputError(f"the exponent k must be positive and finite, got {k:g}")
        object.__setattr__(self, "powers", exponents)
        object.__setattr__(self, "angular", tuple(_angular(psi) for psi in angular))
        object.__setattr__(self, "corners", tuple(as_numbers("corners", corners).ravel().tolist()))

    @property
    def radius(self) -> float:
        """Largest radius [m] at which the profile is known: infinite."""
        return np.inf

    def factors(self, phi: ArrayLike) -> Array:
        """Angular factors psi_i at the angles `phi` [rad], shape `(terms, *phi.shape)`."""
        angle = np.asarray(phi, dtype=float)
        out = np.empty((len(self.powers), *angle.shape))
        for i, psi in enumerate(self.angular):
            out[i] = psi(angle)
        if not np.all(np.isfinite(out)):
            raise InputError("the angular factor psi is not finite at every angle")
        return out

    def __call__(self, r: ArrayLike, phi: ArrayLike) -> Array:
        """Gap f [m] at radius `r` [m] and angle `phi` [rad] (broadcast)."""
        radius = np.asarray(r, dtype=float)
        terms = zip(self.powers, self.factors(phi), strict=True)
        return np.asarray(sum(radius**k * psi for k, psi in terms))


class PowerLawProfile(PowerSumProfile):
    """Power-law profile f(r, phi) = r^k psi(phi): the self-similar body (Popov, Li &
    Willert 2023, equation 31).

    Parameters
    ----------
    k
        Exponent, positive: 1 a cone or pyramid, 2 a paraboloid.
    psi
        Angular factor [m^(1-k)]: vectorized function of phi, a number, or values at equispaced
        angles.
    corners
        Angles [rad] of the kinks of psi, if any.

    Examples
    --------
    >>> float(PowerLawProfile(2.0, 0.5)(3.0, 0.0))
    4.5
    """

    def __init__(self, k: float, psi: Any, *, corners: Sequence[float] = ()) -> None:
        super().__init__((k,), (psi,), corners=corners)

    @property
    def k(self) -> float:
        """The exponent."""
        return self.powers[0]

    def psi(self, phi: ArrayLike) -> Array:
        """The angular factor at `phi` [rad]."""
        return np.asarray(self.factors(phi)[0])


class PolynomialProfile(PowerSumProfile):
    """Polynomial profile f(x, y) = sum c_ij x^i y^j about the summit.

    Parameters
    ----------
    coefficients
        Mapping from the exponents (i, j) to c_ij [m^(1-i-j)], i + j >= 1.

    Examples
    --------
    >>> float(PolynomialProfile({(2, 0): 1.0, (0, 2): 3.0})(2.0, np.pi / 2))
    12.0
    """

    coefficients: Mapping[tuple[int, int], float]

    def __init__(self, coefficients: Mapping[tuple[int, int], float]) -> None:
        pairs = isinstance(coefficients, Mapping) and all(np.shape(p) == (2,) for p in coefficients)
        exponents = as_numbers("exponents", [*coefficients] if pairs else [])
        if not exponents.size or exponents.min() < 0 or exponents.sum(axis=1).min() < 1:
            raise InputError(
                f"coefficients is {shown(coefficients)}; give a mapping from the exponents (i, j), "
                "not negative with i + j >= 1"
            )
        given = {p: as_number(f"the coefficient of {p}", c) for p, c in coefficients.items()}
        degrees = sorted({i + j for i, j in given})
        terms = [[(i, j, c) for (i, j), c in given.items() if i + j == n] for n in degrees]
        super().__init__(degrees, [partial(_form, of_degree) for of_degree in terms])
        object.__setattr__(self, "coefficients", given)


def _least_slope(first: Array, last: Array, secant: Array) -> Array:
    """Least slope of cubics between two nodes, from those at both and of the straight line."""
    bend = 3.0 * (first + last - 2.0 * secant)
    fall = 2.0 * first + last - 3.0 * secant
    inside = (0.0 < fall) & (fall < bend)
    lowest = first - fall**2 / np.where(inside, bend, 1.0)
    return np.where(inside, lowest, np.minimum(first, last))


@dataclass(frozen=True, eq=False)
class PolarProfile:
    """Profile tabulated on rays, with a C2 (or monotone C1) cubic interpolation in r.

    Parameters
    ----------
    r
        Radii [m], shape (n_r,), increasing, at least 4; a first radius above 0 is preceded by
        f(0) = 0.
    phi
        Equispaced angles [rad] over one turn, shape (n_phi,), at least 4.
    f
        Gap f(r, phi) [m], shape (n_r, n_phi).
    edge
        Radius [m] along each angle at which the basin of the summit ends, shape (n_phi,): beyond it
        f is a continuation, not the body. None where the whole table is the body.

    Raises
    ------
    InputError
        If the table is malformed.

    Notes
    -----
    On each ray f is the not-a-knot cubic spline, with the slope 0 at the summit where the data
    have no tip; between nodes where that spline would turn back although the values rise, it has
    the slopes of the monotone cubic (PCHIP), and is C1 only. Beyond the last
    radius f goes on with its last slope and the curvature 2 f/r^2 there; contacts that reach so
    far are flagged by the laws. Between the rays: periodic cubic spline in phi.

    Examples
    --------
    >>> import numpy as np
    >>> import surfaces
    >>> r, phi = np.linspace(0, 1, 9), 2 * np.pi * np.arange(8) / 8
    >>> bowl = surfaces.PolarProfile(r, phi, np.outer(r**2, np.ones(8)))
    >>> f"{float(bowl(0.5, 0.3)):.3f}"
    '0.250'
    """

    r: Array
    phi: Array
    f: Array
    edge: Array | None = None

    def __post_init__(self) -> None:
        given = {"r": self.r, "phi": self.phi, "f": self.f}
        r, phi, f = (as_numbers(name, values).copy() for name, values in given.items())
        if r.ndim != 1 or phi.ndim != 1 or f.shape != (r.size, phi.size):
            raise InputError(
                f"f must have the shape (r, phi) = ({r.size}, {phi.size}), got {f.shape}"
            )
        if phi.size < 4 or not np.allclose(np.diff(phi), 2 * np.pi / phi.size, rtol=1e-6):
            raise InputError("phi must hold at least 4 equispaced angles over one turn")
        if r.size and r[0] > 0:
            r, f = np.append(0.0, r), np.vstack([np.zeros(phi.size), f])
        if r.size < 4 or r[0] != 0 or np.any(np.diff(r) <= 0):
            raise InputError("r must hold at least 4 increasing radii, none negative")
        edge = None if self.edge is None else as_numbers("edge", self.edge).copy()
        if edge is not None and not (edge.shape == phi.shape and np.all(edge > 0)):
            raise InputError(f"edge must hold a positive radius per angle, shape ({phi.size},)")
        for name, value in (("r", r), ("phi", phi), ("f", f - f[0]), ("edge", edge)):
            if value is not None:
                value.setflags(write=False)
            object.__setattr__(self, name, value)

    @property
    def radius(self) -> float:
        """Largest tabulated radius [m]."""
        return float(self.r[-1])

    @cached_property
    def slope(self) -> Array:
        """Radial slope f_r at the nodes of each ray, shape (n_r, n_phi)."""
        from scipy.interpolate import CubicSpline, PchipInterpolator

        r = self.r / self.radius  # the end conditions lose digits where r is large
        slope = CubicSpline(r, self.f)(r, 1)
        smooth = np.abs(slope[0]) * r[1] < 0.1 * np.abs(self.f[1])
        if np.any(smooth):
            table = self.f[:, smooth]
            flat = CubicSpline(r, table, bc_type=((1, np.zeros(table.shape[1])), "not-a-knot"))
            slope[:, smooth] = flat(r, 1)
        secant = np.diff(self.f, axis=0) / np.diff(r)[:, None]
        rising = np.all(secant >= 0.0, axis=0)
        small = -1e-9 * np.max(np.abs(slope))
        monotone: Array | None = None
        while True:  # at most once for each node
            turns = rising & (_least_slope(slope[:-1], slope[1:], secant) < small)
            if not np.any(turns):
                return np.asarray(slope / self.radius)
            if monotone is None:
                monotone = PchipInterpolator(r, self.f)(r, 1)
            ends = np.pad(turns, ((0, 1), (0, 0))) | np.pad(turns, ((1, 0), (0, 0)))
            if np.array_equal(slope[ends], monotone[ends]):  # but for rounding it rises
                return np.asarray(slope / self.radius)
            slope = np.where(ends, monotone, slope)

    def __call__(self, r: ArrayLike, phi: ArrayLike) -> Array:
        """Gap f [m] at radius `r` [m] and angle `phi` [rad] (broadcast)."""
        radius, angle = np.broadcast_arrays(np.asarray(r, float), np.asarray(phi, float))
        cell = np.clip(np.searchsorted(self.r, radius, side="right") - 1, 0, self.r.size - 2)
        low, high = self.r[cell], self.r[cell + 1]
        width = high - low
        f0, s0 = self._between_rays(cell, angle)
        f1, s1 = self._between_rays(cell + 1, angle)
        t = np.minimum((radius - low) / width, 1.0)
        inside = (
            f0 * (1 + 2 * t) * (1 - t) ** 2
            + f1 * t * t * (3 - 2 * t)
            + width * (s0 * t * (1 - t) ** 2 - s1 * t * t * (1 - t))
        )
        over = np.maximum(radius - self.radius, 0.0)
        return np.asarray(
            inside + np.where(over > 0, s1 * over + f1 * (over / self.radius) ** 2, 0)
        )

    @cached_property
    def _angular_spline(self) -> tuple[Array, Array]:
        from scipy.interpolate import CubicSpline

        turn = np.append(self.phi, self.phi[0] + 2 * np.pi) - self.phi[0]
        tables = [np.vstack([table.T, table.T[:1]]) for table in (self.f, self.slope)]
        splines = [CubicSpline(turn, table, bc_type="periodic").c for table in tables]
        return splines[0], splines[1]

    def _between_rays(self, node: NDArray[np.intp], phi: Array) -> tuple[Array, Array]:
        step = 2 * np.pi / self.phi.size
        turn = np.mod(phi - self.phi[0], 2 * np.pi)
        ray = np.minimum((turn / step).astype(np.intp), self.phi.size - 1)
        x = turn - ray * step
        value, slope = (
            ((c[0, ray, node] * x + c[1, ray, node]) * x + c[2, ray, node]) * x + c[3, ray, node]
            for c in self._angular_spline
        )
        return value, slope


def _angular(psi: Any) -> Angular:
    """A vectorized function of phi from a function, a number or equispaced samples."""
    if callable(psi):
        return psi  # type: ignore[no-any-return]
    values = as_numbers("psi", psi)
    if values.ndim == 0:
        return partial(_constant, float(values))
    if values.ndim != 1 or values.size < 4:
        raise InputError("psi must be a function, a number or at least 4 equispaced samples")
    from scipy.interpolate import PchipInterpolator

    n = values.size
    node = 2 * np.pi * np.arange(-3, n + 4) / n
    return partial(_over_turns, PchipInterpolator(node, values[np.arange(-3, n + 4) % n]))


def _constant(value: float, phi: Array) -> Array:
    return np.full(np.shape(phi), value)


def _over_turns(curve: Angular, phi: Array) -> Array:
    return np.asarray(curve(np.mod(phi, 2 * np.pi)))


def _form(terms: list[tuple[int, int, float]], phi: Array) -> Any:
    return sum(c * np.cos(phi) ** i * np.sin(phi) ** j for i, j, c in terms)
