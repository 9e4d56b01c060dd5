"""Treatment of the finest waves of a map: a finer grid, or a sub-contact law.

*Finer grid.* Summits are found on pixels, and the surface between these is interpolated. Where
waves of two to four pixels hold much of the slope, summits are missed or too low, and the load is
too low; such a map is solved on smaller pixels.

*Sub-contact law.* Separate contacts in basins no longer describe a surface whose basins are as
small as its contacts, as on a spectrum of five octaves at a few per cent of contact. The fine waves
are then taken out of the map, and the summits of the longer waves are the contacts. Within these
contacts the fine waves leave part of the area open and lift the flat (`SubContactLaw`).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from asperity.errors import ModelRangeError
from asperity.halfspace.footprint import Footprints
from asperity.parameters import Parameters
from surfaces.checks import fine_waves_random, fineness, lay
from surfaces.heightmap import HeightMap
from surfaces.peaks.peaks import flat_share
from surfaces.preparation.resampling import Resampled, coarse_map, resample

from .spectrum_shells import Shells
from .sub_contact_law import SubContactLaw

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace

__all__ = ["Split", "chosen_grid", "refined_map", "split_scales"]


EMPTY_RMS = 1e-9
"""Rms height of a finer grid, over that of the map, below which it has lost all waves."""

NARROW_SPECTRUM = "scales: all, the spectrum is narrow enough for a contact at each summit"


def refined_map(hm: HeightMap, parameters: Parameters) -> HeightMap | str | None:
    """The map on a finer grid, by Fourier interpolation, if its waves reach the pixel.

    None if its own grid resolves it, or if its tops are flat; a reason if the finer grid would have
    too many points.
    """
    waves = parameters.pixel_waves
    if fineness(hm) < waves.to_the_pixel:
        return None
    for ratio, most in waves.finer:
        if ratio**2 * math.prod(hm.shape) <= most:
            flat = flat_share(hm) >= parameters.segmentation.flat_share
            return None if flat else resample(hm, np.asarray(hm.spacing) / ratio)
    return "a finer one would hold the waves near its pixels better, but takes long"


def _solved_grid(
    hm: HeightMap, scales: str, parameters: Parameters
) -> tuple[Resampled | None, str]:
    """The map with all its waves on the coarser or finer grid to solve, None for its own grid, and
    the reason."""
    shape = f"{hm.shape[0]} x {hm.shape[1]}"
    corrections = parameters.corrections
    held = coarse_map(hm) if corrections.coarser_grid else None
    if held is not None:
        ny, nx = held.hm.shape
        return held, f"grid: {ny} x {nx} points hold the map of {shape}"
    wanted = scales == "auto" and corrections.finer_grid
    finer = refined_map(hm, parameters) if wanted else None
    if isinstance(finer, HeightMap):
        if finer.roughness.rms_height < EMPTY_RMS * hm.roughness.rms_height:
            raise ModelRangeError(
                "all heights are waves of two pixels, which tell no summits between them; use "
                "boundary elements"
            )
        return Resampled(finer, (0.0, 0.0)), (
            f"grid: {finer.shape[0]} x {finer.shape[1]} points show the summits of {shape}, whose "
            "waves reach the pixel"
        )
    return None, f"grid: {shape} points, {finer or 'as given'}"


class Split(NamedTuple):
    """A map split into its longer waves and a law of its fine waves.

    Attributes
    ----------
    coarse
        Map of the longer waves, on a coarser grid.
    law
        Law of the fine waves.
    """

    coarse: Resampled
    law: SubContactLaw


def split_scales(hm: HeightMap, material: HalfSpace, parameters: Parameters) -> Split | str:
    """Split the waves of a map, or give the reason to leave it whole.

    Notes
    -----
    The longer waves are those up to the wave number at which their Nayak parameter m0 m4 / m2^2
    reaches `breadth`; they are more if needed to have `fewest_waves` along the side of the map or
    `kept_slope` of the squared slope, and none is shorter than `unresolved_pixels`
    (`parameters.WaveSplit`). The law holds for random waves without lay. A map that is not periodic
    is taken with its mirror images.
    """
    bounds, near_pixel = parameters.wave_split, parameters.pixel_waves
    if abs(material.m) > bounds.grading:
        return f"scales: all, the law of fine waves is for |m| <= {bounds.grading:g}"
    broad = bounds.worth * bounds.breadth
    if fineness(hm) < near_pixel.to_the_pixel and _breadth(hm) < bounds.sure_breadth * broad:
        return NARROW_SPECTRUM
    if not fine_waves_random(hm, near_pixel.kurtosis):
        return "scales: all, the finest waves are not random, so that no law holds for all of them"
    if (1.0 - bounds.lay) * lay(hm) ** 2 > 1.0 + bounds.lay:
        return "scales: all, the waves have a lay, for which there is no law"
    shells = Shells.of(hm, material.m)
    m0, m2, m4 = shells.sums[:, :3].T
    breadth = np.divide(1.5 * m0 * m4, m2**2, out=np.zeros(m2.size), where=m2 > 0.0)
    last = int(np.argmax(breadth > bounds.breadth))  # 0 if it never is
    most = 2.0 * np.pi / (bounds.unresolved_pixels * max(hm.spacing))
    finest = min(int(most / shells.width + 1e-6), m2.size - 1)  # whole numbers but for rounding
    if m2[finest] > (1.0 - bounds.unresolved_slope) * m2[-1] and breadth[-1] < broad:
        return NARROW_SPECTRUM
    steep = int(np.argmax(m2 >= bounds.kept_slope * m2[-1]))
    fewest = round(bounds.fewest_waves * max(hm.size) / math.sqrt(hm.area))
    last = min(max(last or finest, fewest, steep), finest)
    law = _law(shells, last, material, parameters)
    if law is None:
        return "scales: all, the map has too few waves to take the finest out"
    coarse = shells.map(last, bounds.points)
    if coarse is None:
        return "scales: all, the map is too small to take its finest waves out"
    return Split(coarse, law)


def chosen_grid(
    hm: HeightMap, material: HalfSpace, coupled: bool, scales: str, parameters: Parameters
) -> tuple[Resampled | None, SubContactLaw | None, list[str]]:
    """The map on the grid to solve, None for its own; the law of the waves that this map leaves
    out, None if it holds them all; and the reasons."""
    if scales != "auto":
        why = "scales: all, as asked"
    elif not coupled:
        why = "scales: all, contacts do not interact"
    elif not parameters.corrections.wave_split:
        why = "scales: all, the split of waves is switched off"
    else:
        split = split_scales(hm, material, parameters)
        if isinstance(split, Split):
            (ny, nx), law = split.coarse.hm.shape, split.law
            return *split, [
                f"scales: waves shorter than {law.shortest:.3g} m act as a law of the contacts of "
                f"the others; they hold {100 * law.ratio / (1 + law.ratio):.0f} % of the squared "
                "slope",
                f"grid: {ny} x {nx} points hold the longer waves of {hm.shape[0]} x {hm.shape[1]}",
            ]
        why = split
    resampled, holds = _solved_grid(hm, scales, parameters)
    return resampled, None, [why, holds]


def _law(
    shells: Shells, last: int, material: HalfSpace, parameters: Parameters
) -> SubContactLaw | None:
    """Law of the waves beyond the shell `last`; None if they hold hardly any of the slope."""
    sums = shells.sums
    if sums[last, 1] > (1.0 - parameters.wave_split.least_slope) * sums[-1, 1]:
        return None
    lost = sums[-1] - sums[last]
    stiffness = 1.0 / Footprints(material.modulus, material.m).symbol
    return SubContactLaw(
        shortest=2.0 * np.pi / (shells.width * last),
        ratio=float(lost[4] / sums[last, 4]),
        variance=float(stiffness**2 * lost[4]),
        energy=float(0.5 * stiffness * lost[3]),
        number=float((lost[4] / lost[3]) ** (1.0 / (1.0 - material.m))),
        m=material.m,
        rms=(math.sqrt(sums[last, 0]), math.sqrt(sums[-1, 0])),
        fitted=parameters.sub_contact,
    )


def _breadth(hm: HeightMap) -> float:
    """Nayak parameter m0 m4 / m2^2 of an isotropic map, from some of its lines."""
    turns = np.zeros((2, 2))  # mean squares of slope and curvature along y and x
    for mean, power, length in zip(turns, hm.line_power, hm.size, strict=True):
        number = np.arange(power.size) * (2.0 if hm.periodic else 1.0) * np.pi / length
        mean[:] = power @ number**2, power @ number**4
    slope, bend = turns.mean(axis=0)
    return float(hm.roughness.rms_height**2 * bend / slope**2)
