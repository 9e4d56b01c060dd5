"""The laws by name: each is a module with `indent` (one contact) and `tabulate` (a batch)."""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import TYPE_CHECKING, Any

from asperity.errors import InputError
from asperity.halfspace.material import HalfSpace

if TYPE_CHECKING:
    from surfaces import Profiles

    from .law_table import LawTable

__all__ = ["LAWS", "law_module", "tabulate"]

LAWS = {
    "auto": "asperity.microcontact.auto",
    "hertz": "asperity.microcontact.hertz",
    "paper": "asperity.microcontact.circle.expansion",
    "harmonic": "asperity.microcontact.circle.expansion",
    "ellipse": "asperity.microcontact.ellipse.ellipse_law",
    "ritz": "asperity.microcontact.ritz.ritz_law",
}
"""Name of each law -> module that holds ``indent(profile, material, approach, *, law)`` and
``tabulate(profiles, material, *, law, nodes)``."""


def law_module(law: str) -> ModuleType:
    """Module of the law called `law`, imported when first used."""
    if not isinstance(law, str) or law not in LAWS:
        raise InputError(f"no law is called {law!r}; the laws are {', '.join(LAWS)}")
    return importlib.import_module(LAWS[law])


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
