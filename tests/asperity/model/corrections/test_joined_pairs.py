"""Hills with several summits: contacts that join on them, against boundary elements."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
from asperity.halfspace.scene import pressure_scale
from surfaces import HeightMap, self_affine

BODY = asperity.HalfSpace.from_modulus(1.0)


def hills(seed: int) -> HeightMap:
    """Few hills with smooth, shorter waves, on pixels that are not square."""

    def waves(**recipe: float) -> np.ndarray:
        return self_affine((96, 120), (96.0, 144.0), hurst=0.8, rms_slope=0.1, **recipe).heights

    long = waves(cutoff=36.0, seed=seed)
    short = waves(cutoff=10.0, rolloff=24.0, seed=seed + 1)
    return HeightMap(long + 0.25 * short, (1.0, 1.2), periodic=True)


@pytest.mark.parametrize("seed", [1, 6, 8])
def test_contacts_of_one_hill_join_though_some_of_its_summits_lie_too_far(seed):
    """Summits that join the group last, too far to be pressed with it, leave the others joined."""
    hm = hills(seed)
    loads = np.array([1e-2, 3e-2, 6e-2]) * pressure_scale(hm, BODY)
    curve = asperity.contact_curve(hm, BODY, pressures=loads)
    exact = asperity.bem_curve(hm, BODY, pressures=loads)
    rate = exact.stiffness / exact.mean_pressure
    assert np.abs(rate * (curve.separation - exact.separation)).max() < 0.015
