"""What tests of fine waves share: a body, a law of fine waves and a spectrum that needs one."""

from __future__ import annotations

import asperity
from asperity.multiscale.sub_contact_law import SubContactLaw
from surfaces import HeightMap, self_affine

STEEL = asperity.HalfSpace.from_modulus(2e11)
FINE = SubContactLaw(shortest=1e-6, ratio=1.0, variance=4e18, energy=3e2, number=6e6)


def broad(shape=(240, 288), seed=3, **more) -> HeightMap:
    """A spectrum that reaches the pixel, on pixels that are not square."""
    size = (shape[0] * 1.0e-6, shape[1] * 0.8e-6)
    given = {"hurst": 0.8, "rms_slope": 0.1, "rolloff": 0.25 * size[1], **more}
    return self_affine(shape, size, seed=seed, **given)
