"""Expected relative error of the expansions, from the difference of their orders."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["expected_error"]

Array = NDArray[np.float64]

_FIRST, _QUADRATIC, _CUBIC, _OPERATORS = 1.4, 11.0, 1.0, 1.0
"""Factors of x, x^2, x^(3/2) and of the difference between both second orders."""


def expected_error(first: Array, resolved: Array, published: Array, law: str) -> Array:
    """Relative error of the force to be expected of the law "paper" or "harmonic".

    Parameters
    ----------
    first
        First-order force [N].
    resolved, published
        Second-order force F2 [N] with the operator of each harmonic, and with that of n = 2.
    law
        "paper" leaves F2 out; "harmonic" leaves out what follows it.

    Notes
    -----
    With x = F2/F: 1.4 x + 11 x^2 for "paper", x^(3/2) + 11 x^2 + |difference of the two F2| / F
    for "harmonic". The forms are those of the next orders; the factors cover 95 % of the
    boundary-element errors of polygonal, rounded, irregular and elliptic bodies and of summits of
    rough maps, and are judged on others (`docs/development/laws.md`).
    """
    total = first + resolved
    safe = np.where(total > 0, total, 1.0)
    x = np.where(total > 0, resolved / safe, 0.0)
    if law == "paper":
        return np.asarray(_FIRST * x + _QUADRATIC * x * x)
    difference = np.where(total > 0, np.abs(resolved - published) / safe, 0.0)
    return np.asarray(_CUBIC * x**1.5 + _QUADRATIC * x * x + _OPERATORS * difference)
