"""Contact laws by name: each is a module whose `tabulate` makes the law table of many profiles."""

from __future__ import annotations

import math
from types import ModuleType
from typing import TYPE_CHECKING, Any

from asperity.errors import InputError
from asperity.halfspace.material import HalfSpace

from .capped_table import capped_table

if TYPE_CHECKING:
    from surfaces.peaks.profiles import Profiles

    from .law_table import LawTable

__all__ = ["LAWS", "elastic_table", "law_module", "require_law", "tabulate"]

LAWS = ("auto", "hertz", "paper", "harmonic", "ellipse", "ritz")
"""Names of the laws, the default first."""


def require_law(law: str) -> None:
    """Refuse a name that is not that of a law."""
    if not isinstance(law, str) or law not in LAWS:
        raise InputError(f"no law is called {law!r}; the laws are {', '.join(LAWS)}")


def law_module(law: str) -> ModuleType:
    """Module of the law called `law`, imported when first used, with
    ``tabulate(profiles, material, *, law, nodes)``."""
    require_law(law)
    match law:
        case "hertz":
            from . import hertz

            return hertz
        case "paper" | "harmonic":
            from . import circle

            return circle
        case "ellipse":
            from .ellipse import batch

            return batch
        case "ritz":
            from . import ritz

            return ritz
    from . import auto

    return auto


def elastic_table(
    profiles: Profiles, material: HalfSpace, *, law: str = "harmonic", **settings: Any
) -> LawTable:
    """`tabulate` without the hardness. If the half-space has one, the table holds the bearing areas
    from which `capped_table` makes the laws with the hardness."""
    table: LawTable = law_module(law).tabulate(profiles, material, law=law, **settings)
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
