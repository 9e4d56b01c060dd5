"""Law "auto" of one contact: at every approach the law with the smaller expected error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from asperity.halfspace.material import HalfSpace
from surfaces.polar import PolarProfile, PowerSumProfile

from . import circle, ellipse
from .indentation import Indentation

__all__ = ["indent"]

Array = NDArray[np.float64]

_MEANINGLESS = 0.3
"""Relative error of the law "harmonic" from which on no answer is better: long contacts."""


def indent(
    profile: PowerSumProfile | PolarProfile,
    material: HalfSpace,
    approach: Array,
    *,
    law: str = "auto",
) -> Indentation:
    """Solution by the law with the smaller expected error; see `asperity.indent`."""
    first = ellipse.indent(profile, material, approach)
    second = circle.indent(profile, material, approach, law="harmonic")
    own = np.where(np.isfinite(first.force), first.error_estimate, np.inf)
    other = np.where(np.isfinite(second.force), second.error_estimate, np.inf)
    take = np.nan_to_num(own, nan=np.inf) <= np.nan_to_num(other, nan=np.inf)
    take |= other > _MEANINGLESS
    names = ("force", "contact_area", "radius", "stiffness", "flags", "error_estimate")
    columns = {name: np.where(take, getattr(first, name), getattr(second, name)) for name in names}
    return replace(
        first,
        law=law,
        **columns,
        contour_function=lambda phi: np.where(
            take[:, None], first.contour_function(phi), second.contour_function(phi)
        ),
        pressure_function=lambda r, phi: np.where(
            take[:, None], first.pressure_function(r, phi), second.pressure_function(r, phi)
        ),
        history_function=None,
    )
