"""The smooth part of the interaction on a B-spline mesh, periodic or zero-padded."""

from __future__ import annotations

import copy
import functools
import math
from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray
from scipy.special import gamma, gammainc, gammaincc

from asperity.halfspace.footprint import Footprints
from surfaces.arrays import Array
from surfaces.numerics.parallel import threads

from . import _mesh_kernels

__all__ = ["Mesh", "SmoothField", "mesh_of"]

NODES_PER_THREAD = 50_000
"""Number of wave vectors above which a transform uses several threads."""

MATRIX_NODES = 100
"""Nodes along each side up to which transforms are products of matrices: they take half the time of
the library's, and a tenth on 16 nodes. The products of longer ones would use several threads."""

LEAST_NODES = 32
"""Least number of nodes along each side of a periodic cell: errors of the mesh depend on the places
of contacts between its nodes, and do not average out over few contacts."""

HIGHEST_WAVE_NUMBER = 13.0
"""Wave number times eta beyond which the smooth part is zero (1e-18)."""


class Mesh:
    """Convolution of mesh masses with the smooth part of the half-space kernel.

    Lengths are in units of the split length eta, results in units of C_m eta^-p. The cell, or the
    extent of the points on a free half-space, is `size` (Ly, Lx). If `periodic` it repeats, and the
    kernel has zero mean over it; otherwise the kernel is that of the free half-space, on a mesh
    padded to twice the extent. There are so many `nodes` per eta; the precision of masses and
    results is float32 or float64.

    Attributes
    ----------
    shape
        Nodes (my, mx), padding included.
    waves
        Of a mesh up to `MATRIX_NODES`, what `_mesh_kernels.convolve` reads of both sides; otherwise
        empty.

    Notes
    -----
    The transfer function is the least-squares optimum for cubic B-spline deposit and gather of
    transform W: R W^2 / (sum over aliases W^2)^2, never negative, so that the mesh part is a
    positive semi-definite form but for its mean (the zero-mean kernel's constant background).
    """

    def __init__(
        self,
        footprints: Footprints,
        size: tuple[float, float],
        periodic: bool,
        nodes: float,
        precision: type,
    ) -> None:
        if periodic:
            self.shape = _lengths(*(max(LEAST_NODES, math.ceil(nodes * s)) for s in size))
            step = (size[0] / self.shape[0], size[1] / self.shape[1])
            transfer = _periodic_transfer(footprints, size, self.shape)
        else:
            self.shape = _lengths(*(2 * (math.ceil(nodes * s) + 4) for s in size))
            step = (1 / nodes, 1 / nodes)
            smooth = scipy.fft.rfft2(_free_samples(footprints, step, self.shape)).real
            across = _correction(self.shape[1])[: smooth.shape[1]]
            transfer = smooth * np.multiply.outer(_correction(self.shape[0]), across)
        self.per_step = np.array([1 / step[0], 1 / step[1]])
        self.waves: tuple[NDArray[np.floating], ...] = ()
        if max(self.shape) <= MATRIX_NODES:
            self.waves = tuple(_waves(n, precision) for n in self.shape)
            h, g = (n // 2 for n in self.shape)
            transfer = np.stack([[transfer[a : a + h, b : b + g] for a in (0, 1)] for b in (0, 1)])
        self.transfer: NDArray[np.floating] = transfer.astype(precision, copy=False)

    @functools.cached_property
    def single(self) -> Mesh:
        """The mesh in single precision."""
        mesh = copy.copy(self)
        mesh.waves = tuple(waves.astype(np.float32) for waves in self.waves)
        mesh.transfer = self.transfer.astype(np.float32)
        return mesh

    def convolve(self, masses: NDArray[np.floating]) -> NDArray[np.floating]:
        """Potential at the nodes [C_m eta^-p] of masses at the nodes, (my, mx)."""
        if self.waves:
            potential = np.empty_like(masses)
            high, wide = self.waves
            _mesh_kernels.convolve(masses, high, wide, self.transfer, potential)
            return potential
        workers = threads() if self.transfer.size > NODES_PER_THREAD else 1
        spectrum = scipy.fft.rfft2(masses, workers=workers)
        spectrum *= self.transfer
        found = scipy.fft.irfft2(spectrum, s=self.shape, overwrite_x=True, workers=workers)
        return np.asarray(found)


@dataclass(frozen=True, eq=False)
class SmoothField:
    """The smooth part of a field on its mesh, which can be evaluated at any place.

    The mesh has its corner (y, x) at `origin` [m] and extends over `size` (y, x), told in the
    length `unit` [m]; it repeats if `wrap`, and `per_step` is one over the distance of its nodes
    along y and x. The `values` at the nodes, shape (my, mx), times `scale` are displacements [m].
    """

    origin: tuple[float, float]
    unit: float
    size: tuple[float, float]
    wrap: bool
    per_step: Array
    scale: float
    values: Array

    @functools.cached_property
    def lowest(self) -> float:
        """Least displacement [m] at the nodes, at most zero."""
        return float(self.scale * min(0.0, float(self.values.min())))

    def potential(self, y: Array, x: Array) -> Array:
        """Displacement [m] at any places [m], shape (n,), without the near part.

        Near contacts add to it, so that it is a lower bound, apart from the moments. Beyond the
        mesh of a free half-space it is zero.
        """
        frame = self.origin, self.unit, self.size, self.wrap, self.per_step, self.scale
        out = np.empty(len(y))
        _mesh_kernels.sample(y, x, *frame, self.values, out)
        return out


def mesh_of(
    footprints: Footprints, size: tuple[float, float], periodic: bool, nodes: float, precision: type
) -> Mesh:
    """The `Mesh` of these arguments. That of a periodic cell is kept for later calls, that of a
    free half-space not: its extent is that of the points, which changes from list to list."""
    return (_kept if periodic else Mesh)(footprints, size, periodic, nodes, precision)


_kept = functools.lru_cache(maxsize=8)(Mesh)


@functools.lru_cache(maxsize=64)
def _waves(n: int, precision: type) -> NDArray[np.floating]:
    """Even and odd waves along n nodes, even, at the first half of them, each of norm 1 over all:
    by wave and place, and by place and wave, shape (2, 2, n / 2, n / 2)."""
    wave, place = np.arange(n // 2), np.arange(n // 2) + 0.5
    even = np.cos(2 * np.pi / n * np.multiply.outer(wave, place)) * math.sqrt(2 / n)
    odd = np.sin(2 * np.pi / n * np.multiply.outer(wave + 1, place)) * math.sqrt(2 / n)
    even[0] *= math.sqrt(0.5)
    odd[-1] *= math.sqrt(0.5)
    both = np.stack((even, odd))
    return np.stack((both, both.swapaxes(1, 2))).astype(precision)


def _lengths(*wanted: int) -> tuple[int, int]:
    if max(wanted) <= MATRIX_NODES:
        ny, nx = (n + n % 2 for n in wanted)
    else:
        ny, nx = (scipy.fft.next_fast_len(n, real=True) for n in wanted)
    return ny, nx


def _periodic_transfer(
    footprints: Footprints, size: tuple[float, float], shape: tuple[int, int]
) -> Array:
    """Lambda(q) Q((1-m)/2, q^2/4) over the area of a mesh cell, corrected for the splines; at q = 0
    minus the mean of the near part, so that the sum of both has zero mean over the cell."""
    m = footprints.m
    qy = 2 * np.pi * np.fft.fftfreq(shape[0], 1 / shape[0]) / size[0]
    qx = 2 * np.pi * np.fft.rfftfreq(shape[1], 1 / shape[1]) / size[1]
    rising = (np.square(qy)[:, None] + np.square(qx)) ** ((1 - m) / 2)
    rising[0, 0] = np.inf
    table = _smooth_share(m)
    place = rising * ((len(table) - 1) / HIGHEST_WAVE_NUMBER ** (1 - m))
    transfer = np.multiply.outer(_correction(shape[0]), _correction(shape[1])[: len(qx)])
    mean = -(0.25 ** ((1 - m) / 2)) / gamma((3 - m) / 2) * transfer[0, 0]
    transfer *= np.interp(place, np.arange(len(table)), table, right=0.0)
    transfer /= rising
    transfer[0, 0] = mean
    density = shape[0] * shape[1] / (size[0] * size[1])
    return np.asarray(transfer * (footprints.symbol / footprints.point * density))


@functools.lru_cache(maxsize=16)
def _smooth_share(m: float) -> Array:
    """Q((1-m)/2, q^2/4) at equispaced q^(1-m), to `HIGHEST_WAVE_NUMBER`, where it has vanished."""
    rising = np.linspace(0.0, HIGHEST_WAVE_NUMBER ** (1 - m), 8193)
    return np.asarray(gammaincc((1 - m) / 2, rising ** (2 / (1 - m)) / 4))


def _free_samples(
    footprints: Footprints, step: tuple[float, float], shape: tuple[int, int]
) -> Array:
    """Smooth part of the kernel at the circular distances of a padded mesh."""
    a = footprints.power / 2
    y, x = (np.arange(n // 2 + 1) * h for n, h in zip(shape, step, strict=True))
    r2 = y[:, None] ** 2 + x[None, :] ** 2
    r2[0, 0] = 1.0
    value = r2 ** (-a) * gammainc(a, r2)
    value[0, 0] = 1 / gamma(a + 1)
    rows, columns = (np.minimum(np.arange(n), n - np.arange(n)) for n in shape)
    return np.asarray(value[rows][:, columns])


@functools.lru_cache(maxsize=64)
def _correction(n: int) -> Array:
    """W^2 / (sum over aliases W^2)^2 along one axis, W = sinc^4 (cubic B-spline).

    The sum is the Fourier series of the septic B-spline at whole numbers.
    """
    f = np.fft.fftfreq(n)
    c = np.cos(2 * np.pi * f)
    alias = (2416 + 2 * (1191 * c + 120 * (2 * c**2 - 1) + (4 * c**3 - 3 * c))) / 5040
    return np.asarray(np.sinc(f) ** 8 / alias**2)
