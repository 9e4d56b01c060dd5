"""Law "auto": for every contact the law that measured validity favours.

The expansion about the optimal ellipse is the most accurate wherever a polynomial describes the
summit inside the contact, at any ratio of curvatures and any filling of the basin. A sharp tip (a
cone, a pyramid) is no polynomial: there the harmonic-resolved law takes over, approach by
approach.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.indentation import Indentation
from asperity.material import HalfSpace
from surfaces.polar import PolarProfile, PowerSumProfile

from . import ellipse, expansion
from .table import LawTable

if TYPE_CHECKING:
    from surfaces import Profiles

__all__ = ["indent", "tabulate"]

Array = NDArray[np.float64]


def indent(
    profile: PowerSumProfile | PolarProfile,
    material: HalfSpace,
    approach: Array,
    *,
    law: str = "auto",
) -> Indentation:
    """Solution by the law with the smaller expected error; see `asperity.indent`."""
    first = ellipse.indent(profile, material, approach)
    second = expansion.indent(profile, material, approach, law="harmonic")
    own = np.where(np.isfinite(first.force), first.error_estimate, np.inf)
    other = np.where(np.isfinite(second.force), second.error_estimate, np.inf)
    take = np.nan_to_num(own, nan=np.inf) <= np.nan_to_num(other, nan=np.inf)
    rows = take.reshape(-1, 1)
    names = ("force", "contact_area", "radius", "stiffness", "flags", "error_estimate")
    columns = {name: np.where(take, getattr(first, name), getattr(second, name)) for name in names}
    return replace(
        first,
        law=law,
        **columns,
        contour_function=lambda phi: np.where(
            rows, first.contour_function(phi), second.contour_function(phi)
        ),
        pressure_function=lambda r, phi: np.where(
            rows, first.pressure_function(r, phi), second.pressure_function(r, phi)
        ),
        history_function=None,
    )


def tabulate(
    profiles: Profiles, material: HalfSpace, *, law: str = "auto", nodes: int = 32
) -> LawTable:
    """Law table of a batch: the ellipse law, which holds every sampled summit to its basin.

    Sampled summits are smooth on the scale of their pixels, so that none needs another law; the
    flags and the spread of the table say where the expansion was left.
    """
    return replace(ellipse.tabulate(profiles, material, nodes=nodes), law=law)
