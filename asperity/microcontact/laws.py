"""The laws by name: each is a module with `indent` (one contact) and `tabulate` (a batch)."""

from __future__ import annotations

from types import ModuleType
from typing import TYPE_CHECKING, Any

from asperity.errors import InputError
from asperity.halfspace.material import HalfSpace

if TYPE_CHECKING:
    from surfaces import Profiles

    from .law_table import LawTable

__all__ = ["LAWS", "law_module", "tabulate"]

LAWS = ("auto", "hertz", "paper", "harmonic", "ellipse", "ritz")
"""Names of the laws, the default first."""


def law_module(law: str) -> ModuleType:
    """Module of the law called `law`, imported when first used.

    It holds ``indent(profile, material, approach, *, law)`` and
    ``tabulate(profiles, material, *, law, nodes)``.
    """
    match law:
        case "auto":
            from . import auto

            return auto
        case "hertz":
            from . import hertz

            return hertz
        case "paper" | "harmonic":
            from .circle import expansion

            return expansion
        case "ellipse":
            from .ellipse import ellipse_law

            return ellipse_law
        case "ritz":
            from .ritz import ritz_law

            return ritz_law
    raise InputError(f"no law is called {law!r}; the laws are {', '.join(LAWS)}")


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
    table: LawTable = law_module(law).tabulate(profiles, material, law=law, **settings)
    return table
