"""How the cases of the tests are drawn: ranges of hypothesis, random maps, bodies and contacts."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from hypothesis import strategies as st
from oracles import HertzTable

from asperity import HalfSpace
from asperity.multiscale.sub_contact_law import SubContactLaw
from asperity.parameters import DEFAULTS
from surfaces import HeightMap, self_affine

GRADINGS = st.floats(-0.8, 0.8)
"""Exponents of the grading E(z) = E z**m."""

POWERS = st.floats(0.6, 4.0)
"""Exponents of power-law bodies r**k."""

STEEL = HalfSpace.from_modulus(2e11)
FINE = SubContactLaw(
    shortest=1e-6,
    ratio=1.0,
    variance=4e18,
    energy=3e2,
    number=6e6,
    m=0.0,
    rms=(1.0, 1.0),
    fitted=DEFAULTS.sub_contact,
)


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


def broad(shape=(240, 288), seed=3, **more) -> HeightMap:
    """A spectrum that reaches the pixel, on pixels that are not square."""
    size = (shape[0] * 1.0e-6, shape[1] * 0.8e-6)
    given = {"hurst": 0.8, "rms_slope": 0.1, "rolloff": 0.25 * size[1], **more}
    return self_affine(shape, size, seed=seed, **given)


def random_population(n, cell, seed, *, modulus=1.0, m=0.0, filling=0.3, apart=False):
    """Places, heights and laws of `n` summits of random radius; basins overlap at random, or not
    if they are to lie apart (`n` a square number)."""
    rng = np.random.default_rng(seed)
    y, x = rng.uniform(0, cell[0], n), rng.uniform(0, cell[1], n)
    if apart:
        side = int(np.sqrt(n))
        rows, columns = np.divmod(np.arange(n), side)
        y, x = (
            (k + 0.5 + rng.uniform(-0.15, 0.15, n)) * size / side
            for k, size in zip((rows, columns), cell, strict=True)
        )
    spacing = np.sqrt(cell[0] * cell[1] / n)
    radius = 2.0 * spacing * rng.lognormal(0, 0.4, n)
    limit = (0.6 if apart else 1.0) * spacing * rng.uniform(0.2, 0.6, n)
    reach = limit**2 / ((1 + m) * radius)
    height = filling * spacing * rng.normal(size=n)
    return y, x, height, HertzTable(radius, reach, modulus, m)


def sampled(functions, edges, *, stretch=1.0, rays=16, nodes=17, curvature=None):
    """Profiles of ``f(r, phi)`` on rays stretched by the aspect `stretch` of the summit ellipse."""
    turn = 2 * np.pi * np.arange(rays) / rays
    root = np.sqrt(stretch)
    phi = np.mod(np.arctan2(root * np.sin(turn), np.cos(turn) / root), 2 * np.pi)
    weight = 2 * np.pi / rays / (np.cos(turn) ** 2 / stretch + np.sin(turn) ** 2 * stretch)
    t = np.linspace(0.0, 1.0, nodes)
    n = len(functions)
    edge = np.array([np.broadcast_to(e(phi) if callable(e) else e, phi.shape) for e in edges])
    r = np.where(t == 0, 1e-4, t) * edge[..., None]
    q = np.array([f(r[i], phi[:, None]) / r[i] ** 2 for i, f in enumerate(functions)])
    return SimpleNamespace(
        phi=np.tile(phi, (n, 1)),
        weight=np.tile(weight, (n, 1)),
        edge=edge,
        t=t,
        q=q,
        valid=np.ones(n, bool),
        curvature=np.ones((n, 2)) if curvature is None else np.asarray(curvature, float),
    )
