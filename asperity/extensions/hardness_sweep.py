"""One surface at several hardnesses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from numpy.typing import ArrayLike

from asperity.curve import solve_loads
from asperity.errors import InputError, cautious, warn_once
from asperity.halfspace.material import HalfSpace, require_half_space
from asperity.halfspace.scene import checked_loads
from asperity.model.decomposition import Decomposition
from asperity.model.plan import make_plan
from asperity.progress import Progress, reported
from asperity.results.curve import ContactCurve
from surfaces.errors import as_numbers
from surfaces.heightmap import HeightMap

__all__ = ["hardness_sweep"]


@cautious
def hardness_sweep(
    hm: HeightMap,
    material: HalfSpace,
    hardnesses: Sequence[float],
    *,
    pressures: ArrayLike | None = None,
    separations: ArrayLike | None = None,
    progress: Progress = None,
    **choices: Any,
) -> tuple[ContactCurve, ...]:
    """Contact curves of one surface at several hardnesses.

    Parameters
    ----------
    hm, material, pressures, separations
        As in `contact_curve`; by default the loads are 0.1 % to 10 % of contact at each hardness.
    hardnesses
        Hardnesses [Pa], each positive, in any order; infinity is the elastic body.
    progress
        True for a progress bar, or a function called with the state of every finished load point.
    choices
        Further choices of `make_plan`: `law`, `interaction`, `boundary`, `scales`.

    Returns
    -------
    tuple of ContactCurve
        One for each hardness, in the order given. Those of `contact_curve`, but the map is
        segmented, and its elastic laws are made, once; warnings are those of the softest body.

    Raises
    ------
    SurfaceError
        If the map has missing points or is constant.
    InputError
        If an argument is not usable, or a load is above a hardness.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> soft, hard = asperity.hardness_sweep(hm, steel, [1e9, 8e9], pressures=[5e7])
    >>> bool(soft.area_fraction[0] > hard.area_fraction[0])
    True
    """
    require_half_space(material)
    given = as_numbers("hardnesses", hardnesses, finite=False).ravel().tolist()
    elastic = material.modulus, material.m
    bodies = [HalfSpace.from_modulus(*elastic, hardness=hardness) for hardness in given]
    if not bodies:
        raise InputError("give at least one hardness")
    loads: dict[str, Any] = {"pressures": pressures, "separations": separations}
    softest = min(bodies, key=lambda body: body.hardness)
    plan = make_plan(hm, softest, **loads, **choices)
    warn_once(plan.warnings)
    base = Decomposition.of(hm.without_rounding, softest, plan)
    count = len(bodies) * len(checked_loads(hm, softest, **loads)[1])
    curves = []
    with reported(progress, count, "load points") as tell:
        for body in bodies:
            made = base.of_hardness(body)
            curves.append(
                solve_loads(hm, body, made.plan, **loads, decomposition=made, progress=tell)[0]
            )
    return tuple(curves)
