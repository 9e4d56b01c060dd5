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

from surfaces._threads import blocks, run, threads
from surfaces.heightmap import HeightMap

from ..interaction.footprint import Footprints
from .fine_waves import FineScales
from .pixel_waves import TO_THE_PIXEL, fineness, strength

if TYPE_CHECKING:
    from ..material import HalfSpace

__all__ = ["split_scales"]

Array = NDArray[np.float64]
Waves = NDArray[np.complex128] | Array

BROADEST = 14.0
"""Breadth m0 m4 / m2^2 of the spectrum up to which basins are left as they are."""

WORTH_IT = 1.8
"""Breadth over `BROADEST` from which on the finest waves are taken out."""

SURELY_WORTH_IT = 3.0
"""The same where waves are worn down or of lay beyond 4:1: on 512 x 512 points to the pixel (1.7 to
2.7) all summits take no second and are nearer at light loads."""

UNRESOLVED = 3.0
"""Pixels below which the summits of a wave are uncertain."""

TOO_MANY = 0.2
"""Share of the squared slope in such waves from which on they are taken out of any spectrum."""

SURELY = 0.9
"""Share of that breadth up to which some lines of a map can tell that it is not reached."""

FEWEST_WAVES = 50
"""Of the shortest waves that are kept, so many fit the side of the map at least. Where few hills
carry the load, as on spectra without a roll-off, the law of the waves on each of them is rough."""

WORTH_LOSING = 0.03
"""Share of the squared slope that the finest waves hold at least, if they are taken out."""

NARROW = "scales: all, the spectrum is narrow enough for a contact at each summit"

POINTS = 6.0
"""Points per shortest wave that is kept: with four the load is 1 to 2 % lower at 10 to 25 % of
contact, with eight no more than 0.4 % higher."""

FEWEST = 96
"""Least points of the shorter side of the grid of the longer waves."""

LAY = 0.2
"""Anisotropy (s1^2 - s2^2) / (s1^2 + s2^2) of the principal slopes s1, s2 of a map (0.52 at 2:1,
0.83 at 4:1, 0.88 at 5:1) from which on waves are told apart by their lengths along and across the
lay."""

LONGEST_LAY = 0.87, 0.955
"""Anisotropy above which there is no law, and that of waves that reach the pixel along rows or
columns (0.947 to 0.954 at 8:1): contacts of long ridges carry too much, at 8:1 up to 6 % at 8 % of
contact."""

TURNED = 0.1
"""Sine of twice the angle between lay and rows or columns from which on it is turned: of 6:1 turned
by 30 degrees the area came out 10 to 14 % too large by the law."""

FINE_LAY = 0.22
"""`fineness` from which on waves with lay reach the pixel; from 0.13 to 0.21, cut off at 4 pixels,
the area came out 5 to 10 % too large by the law, by all summits 4 to 6 % too small."""

GRADED = 0.5
"""Largest |m| for which there is a law."""


def split_scales(
    hm: HeightMap, material: HalfSpace, fewest: float = FEWEST_WAVES
) -> tuple[HeightMap, FineScales] | str:
    """A map without its finest waves, on a grid that holds it well, and the law of those.

    Parameters
    ----------
    hm
        Height map without missing points.
    material
        Elastic half-space.
    fewest
        Of the shortest waves that are kept, so many fit the side of the map at least.

    Returns
    -------
    The map of the longer waves and the law of the finer ones, or the reason to leave the map whole.

    Notes
    -----
    Waves are added from the longest on until the breadth m0 m4 / m2^2 of the spectrum (Nayak's
    parameter) reaches `BROADEST`, `fewest` along the side of the map at least, and none
    shorter than `UNRESOLVED` pixels. With lay the order and the breadth are those of the map
    stretched halfway, in ratio, to the same slope in all directions: waves short enough along the
    ridges are kept to part them, as contacts of whole ridges carry too much. The law holds for
    random waves, whose strength may vary as a border fades or with the height
    (`pixel_waves.strength`). A map that is not periodic is taken with its mirror images, in which
    lay would be lost.
    """
    if abs(material.m) > GRADED:
        return f"scales: all, the law of fine waves is for |m| <= {GRADED:g}"
    if fineness(hm) < TO_THE_PIXEL and _breadth(hm) < SURELY * WORTH_IT * BROADEST:
        return NARROW
    strong = strength(hm)
    if strong is None:
        return "scales: all, the finest waves are not random, so that no law holds for all of them"
    waves = _waves(hm)
    stretch = np.eye(2)
    shell, sums = _shells(waves, hm, material.m, stretch)
    lay = _lay(sums[-1])
    if not hm.periodic and max(lay, _diagonal(hm)) > LAY:
        return "scales: all, there is a law of fine waves with lay for periodic maps only"
    straight = abs(sums[-1, 5]) < TURNED * lay * sums[-1, 3] and fineness(hm) >= FINE_LAY
    if lay > LONGEST_LAY[int(straight)]:
        return "scales: all, the waves have nearly one direction, for which there is no law"
    if lay > LAY:
        stretch = _halfway(sums[-1])
        shell, sums = _shells(waves, hm, material.m, stretch)
    m0, m2, m4 = sums[:, :3].T
    breadth = np.divide(1.5 * m0 * m4, m2**2, out=np.zeros(m2.size), where=m2 > 0.0)
    last = int(np.argmax(breadth > BROADEST))  # 0 if it never is
    reach = np.sqrt(np.diag(np.linalg.inv(stretch @ stretch)))  # largest qy, qx where k = 1
    most = 2.0 * np.pi / (UNRESOLVED * np.max(reach * hm.spacing))
    resolved = min(int(most / shell + 1e-6), m2.size - 1)  # whole numbers but for rounding
    steep = sums[:, 3]
    if steep[resolved] > (1.0 - TOO_MANY) * steep[-1] and breadth[-1] < WORTH_IT * BROADEST:
        return NARROW
    odd = strong.worn[0].size or lay > LONGEST_LAY[0]
    if odd and breadth[-1] < SURELY_WORTH_IT * BROADEST:
        return NARROW
    few = round(fewest * max(hm.size) / np.sqrt(hm.area))
    last = min(max(last or resolved, few), resolved)
    if steep[last] > (1.0 - WORTH_LOSING) * steep[-1]:
        return "scales: all, the map has too few waves to take the finest out"
    limit = (last + 0.5) * shell
    coarse = _without(waves, limit, hm, stretch, 2.0 * np.pi / (shell * last * reach))
    if coarse is None:
        return "scales: all, the map is too small to take its finest waves out"
    lost = sums[-1] - sums[last]
    stiffness = 1.0 / Footprints(material.modulus, material.m).symbol
    return coarse, FineScales(
        shortest=2.0 * np.pi / (shell * last),
        ratio=float(lost[7] / sums[last, 7]),
        variance=float(stiffness**2 * lost[7]),
        energy=float(0.5 * stiffness * lost[6]),
        number=float((lost[7] / lost[6]) ** (1.0 / (1.0 - material.m))),
        m=material.m,
        evenness=float(np.sqrt(1.0 - _lay(lost) ** 2)),
        strength=strong,
    )


def _waves(hm: HeightMap) -> Waves:
    """Transform of a periodic map, or cosines of another and its mirror images.

    Those are as if from the real transform of a map of their own: every column but the first
    stands for two.
    """
    if hm.periodic:
        return np.asarray(fft.rfft2(hm.heights, workers=threads()))
    waves = fft.dctn(hm.heights, norm="ortho", workers=threads()) * np.sqrt(hm.heights.size)
    waves[:, 1:] *= np.sqrt(0.5)
    return np.asarray(waves)


def _breadth(hm: HeightMap) -> float:
    """Breadth of the spectrum of a map whose waves have no direction, from some of its lines."""
    turns = np.zeros((2, 2))  # mean squares of slope and curvature along y and x
    for mean, power, length in zip(turns, hm.line_power, hm.size, strict=True):
        number = np.arange(power.size) * (2.0 if hm.periodic else 1.0) * np.pi / length
        mean[:] = power @ number**2, power @ number**4
    slope, bend = turns.mean(axis=0)
    return float(hm.roughness.rms_height**2 * bend / slope**2)


def _diagonal(hm: HeightMap) -> float:
    """2 <hx hy> / <hx^2 + hy^2> of a map, from some of its rows."""
    rows = np.arange(0, hm.shape[0] - 1, max(1, hm.shape[0] // 256))
    low, high = hm.heights[rows], hm.heights[rows + 1]
    along = np.diff(low, axis=1) + np.diff(high, axis=1)
    across = (high - low)[:, 1:] + (high - low)[:, :-1]
    y, x = across / hm.spacing[0], along / hm.spacing[1]
    return float(2.0 * abs(np.mean(y * x)) / np.mean(y * y + x * x))


def _shells(waves: Waves, hm: HeightMap, m: float, stretch: Array) -> tuple[float, Array]:
    """Width [1/m] of the shells of equal wave number, and their running sums (`shell_sums`).

    `stretch` is the map of (qy, qx) to the wave numbers by which they are told apart.
    """
    from ._spectrum_kernels import shell_sums

    qy, qx = _numbers(hm)
    width = 2.0 * np.pi / max(hm.size)
    (yy, xy), (_, xx) = stretch @ stretch
    highest = np.abs(qy).max()
    longest = np.sqrt(yy * highest**2 + 2.0 * abs(xy) * highest * qx[-1] + xx * qx[-1] ** 2)
    count = int(longest / width + 0.5) + 1
    waves[0, 0] = 0.0
    metric = float(xx), float(xy), float(yy)

    def part(first: int, last: int) -> Array:
        out = np.zeros((count, 8))
        even = hm.periodic and hm.shape[1] % 2 == 0
        shell_sums(waves[first:last], qy[first:last], qx, width, even, metric, m, out)
        return out

    found = np.sum(run(part, blocks(len(qy), 64)), axis=0) / hm.heights.size**2
    if not hm.periodic:
        found[:, 5] = 0.0  # mirror images have both signs of qx qy
    return width, np.cumsum(found, axis=0)


def _lay(sums: Array) -> float:
    """(s1^2 - s2^2) / (s1^2 + s2^2) of the principal slopes."""
    return float(np.hypot(sums[4], sums[5]) / sums[3])


def _halfway(sums: Array) -> Array:
    """Symmetric map of (qy, qx), of determinant 1, that brings the ratio of the principal slopes to
    its root."""
    square, aside, cross = sums[3:6]
    values, axes = np.linalg.eigh([[square - aside, cross], [cross, square + aside]])
    return np.asarray(axes * (np.sqrt(np.prod(values)) / values) ** 0.25 @ axes.T)


def _numbers(hm: HeightMap) -> tuple[Array, Array]:
    """Wave numbers [1/m] of the rows and columns of `_waves`."""
    (ny, nx), (dy, dx) = hm.shape, hm.spacing
    if not hm.periodic:
        return np.arange(float(ny)) * np.pi / hm.size[0], np.arange(float(nx)) * np.pi / hm.size[1]
    qy, qx = fft.fftfreq(ny, dy), fft.rfftfreq(nx, dx)
    return np.asarray(2.0 * np.pi * qy, float), np.asarray(2.0 * np.pi * qx, float)


def _without(
    waves: Waves, limit: float, hm: HeightMap, stretch: Array, shortest: Array
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
    held = _held(waves, limit, hm, stretch, (ny, nx))
    if hm.periodic:
        # pixel centres: the coarse grid begins half a coarse pixel from the border
        y = np.exp(1j * np.pi * (1.0 - ny / hm.shape[0]) * fft.fftfreq(ny))
        x = np.exp(1j * np.pi * (1.0 - nx / hm.shape[1]) * fft.rfftfreq(nx))
        heights = fft.irfft2(held * y[:, None] * x, s=(ny, nx), workers=threads())
        heights *= ny * nx / hm.heights.size
    else:
        held[:, 1:] *= np.sqrt(2.0)
        heights = fft.idctn(held, norm="ortho", workers=threads())
        heights *= np.sqrt(ny * nx) / hm.heights.size
    heights += hm.roughness.mean
    step = {"step": "bandpass", "shortest": float(np.sqrt(np.prod(shortest))), "to": [ny, nx]}
    return hm.replace(heights=heights, spacing=(hm.size[0] / ny, hm.size[1] / nx), step=step)


def _held(
    waves: Waves, limit: float, hm: HeightMap, stretch: Array, shape: tuple[int, int]
) -> Waves:
    """The waves up to the number `limit`, in the layout of another grid."""
    (ny, nx), (my, mx) = shape, (min(n, m) for n, m in zip(shape, hm.shape, strict=True))
    if hm.periodic:
        half, width = (my - 1) // 2, (mx - 1) // 2 + 1
        rows = np.r_[0 : half + 1, hm.shape[0] - half : hm.shape[0]]
        places, columns = np.r_[0 : half + 1, ny - half : ny], nx // 2 + 1
    else:
        rows, width = np.arange(my), mx
        places, columns = rows, nx
    qy, qx = _numbers(hm)
    y, x = qy[rows, None], qx[:width]
    stretched = sum(np.square(a * y + b * x) for a, b in stretch)
    held = np.zeros((ny, columns), complex if hm.periodic else float)
    held[places, :width] = np.where(stretched < limit**2, waves[rows, :width], 0.0)
    return np.asarray(held)
