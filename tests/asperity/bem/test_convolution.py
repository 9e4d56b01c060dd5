"""The blocked convolution against the whole one."""

from __future__ import annotations

import numpy as np
import pytest

from asperity.bem import convolution


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize(
    "shape, padded", [((40, 54), (40, 54)), ((37, 35), (37, 35)), ((33, 40), (66, 80))]
)
def test_blocked_convolution_is_the_whole_one(shape, padded, threads, dtype, monkeypatch):
    """Periodic or padded, odd sizes, blocks that do not divide the grid."""
    monkeypatch.setattr(convolution.parallel, "threads", lambda: threads)
    rng = np.random.default_rng(1)
    symbol = rng.random((padded[0] // 2 + 1, padded[1] // 2 + 1)).astype(dtype)
    values = rng.standard_normal(shape)
    found = []
    for kind in (convolution.FFTWTransform, convolution._Blocked):
        pair = kind(shape, padded, np.dtype(dtype))
        pair.values[:, : shape[1]] = values
        for _ in range(2):
            pair.apply(symbol)
        found.append(pair.grid[:, : shape[1]])
    rounding = 5e3 * np.finfo(dtype).eps
    np.testing.assert_allclose(*found, rtol=0.0, atol=rounding * np.abs(found[0]).max())
