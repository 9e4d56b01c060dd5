"""Test bodies by name, as ``asperity indent --shape`` takes them."""

from __future__ import annotations

import inspect
from collections.abc import Callable

import numpy as np

from asperity.errors import InputError
from surfaces import PowerLawProfile, PowerSumProfile, shapes


def _ellipse(ratio: float, k: float = 1.0) -> PowerLawProfile:
    """Body of elliptic level lines; `ratio` is that of the gaps on its axes at k = 2."""
    if not 0 < ratio < np.inf:
        raise InputError("the ratio of curvatures of an ellipse must be positive and finite")
    return PowerLawProfile(k, lambda p: (np.cos(p) ** 2 + ratio * np.sin(p) ** 2) ** (k / 2))


BODIES: dict[str, Callable[..., PowerSumProfile]] = {
    "polygon:N": lambda n, k=1.0: shapes.polygon(n, k),
    "cosine:N": lambda n, k=1.0: shapes.cosine_polygon(n, k),
    "rounded:N:CORNER": lambda n, corner=0.3, k=1.0: shapes.rounded_polygon(n, k, corner=corner),
    "ellipse:RATIO": _ellipse,
    "cone": lambda: PowerLawProfile(1.0, 1.0),
    "paraboloid": lambda: PowerLawProfile(2.0, 1.0),
    "random:DEVIATION:SEED": lambda deviation, seed=0, k=1.0: shapes.random_section(
        k, deviation=deviation, seed=seed
    ),
    "convex:N:SEED": lambda n, seed=0, k=1.0: shapes.random_polygon(k, sides=n, seed=seed),
    "bent": shapes.bent_body,
}
"""Bodies by the form of their names; those that take `k` are powers of r."""


def body(text: str, k: float | None, scale: float | None) -> PowerSumProfile:
    """Test body from its name and numbers, such as ``rounded:4:0.3``.

    The name is one of the keys of `BODIES`, of which numbers that have a default may be left out;
    `k` is the exponent of r of a power, 1 if None, and `scale` the factor of the gap, 1 if None.
    """
    name, *words = text.split(":")
    forms = {form.split(":")[0]: form for form in BODIES}
    if name not in forms:
        raise InputError(f"no shape is called {name!r}; see asperity indent --help")
    labels, make = forms[name].split(":")[1:], BODIES[forms[name]]
    power = {} if k is None else {"k": k}
    if power and "k" not in inspect.signature(make).parameters:
        raise InputError(f"--k does not belong to --shape {name}")
    try:
        kinds = [int if label in ("N", "SEED") else float for label in labels[: len(words)]]
        plain = make(*(kind(w) for kind, w in zip(kinds, words, strict=True)), **power)
    except (TypeError, ValueError) as error:
        known = isinstance(error, InputError)
        form = f"write {forms[name]}" + (", N and SEED whole numbers" if labels else "")
        reason = error if known else form
        raise InputError(f"--shape {text}: {reason}") from None
    return plain if scale is None else _scaled(plain, scale)


def _scaled(body: PowerSumProfile, scale: float) -> PowerSumProfile:
    """The body with its gap multiplied by a factor."""
    if not 0 < scale < np.inf:
        raise InputError(f"--scale must be positive and finite, got {scale:g}")
    angular = [lambda phi, psi=psi: scale * psi(phi) for psi in body.angular]
    if isinstance(body, PowerLawProfile):
        return PowerLawProfile(body.k, angular[0], corners=body.corners)
    return PowerSumProfile(body.powers, angular, corners=body.corners)
