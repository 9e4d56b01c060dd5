"""A map rough to the pixel, and loads on it."""

from __future__ import annotations

import numpy as np
import pytest
from strategies import STEEL, broad

from asperity.halfspace.scene import pressure_scale
from surfaces import HeightMap


@pytest.fixture(scope="module")
def rough() -> HeightMap:
    return broad()


@pytest.fixture(scope="module")
def noise() -> HeightMap:
    """Independent heights of the pixels."""
    heights = 0.02 * np.random.default_rng(2).normal(size=(160, 192))
    return HeightMap(heights, (1.0, 1.1), periodic=True)


@pytest.fixture(scope="module")
def loads(rough) -> np.ndarray:
    return np.array([3e-3, 1e-2, 3e-2, 6e-2]) * pressure_scale(rough, STEEL)
