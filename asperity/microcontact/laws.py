"""The laws by name: each has a module with `tabulate`, which makes the law table of a batch."""

from __future__ import annotations

from types import ModuleType
from typing import TYPE_CHECKING, Any

from asperity.errors import InputError
from asperity.halfspace.material import HalfSpace

if TYPE_CHECKING:
    from surfaces import Profiles

    from .law_table import LawTable

__all__ = ["LAWS", "law_module", "require_law", "tabulate"]

LAWS = ("auto", "hertz", "paper", "harmonic", "ellipse", "ritz")
"""Names of the laws, the default first."""


def require_law(law: str) -> None:
    """Refuse a name that is not that of a law."""
    if law not in LAWS:
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
