"""The finest waves of a broad spectrum as a law of the contacts between the longer ones.

Contacts confined to basins lose their meaning where basins are as small as the contacts: on a
spectrum that spans five octaves most do at a few per cent of contact. The waves that are too short
are then taken out, the rest is solved as contacts of its own summits, and within each of these
contacts the short waves leave part of the area open and lift the flat.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.special import gamma

from surfaces._threads import blocks, run, threads
from surfaces.heightmap import HeightMap

from .fine_scales import FineScales
from .pixel_waves import fineness, random_waves

if TYPE_CHECKING:
    from .material import HalfSpace

__all__ = ["split_scales"]

Array = NDArray[np.float64]

BROADEST = 14.0
"""Breadth m0 m4 / m2^2 of the spectrum up to which basins are left as they are."""

WORTH_IT = 1.8
"""Breadth over `BROADEST` from which on the finest waves are taken out."""

UNRESOLVED = (3.0, 0.2)
"""Waves shorter than so many pixels are taken out of any spectrum in which they hold more than this
share of the squared slope: their summits are uncertain."""

NARROW = "scales: all, the spectrum is narrow enough for a contact at each summit"

POINTS = 6.0
"""Points per shortest wave that is kept: with four the load is 1 to 2 % lower at 10 to 25 % of
contact, with eight no more than 0.4 % higher."""

FEWEST = 96
"""Least points of the shorter side of the grid of the longer waves."""

LAY = (0.2, 0.87)
"""Anisotropy (s1^2 - s2^2) / (s1^2 + s2^2) of the principal slopes s1, s2 of a map (0.52 at 2:1,
0.83 at 4:1, 0.88 at 5:1): from the first on waves are told apart by their lengths along and across
the lay; above the second there is no law, as contacts of long ridges carry too much, at 5:1 up to
10 % at 25 % of contact."""

GRADED = 0.5
"""Largest |m| for which there is a law."""


def split_scales(hm: HeightMap, material: HalfSpace) -> tuple[HeightMap, FineScales] | str:
    """A map without its finest waves, on a grid that holds it well, and the law of those.

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
    parameter) reaches `BROADEST`, and none shorter than `UNRESOLVED` pixels. With lay the order and
    the breadth are those of the map stretched until its slope is the same in all directions. The
    law holds for random waves: a kurtosis of second differences far from 3 shows spikes, steps,
    worn plateaus and a border that fades.
    """
    if not hm.periodic or abs(material.m) > GRADED:
        return f"scales: all, the law of fine waves is for periodic maps and |m| <= {GRADED:g}"
    found = hm.roughness
    slope, bend = np.asarray(found.slope), np.asarray(found.curvature)
    rough = found.rms_height**2 * np.mean(bend**2) / np.mean(slope**2) ** 2
    # differences between neighbors see half the breadth of a spectrum that reaches the pixel, and
    # a quarter of the squared slope is lost over two pixels if it ends at four
    if 2.5 * rough < WORTH_IT * BROADEST and fineness(hm) < 0.25:
        return NARROW
    if not random_waves(hm):
        return "scales: all, the finest waves are not random, so that no law holds for all of them"
    waves = fft.rfft2(hm.heights, workers=threads())
    stretch = np.eye(2)
    shell, sums = _shells(waves, hm, material.m, stretch)
    lay = _lay(sums[-1])
    if lay > LAY[1]:
        return "scales: all, the waves have nearly one direction, for which there is no law"
    if lay > LAY[0]:
        stretch = _evened(sums[-1])
        shell, sums = _shells(waves, hm, material.m, stretch)
    m0, m2, m4 = sums[:, :3].T
    breadth = np.divide(1.5 * m0 * m4, m2**2, out=np.zeros(m2.size), where=m2 > 0.0)
    last = int(np.argmax(breadth > BROADEST))  # 0 if it never is
    reach = np.sqrt(np.diag(np.linalg.inv(stretch @ stretch)))  # largest qy, qx where k = 1
    most = 2.0 * np.pi / (UNRESOLVED[0] * np.max(reach * hm.spacing))
    resolved = min(int(most / shell), m2.size - 1)
    steep = sums[:, 3]
    if steep[resolved] > (1.0 - UNRESOLVED[1]) * steep[-1] and breadth[-1] < WORTH_IT * BROADEST:
        return NARROW
    last = min(last or resolved, resolved)
    limit = (last + 0.5) * shell
    coarse = _without(waves, limit, hm, stretch, 2.0 * np.pi / (shell * last * reach))
    if coarse is None:
        return "scales: all, the map is too small to take its finest waves out"
    lost = sums[-1] - sums[last]
    compliance = 2.0 ** (1.0 - material.m) * np.pi / gamma(0.5 * (1.0 + material.m)) ** 2
    stiffness = material.modulus / compliance
    return coarse, FineScales(
        shortest=2.0 * np.pi / (shell * last),
        ratio=float(lost[7] / sums[last, 7]),
        variance=float(stiffness**2 * lost[7]),
        energy=float(0.5 * stiffness * lost[6]),
        m=material.m,
        evenness=float(np.sqrt(1.0 - _lay(lost) ** 2)),
    )


def _shells(
    waves: NDArray[np.complex128], hm: HeightMap, m: float, stretch: Array
) -> tuple[float, Array]:
    """Width [1/m] of the shells of equal wave number, and their running sums (`shell_sums`).

    `stretch` is the map of (qy, qx) to the wave numbers by which they are told apart.
    """
    from ._scale_kernels import shell_sums

    qy, qx = _numbers(hm)
    width = 2.0 * np.pi / max(hm.size)
    (yy, xy), (_, xx) = stretch @ stretch
    longest = np.sqrt(
        yy * qy.min() ** 2 + 2.0 * abs(xy) * abs(qy.min()) * qx[-1] + xx * qx[-1] ** 2
    )
    count = int(longest / width + 0.5) + 1
    waves[0, 0] = 0.0
    metric = float(xx), float(xy), float(yy)

    def part(first: int, last: int) -> Array:
        out = np.zeros((count, 8))
        even = hm.shape[1] % 2 == 0
        shell_sums(waves[first:last], qy[first:last], qx, width, even, metric, m, out)
        return out

    found = np.sum(run(part, blocks(len(qy), 64)), axis=0) / hm.heights.size**2
    return width, np.cumsum(found, axis=0)


def _lay(sums: Array) -> float:
    """(s1^2 - s2^2) / (s1^2 + s2^2) of the principal slopes."""
    return float(np.hypot(sums[4], sums[5]) / sums[3])


def _evened(sums: Array) -> Array:
    """Symmetric map of (qy, qx), of determinant 1, for which the slopes have no direction."""
    square, aside, cross = sums[3:6]
    values, axes = np.linalg.eigh([[square - aside, cross], [cross, square + aside]])
    return np.asarray(axes * (np.sqrt(np.prod(values)) / values) ** 0.5 @ axes.T)


def _numbers(hm: HeightMap) -> tuple[Array, Array]:
    """Wave numbers [1/m] of the rows and columns of the real transform of a map."""
    (ny, nx), (dy, dx) = hm.shape, hm.spacing
    return 2.0 * np.pi * fft.fftfreq(ny, dy), 2.0 * np.pi * fft.rfftfreq(nx, dx)


def _without(
    waves: NDArray[np.complex128], limit: float, hm: HeightMap, stretch: Array, shortest: Array
) -> HeightMap | None:
    """The map of the waves up to the number `limit`, on a grid of `POINTS` per shortest wave.

    `shortest` are their lengths [m] along y and x.
    """
    shape = [
        fft.next_fast_len(int(np.ceil(POINTS * length / wave)), real=True)
        for length, wave in zip(hm.size, shortest, strict=True)
    ]
    if min(shape) < FEWEST:
        return None
    ny, nx = shape
    half, width = (min(ny, hm.shape[0]) - 1) // 2, (min(nx, hm.shape[1]) - 1) // 2 + 1
    rows = np.r_[0 : half + 1, hm.shape[0] - half : hm.shape[0]]
    qy, qx = _numbers(hm)
    y, x = qy[rows, None], qx[:width]
    stretched = np.hypot(*(a * y + b * x for a, b in stretch))
    held = np.zeros((ny, nx // 2 + 1), complex)
    held[np.r_[0 : half + 1, ny - half : ny], :width] = np.where(
        stretched < limit, waves[rows, :width], 0.0
    )
    # pixel centres: the coarse grid begins half a coarse pixel from the border
    y = fft.fftfreq(ny)[:, None] * (1.0 - ny / hm.shape[0]) * np.pi
    x = fft.rfftfreq(nx) * (1.0 - nx / hm.shape[1]) * np.pi
    held *= np.exp(1j * (y + x))
    heights = fft.irfft2(held, s=(ny, nx), workers=threads())
    heights *= ny * nx / hm.heights.size
    heights += hm.roughness.mean
    step = {"step": "bandpass", "shortest": float(np.sqrt(np.prod(shortest))), "to": [ny, nx]}
    return hm.replace(heights=heights, spacing=(hm.size[0] / ny, hm.size[1] / nx), step=step)
