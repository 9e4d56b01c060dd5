"""One profile by several laws and by boundary elements: errors, run times, picture."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from asperity.errors import ModelRangeError
from asperity.halfspace.material import HalfSpace
from asperity.microcontact.laws import LAWS
from asperity.microcontact.single.indent import indent
from asperity.microcontact.single.indentation import Indentation
from surfaces.arrays import Array
from surfaces.polar import PolarProfile, PowerLawProfile, PowerSumProfile

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from asperity.bem.single import BemIndentation

__all__ = ["LawComparison", "LawRow", "compare_laws", "draw_laws"]


_ANGLES = 2 * np.pi * np.arange(360) / 360
"""Angles [rad] at which contours are compared."""

_EVERY = tuple(law for law in LAWS if law != "auto")


@dataclass(frozen=True, eq=False)
class LawRow:
    """One law on one contact; errors [-] are relative to the boundary elements, NaN without them.

    Where the law does not hold, the solution is None and `reason` says why. The errors of force
    (e_F), contour (e_a, root mean square over the angle, relative to the mean radius) and area
    (e_A) are at the same approach, or at the same load (Popov, Li &
    Willert 2023, equations 44, 45); that of the force is
    zero at the same load, and that of the approach (e_d) at the same approach. The run time [s]
    includes the contour.
    """

    law: str
    solution: Indentation | None
    reason: str = ""
    force_error: float = np.nan
    contour_error: float = np.nan
    area_error: float = np.nan
    approach_error: float = np.nan
    seconds: float = np.nan


@dataclass(frozen=True, eq=False)
class LawComparison:
    """One profile at one approach, or one `load` [N], by all laws, beside the boundary elements."""

    material: HalfSpace
    load: float | None
    rows: tuple[LawRow, ...]
    reference: BemIndentation | None = None
    reference_seconds: float = np.nan

    def row(self, law: str) -> LawRow:
        """Row of the law called `law`."""
        return next(row for row in self.rows if row.law == law)

    def table(self) -> str:
        """Text table: one line per law, the boundary elements last."""
        by_load = self.load is not None
        driven, error = ("approach [m]", "e_d %") if by_load else ("force [N]", "e_F %")
        head = ("law", driven, "area [m^2]", error, "e_a %", "e_A %", "estimate %", "ms")
        lines = ["  ".join(f"{h:>12}" for h in head)]
        for row in self.rows:
            one = row.solution
            if one is None:
                lines.append(f"{row.law:>12}  {row.reason}")
                continue
            first = row.approach_error if by_load else row.force_error
            values = [float(one.approach if by_load else one.force), float(one.contact_area)]
            errors = [first, row.contour_error, row.area_error]
            judged = _cells(errors, 100, ".3f") if self.reference else 3 * [" " * 12]
            cells = [*_cells(values, 1, ".5g"), *judged]
            cells += _cells([float(one.error_estimate)], 100, ".3f")
            cells += _cells([row.seconds], 1e3, ".2f")
            lines.append("  ".join([f"{row.law:>12}", *cells, one.flag_names()]).rstrip())
        if self.reference is not None:
            found = self.reference.approach if by_load else self.reference.force
            cells = _cells([float(found), self.reference.contact_area], 1, ".5g")
            cells += 4 * [" " * 12] + _cells([self.reference_seconds], 1e3, ".2f")
            state = "" if self.reference.converged else "not converged"
            lines.append("  ".join([f"{'bem':>12}", *cells, state]).rstrip())
        if np.isfinite(self.material.hardness):
            lines += self._yielding()
        return "\n".join(lines)

    def _yielding(self) -> list[str]:
        """Lines on the yielding of the contact, by the law with the smallest expected error."""
        solved = [row.solution for row in self.rows if row.solution is not None]
        if not solved:
            return []
        best = min(solved, key=lambda one: np.nan_to_num(float(one.error_estimate), nan=np.inf))
        lines = [f"{100 * float(best.saturated):.3g} % of the area at the hardness ({best.law})"]
        for name, words in (("first_yield", "first yield"), ("fully_plastic", "fully plastic")):
            depth, force = getattr(best, name)
            where = f"at d = {depth:.5g} m, F = {force:.5g} N" if np.isfinite(depth) else "nowhere"
            lines.append(f"{words} {where if depth else 'from the first touch'}")
        return lines


def _cells(values: Sequence[float], factor: float, form: str) -> list[str]:
    return [f"{format(factor * float(value), form):>12}" for value in values]


def compare_laws(
    profile: PowerSumProfile | PolarProfile,
    material: HalfSpace,
    approach: float | None = None,
    *,
    load: float | None = None,
    laws: tuple[str, ...] = (),
    grid: int | None = 256,
    tolerance: float = 1e-6,
) -> LawComparison:
    """Solve one contact by the laws, and by boundary elements on `grid` points per axis unless that
    is None.

    The contact is that of `asperity.indent`; all are compared at the same approach, or load.
    Without `laws` it is all but "auto", which is one of them.
    """
    reference, seconds, edge = None, np.nan, np.empty(0)
    driven = {"approach": approach, "load": load}
    if grid is not None:
        from asperity.bem.single import indent_bem

        start = time.perf_counter()
        reference = indent_bem(profile, material, **driven, grid=grid, tolerance=tolerance)
        seconds = time.perf_counter() - start
        edge = reference.contour(_ANGLES)
    if {"ellipse", "auto"} & set(laws or _EVERY):
        # its tables of one grading are made once per process: no part of the time of a contact
        indent(PowerLawProfile(2.0, 1.0), material, 1.0, law="ellipse")
    rows = tuple(_row(law, profile, material, driven, reference, edge) for law in laws or _EVERY)
    return LawComparison(material, load, rows, reference, seconds)


def _row(
    law: str,
    profile: PowerSumProfile | PolarProfile,
    material: HalfSpace,
    driven: dict[str, float | None],
    reference: BemIndentation | None,
    edge: Array,
) -> LawRow:
    start = time.perf_counter()
    try:
        one = indent(profile, material, law=law, **driven)
        contour = one.contour(_ANGLES)
    except ModelRangeError as error:
        return LawRow(law, None, str(error))
    seconds = time.perf_counter() - start
    if reference is None:
        return LawRow(law, one, seconds=seconds)
    spread = np.sqrt(np.mean((contour - edge) ** 2)) / np.mean(contour)
    return LawRow(
        law,
        one,
        force_error=float(one.force / reference.force - 1),
        contour_error=float(spread),
        area_error=float(one.contact_area / reference.contact_area - 1),
        approach_error=float(one.approach / reference.approach - 1),
        seconds=seconds,
    )


def draw_laws(compared: LawComparison, *, title: str) -> Figure:
    """Contours of the laws over the boundary-element contact, and pressure along three rays."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.5, 4.4), layout="constrained")
    plan, rays = figure.subplots(1, 2)
    phi = np.linspace(0, 2 * np.pi, 361)
    if compared.reference is not None:
        _draw_reference(compared.reference, plan)
    for row in compared.rows:
        if row.solution is not None:
            edge = row.solution.contour(phi)
            plan.plot(edge * np.cos(phi), edge * np.sin(phi), lw=1.2, label=row.law)
    plan.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title=title or "contact boundary")
    drawn = plan.get_legend_handles_labels()  # none where no law has a solution
    plan.legend(*drawn, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=4)
    _draw_rays(compared, rays)
    return figure


def _draw_reference(reference: BemIndentation, axes) -> None:  # type: ignore[no-untyped-def]
    """Contact of the boundary elements, filled."""
    for outline in reference.solutions[-1].outlines():
        x, y = (outline - reference.summit[-1]).T
        axes.fill(x, y, color="0.85", lw=0, label=None)
    axes.fill([], [], color="0.85", label="boundary elements")


def _draw_rays(compared: LawComparison, axes) -> None:  # type: ignore[no-untyped-def]
    """Pressure along 0, 30 and 45 degrees: laws as lines, boundary elements as dots."""
    solved = [(row.law, row.solution) for row in compared.rows if row.solution is not None]
    shown = [
        (law, one)
        for law, one in solved
        if law in ("paper", "harmonic") and np.isfinite(one.radius)
    ]
    longest = max((float(one.contour(0.0)) for _, one in shown), default=0.0)
    if longest == 0.0:
        axes.set_axis_off()
        return
    for degrees, color in ((0, "C0"), (30, "C1"), (45, "C2")):
        angle = np.radians(degrees)
        r = np.linspace(0.01, 1.6, 160) * longest
        x, y = r * np.cos(angle), r * np.sin(angle)
        for (law, one), style in zip(shown, ("--", "-"), strict=False):
            scale = float(one.force / (np.pi * one.radius**2))
            label = f"{law}, {degrees} deg"
            axes.plot(r, one.pressure(x, y) / scale, style, color=color, lw=1.1, label=label)
        if compared.reference is not None:
            dots = compared.reference.pressure(x, y) / scale
            axes.plot(r[::4], dots[::4], "o", color=color, ms=2.5)
    axes.set(xlabel="r [m]", ylabel="pressure / mean pressure", title="pressure along rays")
    axes.set_ylim(0, 5)
    axes.legend(fontsize=7)
