"""What a table with a row for each curve tells of one."""

from __future__ import annotations

from typing import Any

import numpy as np

from .curve import ContactCurve

__all__ = ["at_heaviest"]

COLUMNS = (
    "mean_pressure",
    "area_fraction",
    "separation",
    "mean_contact_pressure",
    "contacts",
    "error_estimate",
    "stiffness",
)
"""Columns of a curve whose values at the heaviest point that converged are told."""


def at_heaviest(curve: ContactCurve) -> dict[str, Any]:
    """Values at the heaviest load point that converged, and whether and why others did not, of a
    curve of at least one load point."""
    heaviest = np.argmax(np.where(curve.converged, curve.mean_pressure, -np.inf))
    columns = curve.columns()
    return {
        **{name: columns[name][heaviest] for name in COLUMNS},
        "converged": bool(curve.converged.all()),
        "points": len(curve),
        "reason": next(filter(None, curve.reasons), ""),
    }
