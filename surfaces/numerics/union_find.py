"""Groups of things that are joined pair by pair (union-find), for compiled loops."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .compiled import inner

__all__ = ["root"]


@inner()
def root(parent: NDArray[np.int64], i: Any) -> Any:
    """First of the group of `i`, whose way to it is halved; it is its own parent."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i
