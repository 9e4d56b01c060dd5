"""The contact curve of a rough surface as the sum over its microcontacts."""

from __future__ import annotations

import dataclasses
import operator
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.compilation import CURVE, compile_ahead
from asperity.contacts.fields import contact_map, pressure_map
from asperity.contacts.spot_count import spot_count
from asperity.contacts.table import microcontacts
from asperity.halfspace.load_points import checked_loads
from asperity.interaction.population import PopulationState
from asperity.model.decomposition import Asperities
from asperity.model.map_checks import LONGEST_LAY
from asperity.model.plan import Plan, interaction_needed, make_plan
from asperity.multiscale.surface_point import FinePoint, at_separation, without_gap
from asperity.results.curve import ContactCurve
from asperity.results.stiffness import curve_stiffness
from asperity.trust.error_estimate import (
    AREA_WEIGHTS,
    CALIBRATED,
    LOAD_WEIGHTS,
    TERMS,
    estimate,
    oddness,
    weaknesses,
)
from asperity.trust.outside_model import LAWLESS, TELLS_NOTHING
from surfaces.heightmap import HeightMap

from .errors import ConvergenceError, InputError

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace

__all__ = ["ContactRun", "contact_curve", "solve_contacts"]

TOLERANCE = 5e-2
"""Bound on the residual under a load before its last Newton step, whose effect on load and area is
a tenth of it or less (docs/development/interaction.md)."""

CLOSE = 4e-3
"""The same at a separation, where no step follows."""


@dataclass(frozen=True, eq=False)
class ContactRun:
    """A contact curve with the bodies and states behind it.

    Attributes
    ----------
    curve
        The contact curve.
    bodies
        The decomposed surface.
    states
        The state of all microcontacts at each load point, in the order of the curve.

    Raises
    ------
    ConvergenceError
        If a table or a map is asked for at a load point that did not converge.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine(
    ...     (32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6
    ... )
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> run = asperity.solve_contacts(hm, steel, pressures=[1e9])
    >>> run.pressure_map().shape
    (32, 48)
    """

    curve: ContactCurve
    bodies: Asperities
    states: tuple[PopulationState, ...]

    def microcontacts(self, point: int = -1) -> NDArray[np.void]:
        """Table of the contacts that carry load at a load point, see `contacts.table`."""
        return microcontacts(self.bodies, self._state(point))

    def spots(self, point: int = -1) -> NDArray[np.void]:
        """Table of the separate spots at a load point, see `contacts.spots`."""
        from asperity.contacts.spots import spot_table

        return spot_table(self.bodies, self._state(point))

    def contact_map(self, point: int = -1) -> NDArray[np.bool_]:
        """Pixels in contact at a load point, shape (ny, nx)."""
        return contact_map(self.bodies, self._state(point))

    def pressure_map(self, point: int = -1) -> NDArray[np.float64]:
        """Pressure [Pa] of every pixel at a load point, shape (ny, nx)."""
        return pressure_map(self.bodies, self._state(point))

    def __str__(self) -> str:
        return f"{self.curve}\nsummits         {len(self.bodies.population)}"

    __repr__ = __str__

    def _state(self, point: int) -> PopulationState:
        try:
            found = self.states[operator.index(point)]
        except (IndexError, TypeError):
            raise InputError(
                f"point is {point!r}; the load points are numbered 0 to {len(self.states) - 1}"
            ) from None
        if not found.converged:
            raise ConvergenceError(f"load point {point} cannot be used: {found.reason}")
        return found


def contact_curve(
    hm: HeightMap,
    material: HalfSpace,
    *,
    pressures: ArrayLike | None = None,
    separations: ArrayLike | None = None,
    law: str = "auto",
    interaction: bool = True,
    plan: Plan | None = None,
    boundary: str | None = None,
    scales: str = "auto",
    progress: Callable[[PopulationState], object] | None = None,
    checkpoint: Callable[[ContactCurve], object] | None = None,
) -> ContactCurve:
    """Load, separation and real contact area from the sum of interacting microcontacts.

    Parameters
    ----------
    hm
        Height map without missing points.
    material
        Elastic half-space in contact with a rigid flat (composite modulus for two bodies).
    pressures
        Mean pressures [Pa], scalar or (n,), non-negative; about 0.1 % to 10 % of contact if
        neither these nor `separations` are given.
    separations
        Separations [m], scalar or (n,), in place of the pressures.
    law
        Contact law of one summit: "hertz", "paper", "harmonic", "ellipse", "ritz" or "auto". Errors
        are estimated with "auto" and "ellipse" only, and NaN with the others, as with a lay of
        10:1 and more.
    interaction
        False gives the classical sum of independent contacts; by how much its load at equal
        separation differs from that of the same contacts with interaction is told in
        `extra["interaction_difference"]`, and added to the error estimate.
    plan
        A plan made before by `make_plan`; overrides `law`, `interaction`, `boundary`, `scales`.
    boundary
        "periodic" or "free"; as the map says if None.
    scales
        "auto": of a broad random spectrum the finest waves act as a law of the contacts of the
        others (`asperity.multiscale`), and other maps whose waves reach the pixel are solved on a
        finer grid (`asperity.multiscale.pixel_waves`); "all": every summit of the map is a contact.
    progress
        Called with the state of every finished load point.
    checkpoint
        Called with the curve of the points finished so far, after each.

    Returns
    -------
    ContactCurve
        One row per load point, in the order asked.

    Raises
    ------
    SurfaceError
        If the map has missing points or is constant.
    InputError
        If an argument is not usable.

    Notes
    -----
    Each local peak is confined to its basin and carries the load of its contact law at the approach
    d_i = z_i - s - sum_j G_ij F_j (docs/development/laws.md, docs/development/interaction.md);
    contacts that touch remain separate and interact.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine(
    ...     (32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6
    ... )
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> curve = asperity.contact_curve(hm, steel, pressures=[1e8, 1e9])
    >>> bool(curve.converged.all()), bool(curve.separation[0] > curve.separation[1])
    (True, True)
    """
    compile_ahead(*CURVE)
    if plan is None:
        plan = make_plan(
            hm,
            material,
            pressures=pressures,
            separations=separations,
            law=law,
            interaction=interaction,
            boundary=boundary,
            scales=scales,
        )
    return solve_contacts(
        hm,
        material,
        plan,
        pressures=pressures,
        separations=separations,
        progress=progress,
        checkpoint=checkpoint,
    ).curve


def solve_contacts(
    hm: HeightMap,
    material: HalfSpace,
    plan: Plan | None = None,
    *,
    pressures: ArrayLike | None = None,
    separations: ArrayLike | None = None,
    progress: Callable[[PopulationState], object] | None = None,
    checkpoint: Callable[[ContactCurve], object] | None = None,
) -> ContactRun:
    """Run `contact_curve` by a plan and keep the bodies and states (for maps and tables).

    Arguments are those of `contact_curve`; without a plan one is made with its defaults.

    The points are solved from light to heavy, so that each starts from the last.  Where a contact
    came near the height below which nothing was segmented, the whole map is taken instead.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine(
    ...     (32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6
    ... )
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> run = asperity.solve_contacts(hm, steel, pressures=[1e9])
    >>> f"{run.microcontacts()['force'].sum() / run.curve.load[0]:.6f}"
    '1.000000'
    """
    compile_ahead(*CURVE)
    if plan is None:
        plan = make_plan(hm, material, pressures=pressures, separations=separations)
    elif not isinstance(plan, Plan):
        raise InputError(f"plan is a {type(plan).__name__}; make one with asperity.make_plan")
    kind, values = checked_loads(hm, material, pressures, separations)
    plan.require_scene_of(hm, material)
    bodies = Asperities.of(hm, material, plan)
    start = time.perf_counter() - sum(bodies.seconds.values())
    states: dict[int, PopulationState] = {}
    places: dict[int, FinePoint] = {}
    patches: dict[int, int] = {}
    left_out: dict[int, float] = {}
    state, coupled, lift = None, None, 0.0
    classical = not plan.interaction and interaction_needed(hm, material, kind, values)[0]

    def curve_of(points: Iterable[int]) -> ContactCurve:
        chosen = list(points)
        solving = time.perf_counter() - start - sum(bodies.seconds.values())
        return _curve(
            bodies,
            [states[i] for i in chosen],
            [places[i] for i in chosen],
            [patches[i] for i in chosen],
            [left_out[i] for i in chosen] if classical else None,
            solving,
        )

    bound, top = (TOLERANCE, float(values.max())) if kind == "pressure" else (CLOSE, None)
    for i in np.argsort(values if kind == "pressure" else -values, kind="stable").tolist():
        asked = {"mean_pressure" if kind == "pressure" else "separation": float(values[i])}
        if plan.fine is not None and kind == "separation":
            state = at_separation(bodies, float(values[i]), lift, state, bound)
        else:
            state = bodies.population.solve(**asked, state=state, tolerance=bound, heaviest=top)
        if not bodies.deep_enough(state):
            return solve_contacts(
                hm,
                material,
                dataclasses.replace(plan, above=None),
                pressures=pressures,
                separations=separations,
                progress=progress,
                checkpoint=checkpoint,
            )
        place = bodies.point(state)
        states[i], places[i] = bodies.refused(without_gap(plan, state, place), place), place
        if classical:
            coupled = bodies.coupled.solve(
                separation=state.separation, state=coupled, tolerance=CLOSE
            )
            left_out[i] = _difference(state, coupled)
        patches[i], lift = spot_count(bodies, state), places[i].separation - state.separation
        if progress is not None:
            progress(state)
        if checkpoint is not None:
            checkpoint(curve_of(states))
    return ContactRun(curve_of(sorted(states)), bodies, tuple(states[i] for i in sorted(states)))


def _difference(alone: PopulationState, coupled: PopulationState) -> float:
    """Load of independent contacts over that of coupled ones, less one; NaN if not known."""
    if not (alone.converged and coupled.converged):
        return np.nan
    if coupled.mean_pressure == 0.0:
        return np.inf if alone.mean_pressure else 0.0
    return alone.mean_pressure / coupled.mean_pressure - 1.0


def _curve(
    bodies: Asperities,
    states: Sequence[PopulationState],
    places: Sequence[FinePoint],
    patches: Sequence[int],
    left_out: Sequence[float] | None,
    solving: float,
) -> ContactCurve:
    hm, plan = bodies.hm, bodies.plan

    def column(name: str) -> NDArray[Any]:
        return np.array([getattr(state, name) for state in states])

    odd = oddness(hm)
    weak = [weaknesses(bodies, state, odd) for state in states]
    pressure = column("mean_pressure")
    area = np.array([place.contact_area for place in places])
    separation = np.array([place.separation for place in places])
    tangent = np.array([place.stiffness for place in places])
    known = 0.0 if plan.law in CALIBRATED and plan.lay < LONGEST_LAY else np.nan
    load_error = known + np.array([estimate(w, LOAD_WEIGHTS) for w in weak])
    area_error = known + np.array([estimate(w, AREA_WEIGHTS) for w in weak])
    warnings = [*plan.warnings, *bodies.warnings(separation.min())]
    tiny = sum(w["unresolved"] > TELLS_NOTHING for w in weak)
    if tiny:
        warnings.append(
            f"at {tiny} of {len(weak)} load points contacts are as small as a pixel of the map, "
            "which does not tell their loads: take smaller pixels or more load"
        )
    alone = {}
    if left_out is not None:
        alone["interaction_difference"] = np.array(left_out)
        load_error += np.abs(left_out)
    return ContactCurve(
        separation=separation,
        mean_pressure=pressure,
        load=pressure * hm.area,
        area_fraction=area / hm.area,
        contact_area=area,
        contacts=np.array(patches),
        stiffness=curve_stiffness(pressure, separation, tangent, column("converged")),
        converged=column("converged"),
        residual=column("residual"),
        error_estimate=load_error,
        model="asperity",
        seconds={**bodies.seconds, "contact": solving},
        settings={
            "law": plan.law,
            "interaction": plan.interaction,
            "boundary": plan.boundary,
            "above": plan.above,
            "shortest_wave": None if plan.fine is None else plan.fine.shortest,
            "grid": list(bodies.peaks.labels.shape),
            "modulus": bodies.material.modulus,
            "m": bodies.material.m,
            "input": hm.digest,
            "peaks": len(bodies.peaks),
            "warnings": warnings,
        },
        extra={
            "microcontacts": column("active"),
            "filled_share": column("filled_share"),
            "tangent_stiffness": tangent,
            "area_error_estimate": area_error,
            **alone,
            **{name: np.array([w[name] for w in weak]) for name in (*TERMS, *LAWLESS)},
        },
        reasons=tuple(state.reason for state in states),
    )
