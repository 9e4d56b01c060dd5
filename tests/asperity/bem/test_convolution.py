"""The blocked convolution against the whole one, and memory lent from idle arrays."""

from __future__ import annotations

import numpy as np
import pytest

from asperity.bem import convolution, transform
from asperity.bem.transform import FFTWTransform, Scratch


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize(
    "shape, padded", [((40, 54), (40, 54)), ((37, 35), (37, 35)), ((33, 40), (66, 80))]
)
def test_blocked_convolution_is_the_whole_one(shape, padded, threads, dtype, monkeypatch):
    """Periodic or padded, odd sizes, blocks that do not divide the grid."""
    for module in (convolution.parallel, transform):
        monkeypatch.setattr(module, "threads", lambda: threads)
    rng = np.random.default_rng(1)
    symbol = rng.random((padded[0] // 2 + 1, padded[1] // 2 + 1)).astype(dtype)
    values = rng.standard_normal(shape)
    found = []
    for kind in (FFTWTransform, convolution._Blocked):
        pair = kind(shape, padded, np.dtype(dtype), Scratch())
        pair.values[:, : shape[1]] = values
        for _ in range(2):
            pair.apply(symbol)
        found.append(pair.grid[:, : shape[1]])
    rounding = 5e3 * np.finfo(dtype).eps
    np.testing.assert_allclose(*found, rtol=0.0, atol=rounding * np.abs(found[0]).max())


def test_scratch_lends_idle_memory_first():
    """Arrays of zeros, aligned, apart from each other, from the idle array while it lasts."""
    idle = np.ones(1000)
    scratch = Scratch(idle)
    first = scratch.zeros((10, 20), np.float32)
    second = scratch.zeros((5, 30), np.complex128)
    third = scratch.zeros((900,))
    for array in (first, second, third):
        assert array.ctypes.data % 64 == 0
        assert not array.any()
    assert np.shares_memory(first, idle)
    assert np.shares_memory(second, idle)
    assert not np.shares_memory(first, second)
    assert not np.shares_memory(third, idle)
