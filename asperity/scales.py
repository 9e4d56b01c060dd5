"""The finest waves of a broad spectrum as a law of the contacts between the longer ones.

Contacts confined to basins lose their meaning where basins are as small as the contacts: on a
spectrum that spans five octaves most do at a few per cent of contact. The waves that are too short
are then taken out, the rest is solved as contacts of its own summits, and within each of these
contacts the short waves leave part of the area open and lift the flat.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from surfaces._threads import blocks, run, threads
from surfaces.heightmap import HeightMap

if TYPE_CHECKING:
    from .material import HalfSpace

__all__ = ["FineScales", "split_scales"]

Array = NDArray[np.float64]

BROADEST = 14.0
"""Breadth m0 m4 / m2^2 of the spectrum up to which basins are left as they are."""

WORTH_IT = 1.8
"""Breadth over `BROADEST` from which on the finest waves are taken out."""

UNRESOLVED = (3.0, 0.2)
"""Waves shorter than so many pixels are taken out of any spectrum in which they hold more than this
share of the squared slope: their summits are uncertain."""

NARROW = "scales: all, the spectrum is narrow enough for a contact at each summit"

POINTS = 4.0
"""Points of the coarse grid per shortest wave that is kept."""

FEWEST = 64
"""Least points of the shorter side of the coarse grid."""

KURTOSIS = 0.25
"""How far the kurtosis of the fine heights may be from 3, that of random waves."""

ANISOTROPY = 0.2
"""Largest anisotropy (sx^2 - sy^2) / (sx^2 + sy^2) of the slopes of the fine waves."""

SPREAD = (0.50, 0.13)
"""Share of the pressure of the fine waves in full contact that spreads the pressure of a contact
about to open: the first for few fine waves, the sum where their slope is far above the others'."""

LIFT = (0.18, 5.0)
"""How far the flat is lifted over the first-order value: 1 + c (1 - A/A0)^n."""


@dataclass(frozen=True)
class FineScales:
    """Random waves too short for contacts of their own, within the contacts of the longer ones.

    Parameters
    ----------
    shortest
        Shortest wave [m] that was kept for contacts.
    ratio
        Squared slope of the fine waves over that of the longer ones.
    variance
        Variance V [Pa^2] of the pressure that presses the fine waves flat.
    energy
        Elastic energy e per area [J/m^2] of that.

    Notes
    -----
    In full contact a wave h_q has the pressure E* q h_q / 2: V = E*^2/4 <|grad h|^2> and
    e = E*/4 sum q |h_q|^2. The fine waves spread the pressures of a contact, which leave it where
    they come to zero (Persson 2001). Those of a rough contact of mean pressure p follow Rayleigh's
    distribution of scale s = sqrt(2/pi) p; of its area there remains, and per area is stored,

        A/A0 = 1 / sqrt(1 + b),   Phi = e arsinh(sqrt(b)) / sqrt(b),   b = g V / s^2,

    Phi = int u dp being the complementary energy of the local gap u. Contacts about to open spread
    less than V: g = g0 + (1 - g0) P^2, with P the share of the nominal area in contact, here the
    mean of that with and without the fine waves; Wang & Mueser (2017) have g0 = 5/9, boundary
    elements give 0.50 to 0.63 (`SPREAD`). To first order in the fine waves a load F lifts the flat
    by d(sum Phi)/dF; boundary elements give the factor 1 + c (1 - P)^n, c and n in `LIFT`. Both
    were found without microcontacts, from the pressures of solutions of the longer waves, for Hurst
    exponents 0.5 to 0.9 and one to four octaves (docs/accuracy.md).
    """

    shortest: float
    ratio: float
    variance: float
    energy: float

    @property
    def spread(self) -> float:
        """g0 [-]."""
        return SPREAD[0] + SPREAD[1] * self.ratio / (1.0 + self.ratio)

    def remaining(self, pressure: ArrayLike, share: float) -> Array:
        """Share of the area of contacts of mean pressure p [Pa] that stays closed; `share` is P."""
        return np.asarray(1.0 / np.sqrt(1.0 + self._opening(pressure, share) ** 2))

    def stored(self, pressure: ArrayLike, share: float) -> Array:
        """Complementary energy per area [J/m^2] of contacts of mean pressure p [Pa]."""
        root = self._opening(pressure, share)
        return np.asarray(self.energy * np.arcsinh(root) / root)

    def lift(self, share: float) -> float:
        """Factor over the first order of the lift where the share of area P is closed."""
        return float(1.0 + LIFT[0] * (1.0 - share) ** LIFT[1])

    def _opening(self, pressure: ArrayLike, share: float) -> Array:
        """sqrt(b)."""
        spread = self.spread + (1.0 - self.spread) * share**2
        scale = np.sqrt(2.0 / np.pi) * np.maximum(np.asarray(pressure, float), 1e-300)
        return np.asarray(np.sqrt(spread * self.variance) / scale)


def split_scales(hm: HeightMap, material: HalfSpace) -> tuple[HeightMap, FineScales] | str:
    """A map without its finest waves, on a grid that holds it, and the law of those.

    Parameters
    ----------
    hm
        Height map without missing points.
    material
        Elastic half-space.

    Returns
    -------
    The map of the longer waves and the law of the finer ones, or the reason to leave the map whole.

    Notes
    -----
    Waves are added from the longest on until the breadth m0 m4 / m2^2 of the spectrum (Nayak's
    parameter) reaches `BROADEST`, and none shorter than `UNRESOLVED` pixels. The law holds for
    random waves without direction: a kurtosis of second differences far from 3 shows spikes, steps,
    worn plateaus and a border that fades.
    """
    if not hm.periodic or material.m != 0.0:
        return "scales: all, the law of fine waves is for periodic maps on a homogeneous body"
    found = hm.roughness
    slope, bend = np.asarray(found.slope), np.asarray(found.curvature)
    rough = found.rms_height**2 * np.mean(bend**2) / np.mean(slope**2) ** 2
    fineness = np.sum((bend * hm.spacing) ** 2) / (4.0 * np.sum(slope**2))
    # differences between neighbors see half the breadth of a spectrum that reaches the pixel, and
    # a quarter of the squared slope is lost over two pixels if it ends at four
    if 2.5 * rough < WORTH_IT * BROADEST and fineness < 0.25:
        return NARROW
    if any(abs(value - 3.0) > KURTOSIS for value in _kurtosis(hm)):
        return "scales: all, the finest waves are not random, so that no law holds for all of them"
    waves = fft.rfft2(hm.heights, workers=threads())
    shell, sums = _shells(waves, hm)
    m0, energy, m2, m4, aside = np.cumsum(sums, axis=0).T
    breadth = np.divide(1.5 * m0 * m4, m2**2, out=np.zeros(m2.size), where=m2 > 0.0)
    last = int(np.argmax(breadth > BROADEST))  # 0 if it never is
    resolved = min(int(2.0 * np.pi / (UNRESOLVED[0] * max(hm.spacing)) / shell), m2.size - 1)
    if m2[resolved] > (1.0 - UNRESOLVED[1]) * m2[-1] and breadth[-1] < WORTH_IT * BROADEST:
        return NARROW
    last = min(last or resolved, resolved)
    lost = float(m2[-1] - m2[last])
    if abs(aside[-1] - aside[last]) > ANISOTROPY * lost:
        return "scales: all, the finest waves have a direction, for which there is no law"
    shortest = 2.0 * np.pi / (shell * last)
    coarse = _without(waves, (last + 0.5) * shell, hm, shortest)
    if coarse is None:
        return "scales: all, the map is too small to take its finest waves out"
    return coarse, FineScales(
        shortest=shortest,
        ratio=lost / float(m2[last]),
        variance=0.25 * material.modulus**2 * lost,
        energy=0.25 * material.modulus * float(energy[-1] - energy[last]),
    )


def _kurtosis(hm: HeightMap) -> tuple[float, float]:
    """Kurtosis of the second differences of a periodic map along y and x."""
    found = []
    for axis in (0, 1):
        lines = hm.heights if axis else hm.heights.T
        lines = lines[:: max(1, lines.shape[0] // 128)]
        bend = np.square(2.0 * lines - np.roll(lines, 1, 1) - np.roll(lines, -1, 1))
        found.append(float(np.mean(bend**2) / np.mean(bend) ** 2))
    return found[0], found[1]


def _shells(waves: NDArray[np.complex128], hm: HeightMap) -> tuple[float, Array]:
    """Width [1/m] of the shells of equal wave number, and their sums (`shell_sums`)."""
    from ._scale_kernels import shell_sums

    qy, qx = _numbers(hm)
    width = 2.0 * np.pi / max(hm.size)
    count = int(np.hypot(np.abs(qy).max(), qx.max()) / width + 0.5) + 1
    waves[0, 0] = 0.0

    def part(first: int, last: int) -> Array:
        out = np.zeros((count, 5))
        shell_sums(waves[first:last], qy[first:last], qx, width, hm.shape[1] % 2 == 0, out)
        return out

    return width, np.sum(run(part, blocks(len(qy), 64)), axis=0) / hm.heights.size**2


def _numbers(hm: HeightMap) -> tuple[Array, Array]:
    """Wave numbers [1/m] of the rows and columns of the real transform of a map."""
    (ny, nx), (dy, dx) = hm.shape, hm.spacing
    return 2.0 * np.pi * fft.fftfreq(ny, dy), 2.0 * np.pi * fft.rfftfreq(nx, dx)


def _without(
    waves: NDArray[np.complex128], limit: float, hm: HeightMap, shortest: float
) -> HeightMap | None:
    """The map of the waves up to the number `limit`, on the coarsest grid that holds it."""
    shape = [
        min(n, fft.next_fast_len(int(np.ceil(POINTS * length / shortest)), real=True))
        for n, length in zip(hm.shape, hm.size, strict=True)
    ]
    if min(shape) < FEWEST:
        return None
    ny, nx = shape
    half, width = (ny - 1) // 2, (nx - 1) // 2 + 1
    rows = np.r_[0 : half + 1, hm.shape[0] - half : hm.shape[0]]
    qy, qx = _numbers(hm)
    held = np.zeros((ny, nx // 2 + 1), complex)
    held[np.r_[0 : half + 1, ny - half : ny], :width] = np.where(
        np.hypot(qy[rows, None], qx[:width]) < limit, waves[rows, :width], 0.0
    )
    # pixel centres: the coarse grid begins half a coarse pixel from the border
    y = fft.fftfreq(ny)[:, None] * (1.0 - ny / hm.shape[0]) * np.pi
    x = fft.rfftfreq(nx) * (1.0 - nx / hm.shape[1]) * np.pi
    held *= np.exp(1j * (y + x))
    heights = fft.irfft2(held, s=(ny, nx), workers=threads())
    heights *= ny * nx / hm.heights.size
    heights += hm.roughness.mean
    step = {"step": "bandpass", "shortest": shortest, "to": [ny, nx]}
    return hm.replace(heights=heights, spacing=(hm.size[0] / ny, hm.size[1] / nx), step=step)
