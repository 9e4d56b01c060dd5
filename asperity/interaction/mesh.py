"""The smooth part of the interaction on a B-spline mesh, periodic or zero-padded."""

from __future__ import annotations

import math

import numpy as np
import scipy.fft
from numpy.typing import NDArray
from scipy.special import gamma, gammainc, gammaincc

from .footprint import Footprints

__all__ = ["Mesh"]


class Mesh:
    """Convolution of mesh masses with the smooth part of the half-space kernel.

    Lengths are in units of the split length eta, results in units of C_m eta^-p.

    Parameters
    ----------
    footprints
        Kernel of the half-space.
    size
        Cell, or extent of the points on a free half-space, (Ly, Lx) [eta].
    periodic
        Whether the cell repeats. Then the kernel has zero mean over the cell; otherwise it is that
        of the free half-space, on a mesh padded to twice the extent.
    nodes
        Mesh nodes per eta.

    Notes
    -----
    The transfer function is the least-squares optimum for cubic B-spline deposit and gather of
    transform W: R W^2 / (sum over aliases W^2)^2, never negative, so that the mesh part is a
    positive semi-definite form but for its mean (the zero-mean kernel's constant background).
    """

    def __init__(
        self, footprints: Footprints, size: tuple[float, float], *, periodic: bool, nodes: float
    ) -> None:
        if periodic:
            self.shape = _lengths(tuple(max(8, math.ceil(nodes * s)) for s in size))
            step = (size[0] / self.shape[0], size[1] / self.shape[1])
            smooth = _periodic_symbol(footprints, size, self.shape) / (step[0] * step[1])
        else:
            self.shape = _lengths(tuple(2 * (math.ceil(nodes * s) + 4) for s in size))
            step = (1 / nodes, 1 / nodes)
            smooth = scipy.fft.rfft2(_free_samples(footprints, step, self.shape)).real
        self.per_step = np.array([1 / step[0], 1 / step[1]])
        correction = np.multiply.outer(_correction(self.shape[0]), _correction(self.shape[1]))
        self.transfer = smooth * correction[:, : self.shape[1] // 2 + 1]
        self.transfer32 = self.transfer.astype(np.float32)

    def convolve(self, masses: NDArray[np.floating]) -> NDArray[np.floating]:
        """Potential at the nodes [C_m eta^-p] of masses at the nodes, in their precision."""
        transfer = self.transfer if masses.dtype == np.float64 else self.transfer32
        spectrum = scipy.fft.rfft2(masses)
        spectrum *= transfer
        return np.asarray(scipy.fft.irfft2(spectrum, s=self.shape, overwrite_x=True))


def _lengths(wanted: tuple[int, ...]) -> tuple[int, int]:
    ny, nx = (scipy.fft.next_fast_len(n, real=True) for n in wanted)
    return ny, nx


def _periodic_symbol(
    footprints: Footprints, size: tuple[float, float], shape: tuple[int, int]
) -> NDArray[np.float64]:
    """Lambda(q) Q((1-m)/2, q^2/4); at q = 0 minus the mean of the near part, so that the sum of
    both has zero mean over the cell."""
    m = footprints.m
    qy = 2 * np.pi * np.fft.fftfreq(shape[0], 1 / shape[0]) / size[0]
    qx = 2 * np.pi * np.fft.rfftfreq(shape[1], 1 / shape[1]) / size[1]
    q2 = qy[:, None] ** 2 + qx[None, :] ** 2
    q2[0, 0] = 1.0
    symbol = q2 ** ((m - 1) / 2) * gammaincc((1 - m) / 2, q2 / 4)
    symbol[0, 0] = -(0.25 ** ((1 - m) / 2)) / gamma((3 - m) / 2)
    return np.asarray(symbol * (footprints.symbol / footprints.point))


def _free_samples(
    footprints: Footprints, step: tuple[float, float], shape: tuple[int, int]
) -> NDArray[np.float64]:
    """Smooth part of the kernel at the circular distances of a padded mesh."""
    a = footprints.power / 2
    y, x = (np.arange(n // 2 + 1) * h for n, h in zip(shape, step, strict=True))
    r2 = y[:, None] ** 2 + x[None, :] ** 2
    r2[0, 0] = 1.0
    value = r2 ** (-a) * gammainc(a, r2)
    value[0, 0] = 1 / gamma(a + 1)
    rows, columns = (np.minimum(np.arange(n), n - np.arange(n)) for n in shape)
    return np.asarray(value[rows][:, columns])


def _correction(n: int) -> NDArray[np.float64]:
    """W^2 / (sum over aliases W^2)^2 along one axis, W = sinc^4 (cubic B-spline)."""
    f = np.fft.fftfreq(n)
    alias = sum(np.sinc(f + k) ** 8 for k in range(-4, 5))
    return np.asarray(np.sinc(f) ** 8 / alias**2)
