"""Kinds of arrays, by short names."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["Array", "Index", "Mask"]

Array = NDArray[np.float64]
"""Numbers."""

Index = NDArray[np.int64]
"""Whole numbers: places in arrays, or counts."""

Mask = NDArray[np.bool_]
"""Which of several."""
