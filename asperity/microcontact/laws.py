"""Contact laws by name: each has a function that makes the law table of many profiles."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from asperity.errors import InputError
from asperity.halfspace.material import HalfSpace

from . import auto, hertz
from .capped_table import capped_table
from .ellipse import batch as ellipse
from .ray_laws import tabulate_expansion, tabulate_ritz

if TYPE_CHECKING:
    from surfaces.peaks.profiles import Profiles

    from .law_table import LawTable

__all__ = ["LAWS", "elastic_table", "require_law", "tabulate"]

TABULATORS: dict[str, Callable[..., LawTable]] = {
    "auto": auto.tabulate,
    "hertz": hertz.tabulate,
    "paper": tabulate_expansion,
    "harmonic": tabulate_expansion,
    "ellipse": ellipse.tabulate,
    "ritz": tabulate_ritz,
}
"""Law table of a batch by each law, ``(profiles, material, *, law, nodes)``, the default first."""

LAWS = tuple(TABULATORS)
"""Names of the laws."""


def require_law(law: str) -> None:
    """Refuse a name that is not that of a law."""
    if not isinstance(law, str) or law not in TABULATORS:
        raise InputError(f"no law is called {law!r}; the laws are {', '.join(TABULATORS)}")


def elastic_table(
    profiles: Profiles, material: HalfSpace, *, law: str = "harmonic", **settings: Any
) -> LawTable:
    """`tabulate` without the hardness. If the half-space has one, the table holds the bearing areas
    from which `capped_table` makes the laws with the hardness."""
    require_law(law)
    table = TABULATORS[law](profiles, material, law=law, **settings)
    if material.hardness < math.inf:
        table.bearing = profiles.bearing_areas(table.approach())
    return table


def tabulate(
    profiles: Profiles, material: HalfSpace, *, law: str = "harmonic", **settings: Any
) -> LawTable:
    """Table of force, stiffness and area over the approach of all profiles.

    Parameters
    ----------
    profiles
        Batch of profiles (`surfaces.fit_profiles`).
    material
        Half-space.
    law
        Name of the law, see `LAWS`.
    settings
        Passed to the law: ``nodes``, the number of intervals of the table.
    """
    return capped_table(elastic_table(profiles, material, law=law, **settings), material)
