"""One rough contact, solved by the boundary-element method and certified."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import ArrayLike

from asperity.errors import InputError, cautious, warn_once
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import (
    as_pressed,
    checked_load,
    chosen_boundary,
    expected_area_fraction,
    require_scene,
    scene_warnings,
)
from surfaces.arrays import Array
from surfaces.errors import as_numbers
from surfaces.heightmap import HeightMap

from .answer import answer
from .correction import PressureOrigin
from .problem import ContactProblem
from .solution import BemSolution

__all__ = ["bem_solve"]


@cautious
def bem_solve(
    hm: HeightMap,
    material: HalfSpace,
    *,
    pressure: float | None = None,
    separation: float | None = None,
    tolerance: float = 1e-6,
    boundary: str | None = None,
    guess: BemSolution | ArrayLike | None = None,
) -> BemSolution:
    """Full boundary-element solution of a rough map against a rigid flat, without friction.

    Parameters
    ----------
    hm
        Height map without missing points; it is the elastic body (or the composite roughness of
        two bodies).
    material
        Half-space, homogeneous or graded (`modulus`, `m`); its `hardness` bounds the pressure.
    pressure
        Prescribed mean pressure [Pa], non-negative and at most the hardness; or
    separation
        prescribed separation [m]: the distance of the flat from the mean plane of the undeformed
        map. In a periodic cell without a hardness that is the mean gap, and positive.
    tolerance
        Bound on each entry of the certificate [-], 1e-12 to 1e-1.
    boundary
        "periodic" (the cell repeats) or "free" (finite punch on a half-space); by default the
        map's own `periodic` flag.
    guess
        Start: an earlier solution on the same grid, or a pressure [Pa], shape (ny, nx).

    Returns
    -------
    BemSolution
        Marked `converged = False` with a reason if the certificate missed the tolerance.

    Raises
    ------
    SurfaceError
        If the map has missing points.
    InputError
        If an argument is out of its range, or both or neither of the loads are given.

    Notes
    -----
    Solves ``p >= 0, g >= 0, p g = 0`` with ``g = u - h - min(u - h)``, ``u = K p``
    (docs/development/half_space.md); with a hardness H, ``p <= H`` too, and where ``p = H`` the gap
    may be negative: the surface has yielded by that depth. The certificate is recomputed from the
    returned pressure with the exact operator in float64.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> found = asperity.bem_solve(hm, steel, pressure=1e9)
    >>> found.converged, f"{found.pressure.mean():.3e}"
    (True, '1.000e+09')
    """
    begun = time.perf_counter()
    require_scene(hm, material)
    warnings = scene_warnings(as_pressed(hm, chosen_boundary(hm, boundary)), material)
    warn_once(warnings)
    surface, hm = hm, hm.about_mean
    kind, load = checked_load(pressure, separation, material.hardness)
    share = expected_area_fraction(hm, material, load) if kind == "pressure" else None
    problem = ContactProblem(hm, material, tolerance=tolerance, boundary=boundary, share=share)
    goal = problem.prescribed(kind, load)
    prepared = time.perf_counter()
    touches = problem.touches(goal)
    start = _given(guess, hm.shape) if touches and guess is not None else None
    coarse = problem.start(goal, start)
    middle = time.perf_counter()
    origin = PressureOrigin.PROLONGED if touches and start is None else PressureOrigin.GIVEN
    solution = problem.solve(goal, problem.tolerance, origin)
    solution.iterations += coarse.iterations if coarse else 0
    told = answer(problem, solution)
    exact, reading = problem.finest.exact, solution.reading
    level = reading.level if goal.level is None else goal.level
    found, gap = problem.finest.pressure, exact.displacement[:, : hm.shape[1]]
    held = found >= problem.finest.cap
    found /= problem.compliance
    np.minimum(found, material.hardness, out=found)  # both bounds are met to the last digit
    found[held] = material.hardness
    gap -= problem.finest.heights
    gap -= level
    if problem.unit != 1.0:
        gap *= problem.unit
    depth = np.broadcast_to(0.0, hm.shape)
    if reading.held:
        depth = np.where(held, np.maximum(-gap, 0.0), 0.0)
        gap += depth
    return BemSolution(
        surface=surface,
        pressure=found,
        gap=gap,
        plastic_depth=depth,
        certificate=reading.certificate,
        status="converged" if solution.converged else "stagnated",
        reason=solution.reason,
        fft_pairs=exact.pairs,
        seconds={
            "setup": prepared - begun,
            "coarse grids": middle - prepared,
            "fine grid": time.perf_counter() - middle,
        },
        boundary=problem.boundary,
        spacing=hm.spacing,
        settings={**problem.settings(), "warnings": warnings},
        **told,
    )


def _given(guess: BemSolution | ArrayLike, shape: tuple[int, int]) -> Array | None:
    """Pressure of a guess, checked; None if nothing is pressed there."""
    if isinstance(guess, BemSolution):
        guess = guess.pressure
    try:
        given = as_numbers("guess", guess, finite=False)
    except InputError:  # no numbers
        given = np.empty(0)
    if given.shape != shape or not np.isfinite(given).all():
        raise InputError(f"guess has shape {given.shape}; give finite pressures of shape {shape}")
    return given if (given > 0.0).any() else None
