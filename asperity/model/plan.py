"""The plan of a run: what is solved and what is left out, decided from map, material and loads."""

from __future__ import annotations

import functools
import math
import time
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from asperity.compilation import compile_ahead
from asperity.errors import InputError, ModelRangeError, SurfaceError
from asperity.halfspace.scene import (
    Boundary,
    as_pressed,
    checked_loads,
    chosen_boundary,
    expected_area_fraction,
    hardness_needed,
    model_warnings,
    require_scene,
    scene_warnings,
)
from asperity.microcontact.laws import TABULATORS
from asperity.multiscale.wave_split import chosen_grid
from asperity.parameters import DEFAULTS, Parameters, Segmentation
from surfaces.arrays import Array
from surfaces.checks import constant, lay, seam_warning
from surfaces.errors import as_choice, as_truth
from surfaces.heightmap import HeightMap, require_full
from surfaces.numerics import parallel
from surfaces.numerics.memory import require_memory
from surfaces.numerics.stored_array import BLOCK_BYTES
from surfaces.peaks.peaks import expected_peaks
from surfaces.preparation.resampling import Resampled

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.multiscale.sub_contact_law import SubContactLaw

    from .law_rows import LoadShares

__all__ = ["SCALES", "Plan", "make_plan", "peaks_above", "require_plan"]

SCALES = ("auto", "all")
"""Treatments of the finest waves of a map (`contact_curve`)."""

POINT_BYTES = 64
"""Bytes of peak memory per point of a map in memory: heights, order, labels, ancestors."""

STRIPS = 2**27
PEAK_BYTES, CONTACT_BYTES = 400, {"periodic": 1_150, "free": 1_800}
"""Bytes of memory for a map on disk: for its strips; for each summit, once to keep and once more
while summits are found; for each contact that may close (docs/development/interaction.md)."""

HEIGHTS_OVER_AREA = 4.0
"""Share of the heights that the flat may pass, over the expected area fraction."""

QUANTILE_SAMPLE = 2**16
"""Number of heights that a quantile is taken from."""


@dataclass(frozen=True)
class Plan:
    """Choices for one run of the microcontact model, each with its reason.

    Attributes
    ----------
    boundary
        "periodic" or "free".
    law
        Contact law asked for.
    interaction
        Whether contacts displace each other.
    above
        Height [m] above the mean plane below which nothing is segmented; None segments all.
    reasons
        One line for each choice.
    resampled
        The map on another grid, which is solved; None: the map itself is solved.
    sub_contact_law
        Law of the waves that the map on the other grid leaves out; None if it holds them all.
    warnings
        One line for each finding of the map checks.
    estimated
        Whether errors are estimated: not on a long lay, nor on a periodic map with a step across
        its border.
    seconds
        Time of the decisions [s].
    scene
        Map and material that the plan was made for; None: it holds for any.
    parameters
        Constants of the model.
    among
        Load shares of the whole map, if the planned map is a part of it; None: the map is whole.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> plan = asperity.make_plan(hm, steel, pressures=[1e8, 1e9], boundary="free")
    >>> plan.boundary, len(plan.reasons) > 0
    ('free', True)
    """

    boundary: Boundary
    law: str
    interaction: bool
    above: float | None
    reasons: tuple[str, ...]
    resampled: Resampled | None = field(default=None, repr=False)
    sub_contact_law: SubContactLaw | None = field(default=None, repr=False)
    warnings: tuple[str, ...] = ()
    estimated: bool = True
    seconds: float = field(default=0.0, compare=False)
    scene: tuple[HeightMap, HalfSpace] | None = field(default=None, repr=False, compare=False)
    parameters: Parameters = field(default=DEFAULTS, repr=False)
    among: LoadShares | None = field(default=None, repr=False, compare=False)

    def require_scene_of(self, hm: HeightMap, material: HalfSpace) -> None:
        """Raise `InputError` for a map or a material that the plan was not made for."""
        if self.scene is None:
            return
        planned, body = self.scene
        same = planned is hm or planned.digest == hm.digest
        if not same or body != material:
            raise InputError(
                f"the plan was made for another {'material' if same else 'map'}; make one for this "
                "with asperity.make_plan"
            )

    @property
    def whole(self) -> Plan:
        """This plan for all heights and waves of any map on its own grid."""
        plain = replace(self, above=None, resampled=None, sub_contact_law=None, among=None)
        return replace(plain, scene=None)

    def of_whole_map(self) -> Plan:
        """This plan with all heights of the map segmented."""
        kept = (why for why in self.reasons if not why.startswith("segmentation"))
        return replace(self, above=None, reasons=(*kept, "segmentation: the whole map"))

    def solved(self, hm: HeightMap) -> HeightMap:
        """The map that is solved for `hm`, the map of the plan."""
        return hm if self.resampled is None else self.resampled.hm

    def __str__(self) -> str:
        return "\n".join(self.reasons)

    __repr__ = __str__


def make_plan(
    hm: HeightMap,
    material: HalfSpace,
    *,
    pressures: ArrayLike | None = None,
    separations: ArrayLike | None = None,
    law: str = "auto",
    interaction: bool = True,
    boundary: str | None = None,
    scales: str = "auto",
    parameters: Parameters = DEFAULTS,
) -> Plan:
    """Decide what a run of `contact_curve` needs.

    Parameters
    ----------
    hm, material, pressures, separations, law, interaction, boundary, scales
        As in `contact_curve`.
    parameters
        Constants of the model, for studies of what each of them does (not those of the engines).

    Raises
    ------
    SurfaceError
        If the map has missing points or is constant, or the memory would not suffice.
    InputError
        If the load points or the parameters are not usable.
    ModelRangeError
        If m is near -1, or all heights are waves of two pixels.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> plan = asperity.make_plan(hm, steel, pressures=[1e8, 1e9])
    >>> plan.law, plan.boundary
    ('auto', 'periodic')
    """
    compile_ahead("summits")
    start = time.perf_counter()
    as_choice("scales", scales, SCALES)
    as_choice("law", law, TABULATORS)
    if not isinstance(parameters, Parameters):
        give = "give constants of the model (asperity.parameters.Parameters), none of the engines"
        raise InputError(f"parameters is of type {type(parameters).__name__}; {give}")
    require_scene(hm, material)
    # results need the digest at the end; another thread computes it now, as a solve leaves one idle
    parallel.aside(functools.partial(getattr, hm, "digest"))
    _require_usable(hm, material, parameters.limits.power)
    kind, values = checked_loads(hm, material, pressures, separations)
    edge = chosen_boundary(hm, boundary)
    cell, longest = as_pressed(hm, edge), parameters.error_estimate.longest_lay
    warnings = (*scene_warnings(cell, material), *model_warnings(cell, longest))
    estimated = lay(cell) < longest and not seam_warning(cell)
    hm = hm.without_rounding
    source = "as the map says" if boundary is None else "as asked"
    body = f"graded, m = {material.m:g}" if material.m != 0.0 else "homogeneous"
    reasons = [f"boundary: {edge} ({source})", f"material: {body}"]
    reasons.append(hardness_needed(hm, material)[0])
    coupled = as_truth("interaction", interaction)
    off = "interaction: off, as asked (the classical independent sum)"
    reasons.append("interaction: on" if coupled else off)
    resampled, fine, whys = chosen_grid(as_pressed(hm, edge), material, coupled, scales, parameters)
    solved = hm if resampled is None else resampled.hm
    points = math.prod(solved.shape)
    above, why = None, "segmentation: the whole map, which has few points"
    if points > parameters.segmentation.whole_points:
        above, why = _lowest_height(hm, material, kind, values, parameters.segmentation)
    reasons.append(why)
    reasons += whys
    reasons += [f"warning: {why}" for why in warnings]
    memory = POINT_BYTES * points + (0 if isinstance(hm.source, np.ndarray) else BLOCK_BYTES)
    if not isinstance(solved.source, np.ndarray):
        flat = _lowest_flat(hm, material, kind, values)
        found, solving = (
            PEAK_BYTES * peaks_above(hm, above),
            CONTACT_BYTES[edge] * peaks_above(hm, flat),
        )
        memory = STRIPS + found + max(found, solving)
    remedy = "take lighter loads, crop or resample the map, or raise the limit of memory (--memory)"
    require_memory(memory, f"the model of {points} points", remedy)
    about = f"memory: about {memory / 2**20:.0f} MiB"
    reasons += [about, "fields: pressure and contours are made on request only"]
    seconds = time.perf_counter() - start
    return Plan(
        boundary=edge,
        law=law,
        interaction=coupled,
        above=above,
        reasons=tuple(reasons),
        resampled=resampled,
        sub_contact_law=fine,
        warnings=warnings,
        estimated=estimated,
        seconds=seconds,
        scene=(hm, material),
        parameters=parameters,
    )


def _require_usable(hm: HeightMap, material: HalfSpace, least_power: float) -> None:
    if 1.0 + material.m < least_power:
        raise ModelRangeError(
            f"m = {material.m:g} is so near -1 that a contact displaces all others like itself, "
            "which separate contacts do not describe; use boundary elements"
        )
    require_full(hm, "the model")
    if constant(hm):
        raise SurfaceError("the map is constant: a flat map has no peaks to touch")


def require_plan(plan: object) -> None:
    """Refuse an argument `plan` that is not a `Plan`."""
    if not isinstance(plan, Plan):
        raise InputError(f"plan is a {type(plan).__name__}; make one with asperity.make_plan")


def _lowest_height(
    hm: HeightMap, material: HalfSpace, kind: str, values: np.ndarray, bounds: Segmentation
) -> tuple[float | None, str]:
    """Height [m] above the mean plane below which no summit is expected to touch, None for the
    whole map, and why."""
    whole = None, "segmentation: the whole map, the load may reach deep"
    sample = _sample(hm)
    if kind == "pressure":
        share = expected_area_fraction(hm, material, float(values.max()))
        top = bounds.spare_share + bounds.depth * share
        if top >= bounds.whole_share:
            return whole
        candidate = float(np.quantile(sample, 1.0 - top))
    else:
        highest = hm.roughness.highest - hm.roughness.mean
        candidate = min(float(values.min()), highest) - 0.5 * hm.roughness.rms_height
    top = float(np.mean(sample > candidate))
    if top >= bounds.whole_share:
        return whole
    return candidate, f"segmentation: only the top {100 * top:.0f} % of the heights"


def _lowest_flat(hm: HeightMap, material: HalfSpace, kind: str, values: np.ndarray) -> float:
    """Lowest separation [m] that the load points may reach."""
    if kind != "pressure":
        return float(values.min())
    share = HEIGHTS_OVER_AREA * expected_area_fraction(hm, material, float(values.max()))
    return float(np.quantile(_sample(hm), max(0.0, 1.0 - share)))


def peaks_above(hm: HeightMap, above: float | None) -> int:
    """Expected number of peaks above a height [m] over the mean plane; None counts all."""
    return expected_peaks(hm, -np.inf if above is None else above + hm.roughness.mean)


def _sample(hm: HeightMap) -> Array:
    """Heights [m] above the mean plane of about `QUANTILE_SAMPLE` points of the map."""
    step = max(1, int(np.sqrt(math.prod(hm.shape) / QUANTILE_SAMPLE)))
    return hm.source[::step, ::step].ravel() - hm.roughness.mean
