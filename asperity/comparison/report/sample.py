"""What a results file tells of one sample: its curves, and what else is there."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asperity.comparison.record import ComparisonRecord
from asperity.errors import InputError
from asperity.results.curve import ContactCurve, read_results
from surfaces.drawing import with_unit

__all__ = ["Sample", "named_apart", "read_sample"]

NAMES = {
    "asperity": "microcontacts",
    "anchored": "microcontacts, anchored",
    "bem": "boundary elements",
    "elastic": "microcontacts without hardness",
}
"""Names of the curves of a results file for a reader."""


@dataclass(frozen=True)
class Sample:
    """One sample of a report.

    Its curves go by their names for a reader, the answer first; the facts `about` map, material and
    run lack what its file lacks; the comparison is there where there is one, and `file` is the name
    of its file without suffix.
    """

    name: str
    curves: Mapping[str, ContactCurve]
    about: Mapping[str, Any]
    comparison: ComparisonRecord | None = None
    file: str = ""

    @classmethod
    def of_comparison(cls, comparison: ComparisonRecord, file: str = "") -> Sample:
        """The sample of a comparison."""
        curves = comparison.to_results().curves
        name = str(comparison.about.get("name") or file or "sample")
        return cls(name, _named(curves), comparison.about, comparison, file)

    @property
    def curve(self) -> ContactCurve:
        """The answer: the curve that the report is about."""
        return next(iter(self.curves.values()))

    def verdict(self) -> str:
        """What a reader wants to know first."""
        if self.comparison is not None:
            return self.comparison.verdict()
        return curve_verdict(next(iter(self.curves)), self.curve)


def read_sample(path: str | os.PathLike[str]) -> Sample:
    """The sample of a results file of any command; refused if the file cannot be read, or holds no
    curve."""
    held = read_results(path)
    stem = Path(path).stem
    if "comparison" in held.tables:
        return Sample.of_comparison(ComparisonRecord.from_results(held, path), stem)
    if not held.curves:
        raise InputError(f"{path} holds no curve to report; make one with asperity solve")
    # of `solve`, the boundary elements are the means and the other curve the answer
    curves = dict(sorted(held.curves.items(), key=lambda one: one[0] == "bem"))
    first = next(iter(curves.values()))
    facts = {**first.settings, **first.settings.get("map", {}), **held.about.get("request", {})}
    name = str(facts.get("name") or stem)
    return Sample(name, _named(curves), {**facts, **held.about}, file=stem)


def named_apart(samples: Sequence[Sample]) -> list[Sample]:
    """The samples with names that differ: with that of its file, or a number, where needed."""
    names = [one.name for one in samples]
    files = [f"{one.name}, {one.file}" for one in samples]
    found = []
    for i, one in enumerate(samples):
        name = one.name
        if names.count(name) > 1:
            name = files[i] if files.count(files[i]) == 1 else f"{files[i]} ({i + 1})"
        found.append(dataclasses.replace(one, name=name))
    return found


def curve_verdict(name: str, curve: ContactCurve) -> str:
    """What one curve tells, in two or three sentences."""
    points = np.flatnonzero(curve.converged & (curve.mean_pressure > 0.0))
    if not points.size:
        return f"No load point of the curve ({name}) converged under load."
    order = points[np.argsort(curve.mean_pressure[points])]

    def span(values: Any, unit: str, scale: float = 1.0) -> str:
        ends = [float(values[i]) * scale for i in order[[0, -1]][: len(order)]]
        return " to ".join(f"{v:.3g} %" if unit == "%" else with_unit(v, unit) for v in ends)

    loads, places = "mean pressures", "separations"
    if len(order) == 1:
        loads, places = "a mean pressure", "a separation"
    text = (
        f"At {loads} of {span(curve.mean_pressure, 'Pa')}, "
        f"{span(curve.area_fraction, '%', 100.0)} of the nominal area touches, at {places} of "
        f"{span(curve.separation, 'm')} ({name}). "
    )
    worst = np.nanmax(np.append(curve.error_estimate[order], -np.inf))
    if np.isfinite(worst):
        grid = " on this grid" if curve.model == "bem" else ""
        text += f"The stated error of the load{grid} is at most {100 * worst:.2g} %. "
    verified = curve.verification
    if verified is not None:
        load, area = (f"{100 * share:.3g} %" for share in verified["accuracy"])
        met = "is met" if verified["met"] else "is NOT met"
        text += f"The accuracy asked for, {load} in load and {area} in area, {met}. "
    bad = len(curve) - int(np.count_nonzero(curve.converged))
    if bad:
        text += f"{bad} of {len(curve)} load points did not converge."
    return text.rstrip()


def _named(curves: Mapping[str, ContactCurve]) -> dict[str, ContactCurve]:
    return {NAMES.get(name, name): curve for name, curve in curves.items()}
