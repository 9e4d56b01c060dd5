"""Edge amplitudes of a profile on a circle: closed for power laws, exact moments for tables.

Both classes answer the same questions at radii a, shape (k,): `depth` the approach D and its
derivatives, `gap` the mean of G~, and `amplitudes` the complex e_n of the angular harmonics, with
their own operators or with the n = 2 operator of the published solution throughout.
Derivatives are taken with ``a d/da``, under which a power r^j is multiplied by j.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicHermiteSpline, CubicSpline
from scipy.optimize import bisect

from asperity.errors import ModelRangeError
from asperity.halfspace.transforms import kappa, moments
from surfaces.arrays import Array, Index
from surfaces.polar import PolarProfile, PowerSumProfile

__all__ = [
    "Basis",
    "PowerBasis",
    "TableBasis",
    "around",
    "basis_of",
    "corner_rule",
    "radii_looked_at",
    "radius_at",
    "samples",
    "synthesis",
    "turning_radius",
]

Complex = NDArray[np.complex128]

_SAMPLES = 8192
"""Angles at which an angular factor is sampled."""

_HIGHEST = 512
"""Highest harmonic of a power-law profile."""

_PANELS = 64
"""Gauss nodes between two corners."""

_STEPS = 80
"""Iterations of a root search."""

_FARTHEST = 4.0
"""Radius to which a table is followed, over its last."""


class PowerBasis:
    """Profile ``sum_i r^k_i psi_i(phi)``: every integral is a multiplier kappa_m(k + n)."""

    def __init__(self, profile: PowerSumProfile, m: float) -> None:
        self.m = m
        self._profile = profile
        self.powers = np.asarray(profile.powers)
        phi = 2 * np.pi * np.arange(_SAMPLES) / _SAMPLES
        spectrum = np.fft.rfft(profile.factors(phi), axis=1) * (2 / _SAMPLES)
        self.orders = np.arange(1, _HIGHEST + 1)
        self.harmonics = spectrum[:, 1 : _HIGHEST + 1]
        means = _means(profile) if profile.corners else spectrum[:, 0].real / 2
        rounding = 1e-14 * np.max(np.abs(self.harmonics), axis=1)
        self.means = np.where(np.abs(means) > rounding, means, 0.0)
        self.depth_factors = self.means * kappa(self.m, self.powers)  # of a^k in D(a)

    def depth(self, a: Array, order: int = 0) -> Array:
        """``(a d/da)^order`` of the approach D(a) [m]."""
        return np.asarray(a[:, None] ** self.powers @ (self.depth_factors * self.powers**order))

    def gap(self, a: Array) -> Array:
        """Mean of G~ [m]: ``int_0^1 t f w dt``."""
        factors = self.depth_factors / (self.powers + self.m + 1)
        return np.asarray(a[:, None] ** self.powers @ factors)

    def amplitudes(self, a: Array, order: int = 0, *, published: bool = False) -> Complex:
        """``(a d/da)^order e_n`` [m] for n = 1, 2, ..., shape (k, harmonics)."""
        n = np.full_like(self.orders, 2) if published else self.orders
        multiplier = kappa(self.m, self.powers[:, None] + n) * self.powers[:, None] ** order
        return np.asarray(a[:, None] ** self.powers @ (multiplier * self.harmonics))

    def published(self, a: Array, phi: Array) -> Array:
        """Published numerator ``(1 - m) dG~ + dD`` [m] of the contour, shape (k, phi.size)."""
        deviation = self._profile.factors(phi) - self.means[:, None]
        multiplier = kappa(self.m, self.powers + 2)[:, None]
        return np.asarray(a[:, None] ** self.powers @ (multiplier * deviation))


class TableBasis:
    """Tabulated profile: piecewise cubics on the rays, integrated by exact moments."""

    def __init__(self, profile: PolarProfile, m: float) -> None:
        self.m = m
        self.nodes = profile.r
        n_phi = profile.phi.size
        local = _local_cubics(profile)
        spectrum = np.fft.rfft(local, axis=-1) * (2 / n_phi)
        count = n_phi // 2
        spectrum[..., n_phi - count :] /= 2  # an even number of rays holds the last harmonic twice
        self.orders = np.arange(1, count + 1)
        turn = np.exp(-1j * self.orders * profile.phi[0])
        self._mean = spectrum[..., 0].real / 2
        self._last: tuple[tuple[bytes, int, int], Array] | None = None
        self.harmonics = spectrum[..., 1 : count + 1] * turn

    def depth(self, a: Array, order: int = 0) -> Array:
        """See `PowerBasis`."""
        j = np.arange(4)
        scaled = self._mean * (1 + self.m + j) * j.astype(float) ** order
        value = self._integrate(a, scaled[..., None], np.zeros(1, dtype=np.int64))[:, 0]
        return value + self._jumps(a) if order == 2 else value

    def gap(self, a: Array) -> Array:
        """See `PowerBasis`."""
        return self._integrate(a, self._mean[..., None], np.zeros(1, dtype=np.int64))[:, 0]

    def amplitudes(self, a: Array, order: int = 0, *, published: bool = False) -> Complex:
        """See `PowerBasis`."""
        n = np.full_like(self.orders, 2) if published else self.orders
        j = np.arange(4)[:, None]
        scaled = self.harmonics * (n + 1 + self.m + j) * j.astype(float) ** order
        return self._integrate(a, scaled, n)

    def published(self, a: Array, phi: Array) -> Array:
        """See `PowerBasis`."""
        return synthesis(self.amplitudes(a, published=True), phi)

    def summit(self) -> tuple[float, complex]:
        """Mean and second harmonic of f/r^2 [1/m] at the summit, where the slope vanishes."""
        top = self.nodes[-1]
        if abs(self._mean[0, 1]) > 1e-6 * abs(self._mean[0, 2]):
            raise ModelRangeError("the profile has a sharp tip, no curvature; use another law")
        return self._mean[0, 2] / top**2, self.harmonics[0, 2, 1] / top**2

    def _integrate(self, a: Array, cubics: NDArray[Any], n: Index) -> NDArray[Any]:
        """Sum over segments and powers of ``c_j a^j int t^(n+1+j) w dt``, shape (k, n.size)."""
        lowest = int(n.min())
        table = self._moments(a, lowest, int(n.max()))
        powers = (a[:, None] / self.nodes[-1]) ** np.arange(4)
        out = np.zeros((a.size, n.size), dtype=cubics.dtype)
        for j in range(4):
            weights = table[..., n - lowest + j] * powers[:, j, None, None]
            out += np.einsum("ksn,sn->kn", weights, cubics[: table.shape[1], j])
        return out

    def _moments(self, a: Array, lowest: int, highest: int) -> Array:
        """Moments of the segments that begin within radii a; the last are kept."""
        key, last = (a.tobytes(), lowest, highest), self._last
        if last is None or last[0] != key:
            within = self.nodes[~(self.nodes >= np.max(a, initial=0.0))]
            edges = np.minimum(np.append(within, np.inf), a[:, None]) / a[:, None]
            last = self._last = key, moments(self.m, edges, np.arange(lowest + 1, highest + 5))
        return last[1]

    def _jumps(self, a: Array) -> Array:
        """Share in ``(a d/da)^2 D`` of the jumps of f'', the second derivative of the mean profile,
        at the inner nodes."""
        r, change = self.nodes[1:], np.diff(self._mean, axis=0)
        x = r / self.nodes[-1]
        t = np.minimum(r / a[:, None], 1.0)
        with np.errstate(divide="ignore"):
            weight = np.where(t < 1, (1 - t * t) ** ((self.m - 1) / 2), 0.0)
        kinks = 2 * change[:, 2] + 6 * change[:, 3] * x
        return np.asarray((weight * t * t) @ (kinks * x**2))


Basis = PowerBasis | TableBasis
"""What the laws need to know of a profile."""


@lru_cache(maxsize=8)
def basis_of(profile: PowerSumProfile | PolarProfile, m: float) -> Basis:
    """Basis of either kind of profile; those of the last profiles are kept."""
    kind = TableBasis if isinstance(profile, PolarProfile) else PowerBasis
    return kind(profile, m)  # type: ignore[arg-type]


def radius_at(basis: Basis, approach: Array) -> Array:
    """Radius a [m] with D(a) = approach on the rising branch of D, zero at d <= 0.

    NaN beyond the first zero of D'(a), and beyond four times the last radius of a table.
    """
    grid, reached = _rise(basis)
    end = grid[-1]
    a = np.where(approach > 0, np.nan, 0.0)
    found = (approach > 0) & (approach <= reached[-1] * (1 + 1e-14))
    d = approach[found]
    if isinstance(basis, PowerBasis):
        # of the n rising terms one is d/n at least, and without falling ones none is above d
        rising = basis.means > 0
        powers, share = basis.powers[rising], d[:, None] / basis.depth_factors[rising]
        with np.errstate(over="ignore"):
            low = np.min((share / powers.size) ** (1 / powers), axis=1)
            high = np.min(share ** (1 / powers), axis=1) if np.isinf(end) else np.full(d.size, end)
            for _ in range(_STEPS if np.isinf(end) and np.any(basis.means < 0) else 0):
                high = np.where(basis.depth(high) < d, 2 * high, high)
    else:
        cell = np.minimum(np.searchsorted(reached, d), grid.size - 1)
        low, high = np.append(0.0, grid)[cell], grid[cell]
    a[found] = _bracketed(basis, d, low, high)
    return a


def turning_radius(basis: Basis) -> float:
    """Radius [m] at which D' first vanishes, or to which a table is followed; infinite for a
    power-law body that only rises."""
    return float(_rise(basis)[0][-1])


@lru_cache(maxsize=8)
def _rise(basis: Basis) -> tuple[Array, Array]:
    """Radii [m] up to the turning radius, and the approaches D(a) [m] there; if that is infinite,
    so is the last of both."""
    looked_at = radii_looked_at(basis)
    end = _end(basis, looked_at)
    grid = np.append(looked_at[looked_at < end], end)
    return grid, basis.depth(grid) if np.isfinite(end) else np.array([np.inf])


def radii_looked_at(basis: Basis) -> Array:
    """Radii at which the sign of D' is looked at."""
    if isinstance(basis, TableBasis):
        r = basis.nodes
        inside = np.sort(np.concatenate([r[1:], (r[1:] + r[:-1]) / 2]))
        return np.append(inside, r[-1] * np.linspace(1.02, _FARTHEST, 40))
    pull = np.abs(basis.means * basis.powers)
    rising, falling = basis.means > 0, basis.means < 0
    if not np.any(falling) or not np.any(rising):
        return np.array([1.0])
    ratio = pull[rising][:, None] / pull[falling]
    gap = basis.powers[falling] - basis.powers[rising][:, None]
    with np.errstate(divide="ignore", over="ignore"):
        crossing = ratio ** (1 / np.where(gap == 0, np.inf, gap))
    # floating-point numbers hold the terms up to this radius
    most = np.min((1e300 / np.maximum(pull, 1.0)) ** (1 / np.maximum(basis.powers, 1.0)))
    low, high = np.clip([1e-3 * crossing.min(), 1e3 * crossing.max()], 1e-100, most)
    return np.geomspace(low, high, 3000)


def _end(basis: Basis, scan: Array) -> float:
    """`turning_radius`, from the `radii_looked_at`."""
    if not basis.depth(scan[:1])[0] > 0:
        raise ModelRangeError(
            "the mean profile does not rise from its summit, so the approach has no contact; "
            "put the origin at the highest point"
        )
    turned = np.flatnonzero(basis.depth(scan, 1) <= 0)
    if turned.size == 0:
        return float(scan[-1]) if isinstance(basis, TableBasis) else np.inf
    first = int(turned[0])
    low = scan[first - 1] if first else scan[0] / 8
    return float(bisect(lambda a: basis.depth(np.array([a]), 1)[0], low, scan[first]))


def _bracketed(basis: Basis, d: Array, low: Array, high: Array) -> Array:
    """Newton steps of log D over log a, replaced by bisection where they leave the bracket."""
    with np.errstate(all="ignore"):
        a = np.where(low > 0, np.sqrt(low) * np.sqrt(high), high / 2)
        for _ in range(_STEPS if d.size else 0):
            value, before = basis.depth(a), a
            low, high = np.where(value < d, a, low), np.where(value > d, a, high)
            newton = a * np.exp(np.log(d / value) * value / basis.depth(a, 1))
            middle = np.where(low > 0, np.sqrt(low) * np.sqrt(high), high / 2)
            a = np.where((newton >= low) & (newton <= high), newton, middle)
            if np.all(np.abs(a - before) <= 4e-16 * a):
                break
    return np.asarray(a)


def synthesis(amplitudes: Complex, phi: Array) -> Array:
    """``sum_n Re(e_n e^(i n phi))``, n = 1, 2, ..., shape (k, phi.size).

    Evaluated on a fine equispaced grid by the fast transform and splined from there.
    """
    return np.asarray(around(samples(amplitudes, _SAMPLES))(phi))


def around(values: Array) -> CubicSpline:
    """Periodic spline of values at equispaced angles from 0, along their last axis."""
    turn = np.linspace(0, 2 * np.pi, values.shape[-1] + 1)
    closed = np.concatenate([values, values[..., :1]], axis=-1)
    return CubicSpline(turn, closed, axis=-1, bc_type="periodic")


def samples(amplitudes: Complex, count: int) -> Array:
    """`synthesis` at `count` equispaced angles, more than twice the highest harmonic."""
    spectrum = np.zeros((amplitudes.shape[0], count // 2 + 1), dtype=complex)
    spectrum[:, 1 : amplitudes.shape[1] + 1] = amplitudes * (count / 2)
    return np.asarray(np.fft.irfft(spectrum, count, axis=1))


def corner_rule(corners: ArrayLike, nodes: int) -> tuple[Array, Array]:
    """Angles and weights of Gauss-Legendre rules between corners, shape (corners, nodes)."""
    start = np.sort(np.mod(corners, 2 * np.pi))
    ends = np.append(start, start[0] + 2 * np.pi)
    x, w = np.polynomial.legendre.leggauss(nodes)
    half = np.diff(ends)[:, None] / 2
    return np.asarray((ends[:-1, None] + half) + half * x), np.asarray(w * half)


def _means(profile: PowerSumProfile) -> Array:
    """Angular means between the corners of the section."""
    phi, weight = corner_rule(profile.corners, _PANELS)
    return np.asarray(np.sum(profile.factors(phi) * weight, axis=(1, 2)) / (2 * np.pi))


def _local_cubics(profile: PolarProfile) -> Array:
    """Coefficients of (r/R)^j on each segment and ray, shape (segments + 1, 4, rays).

    The last segment is the parabola beyond the last radius R.
    """
    top = profile.radius
    x, f, slope = profile.r / top, profile.f, profile.slope * top
    inside = CubicHermiteSpline(x, f, slope).c[::-1]
    beyond = np.stack([f[-1:], slope[-1:], f[-1:], np.zeros_like(f[-1:])])
    c0, c1, c2, c3 = np.concatenate([inside, beyond], axis=1)
    s = x[:, None]
    return np.stack(
        [
            c0 - s * (c1 - s * (c2 - s * c3)),
            c1 - s * (2 * c2 - 3 * s * c3),
            c2 - 3 * s * c3,
            c3,
        ],
        axis=1,
    )
