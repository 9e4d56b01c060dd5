"""Oracle and maps for the tests of the boundary elements: numpy only, nothing of their code."""

from __future__ import annotations

import numpy as np

from surfaces import HeightMap


def periodic_displacement(pressure, spacing, modulus, m):
    """u of a periodic pressure from the symbol, written out again."""
    from math import gamma, pi

    ny, nx = pressure.shape
    qy = 2 * pi * np.fft.fftfreq(ny, spacing[0])[:, None]
    qx = 2 * pi * np.fft.rfftfreq(nx, spacing[1])[None, :]
    q = np.hypot(qy, qx)
    q[0, 0] = 1.0
    compliance = 2 ** (1 - m) * pi / gamma((1 + m) / 2) ** 2 / modulus * q ** (m - 1)
    compliance[0, 0] = 0.0
    return np.fft.irfft2(np.fft.rfft2(pressure) * compliance, s=pressure.shape)


def polonsky_keer(heights, spacing, mean, *, modulus=1.0, m=0.0, tolerance=1e-9, longest=3000):
    """Pressure [Pa] by the textbook method (Polonsky and Keer 1999): cold, no preconditioner."""
    pressure = np.full(heights.shape, float(mean))
    direction = np.zeros_like(pressure)
    old, restart = 1.0, 0.0
    rms = heights.std()
    for _ in range(longest):
        contact = pressure > 0
        gap = periodic_displacement(pressure, spacing, modulus, m) - heights
        gap -= gap[contact].mean()
        error = (pressure * np.abs(gap)).sum() / (pressure.sum() * rms)
        if max(error, -gap.min() / rms) < tolerance:
            break
        norm = (gap[contact] ** 2).sum()
        direction = np.where(contact, gap + restart * norm / old * direction, 0.0)
        old = norm
        response = periodic_displacement(direction, spacing, modulus, m)
        response -= response[contact].mean()
        step = (gap * direction)[contact].sum() / (response * direction)[contact].sum()
        pressure = np.maximum(np.where(contact, pressure - step * direction, pressure), 0.0)
        inside = (pressure == 0) & (gap < 0)
        restart = 0.0 if inside.any() else 1.0
        pressure[inside] -= step * gap[inside]
        pressure *= mean / pressure.mean()
    return pressure


def rough(shape=(60, 84), size=(1.0, 1.5), *, slope=1.0, cutoff=4.0, seed=0, periodic=True):
    """Periodic Gaussian roughness of any shape: white noise filtered to q**-1.8, slope given."""
    ny, nx = shape
    ky = np.fft.fftfreq(ny, 1.0 / ny)[:, None] / size[0]
    kx = np.fft.rfftfreq(nx, 1.0 / nx)[None, :] / size[1]
    k = np.hypot(ky, kx)
    amplitude = np.maximum(k, 4.0 / max(size)) ** -1.8
    amplitude[k > min(ny / size[0], nx / size[1]) / cutoff] = 0.0
    amplitude[0, 0] = 0.0
    noise = np.random.default_rng(seed).standard_normal(shape)
    heights = np.fft.irfft2(np.fft.rfft2(noise) * amplitude, s=shape)
    dy, dx = size[0] / ny, size[1] / nx
    gradient = np.stack([np.diff(heights, axis=0)[:, 1:] / dy, np.diff(heights, axis=1)[1:] / dx])
    heights *= slope / np.sqrt((gradient**2).sum(axis=0).mean())
    return HeightMap(heights, (dy, dx), periodic=periodic)


def random_case(seed):
    """Random map, half-space, mean pressure and boundary, for solving at any of them."""
    from asperity import HalfSpace

    rng = np.random.default_rng(1000 + seed)
    shape = tuple(int(n) for n in rng.integers(20, 180, 2))
    spacing = tuple(1e-6 * np.exp(rng.uniform(np.log(0.5), np.log(2.0), 2)))
    boundary = "periodic" if rng.random() < 0.6 else "free"
    m = float(rng.choice([0.0, 0.0, rng.uniform(-0.5, 0.8)]))
    highest = 0.5 / max(spacing)
    cutoff = highest / rng.choice([1, 1, 2, 4])
    rolloff = cutoff / rng.uniform(1.0, 30.0)
    ky = np.fft.fftfreq(shape[0], spacing[0])[:, None]
    kx = np.fft.rfftfreq(shape[1], spacing[1])[None, :]
    k = np.hypot(ky, kx)
    amplitude = np.maximum(k, rolloff) ** -(1.0 + rng.uniform(0.3, 1.0))
    amplitude[k > max(cutoff, k[1, 0], k[0, 1])] = 0.0
    amplitude[0, 0] = 0.0
    heights = np.fft.irfft2(np.fft.rfft2(rng.standard_normal(shape)) * amplitude, s=shape)
    slope = np.sqrt(
        np.mean((np.diff(heights, axis=0) / spacing[0]) ** 2)
        + np.mean((np.diff(heights, axis=1) / spacing[1]) ** 2)
    )
    wanted = rng.choice([1e-3, 0.1, 1.0])
    heights *= wanted / slope
    modulus = 1e9
    pressure = modulus * np.sqrt(spacing[0] * spacing[1]) ** m * wanted * 10 ** rng.uniform(-4, 0.6)
    body = HalfSpace.from_modulus(modulus, m)
    return HeightMap(heights, spacing), body, float(pressure), boundary
