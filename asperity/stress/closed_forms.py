"""Closed forms that judge the engines; they share no code with them."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq
from scipy.signal import fftconvolve
from scipy.special import beta, ellipe, ellipk, gamma

from surfaces.arrays import Array

__all__ = [
    "elliptic_contact",
    "free_displacement",
    "periodic_displacement",
    "power_law_contact",
    "wave_contact",
]


def power_law_contact(
    k: float, scale: float, depth: float, modulus: float, m: float = 0.0
) -> tuple[float, float]:
    """Force [N] and contact area [m^2] of the round body scale r^k at an approach [m].

    Notes
    -----
    Dimensionality reduction of the graded half-space (Popov, Heß and Willert 2019): the approach
    is scale (k/2) B(k/2, (1+m)/2) a^k, the force 2 E_m* d a^(1+m) k / ((1+m)(1+m+k)).
    """
    radius = (depth / (scale * 0.5 * k * beta(0.5 * k, 0.5 * (1.0 + m)))) ** (1.0 / k)
    force = 2.0 * modulus * depth * radius ** (1.0 + m) * k / ((1.0 + m) * (1.0 + m + k))
    return force, math.pi * radius**2


def elliptic_contact(ratio: float, depth: float, modulus: float) -> tuple[float, float]:
    """Force [N] and contact area [m^2] of the paraboloid with the curvatures 1 and `ratio` [1/m].

    Notes
    -----
    Hertz. The semi-axes a and b = a k' satisfy ratio = (E/k'^2 - K) / (K - E) with the complete
    elliptic integrals of the eccentricity; d = p0 b K/E*, F = 2/3 pi p0 a b.
    """
    if ratio == 1.0:
        return 4.0 / 3.0 * modulus * depth**1.5, math.pi * depth

    def mismatch(log_axes: float) -> float:
        axes2 = math.exp(2.0 * log_axes)
        first, second = ellipk(1.0 - axes2), ellipe(1.0 - axes2)
        return float(math.log((second / axes2 - first) / (first - second)) - math.log(ratio))

    axes = math.exp(brentq(mismatch, -15.0, -1e-4, xtol=1e-14))
    first, second = ellipk(1.0 - axes**2), ellipe(1.0 - axes**2)
    shape = axes * (first - second) / (1.0 - axes**2)  # curvature 1 = 2 p0/(E* a) times this
    long = math.sqrt(2.0 * depth * shape / (axes * first))
    peak = modulus * depth / (axes * long * first)
    return 2.0 / 3.0 * math.pi * peak * axes * long**2, math.pi * axes * long**2


def wave_contact(share: Array) -> tuple[Array, Array]:
    """Contact area fraction, and mean gap over the amplitude, of a wave of ridges, at mean
    pressures from 0 to 1 times that of full contact, pi E* A / wavelength, shape (n,).

    Notes
    -----
    Westergaard (1939).
    """
    return 2.0 / np.pi * np.arcsin(np.sqrt(share)), 1.0 - share + share * np.log(share)


def periodic_displacement(
    pressure: Array, spacing: tuple[float, float], modulus: float, m: float
) -> Array:
    """Displacement [m] by a pressure [Pa] that repeats: 2^(1-m) pi / Gamma((1+m)/2)^2 q^(m-1)/E_m*
    of each wave."""
    ny, nx = pressure.shape
    qy = 2.0 * np.pi * np.fft.fftfreq(ny, spacing[0])[:, None]
    q = np.hypot(qy, 2.0 * np.pi * np.fft.rfftfreq(nx, spacing[1]))
    q[0, 0] = 1.0
    waves = np.fft.rfft2(pressure) * q ** (m - 1.0)
    waves[0, 0] = 0.0
    factor = 2.0 ** (1.0 - m) * np.pi / gamma((1.0 + m) / 2.0) ** 2 / modulus
    return np.asarray(factor * np.fft.irfft2(waves, s=pressure.shape))


def free_displacement(pressure: Array, spacing: tuple[float, float], modulus: float) -> Array:
    """Displacement [m] by a pressure [Pa] that is constant on each pixel (Love 1929), m = 0."""
    ny, nx = pressure.shape
    dy, dx = spacing
    y = (np.arange(1 - ny, ny)[:, None] - 0.5) * dy
    x = (np.arange(1 - nx, nx)[None, :] - 0.5) * dx

    def corner(x: Array, y: Array) -> Array:
        return np.asarray(x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y)))

    kernel = corner(x + dx, y + dy) - corner(x, y + dy) - corner(x + dx, y) + corner(x, y)
    return np.asarray(fftconvolve(kernel, pressure, mode="valid") / (np.pi * modulus))
