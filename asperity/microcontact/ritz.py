"""Law "ritz" of a batch of profiles: free rays inside their basins, carried on by Newton steps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.errors import Flag
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.transforms import moment_weights
from surfaces.numerics import parallel

from .law_table import LawTable

if TYPE_CHECKING:
    from surfaces.peaks.profiles import Profiles

__all__ = ["forces", "tabulate"]

Array = NDArray[np.float64]

_TABLE_ROUNDS, _COMPARISON_ROUNDS = 8, 4
"""Times that a level is iterated in the batch at most: for a table, and for a comparison."""


def tabulate(
    profiles: Profiles, material: HalfSpace, *, law: str = "ritz", nodes: int = 24
) -> LawTable:
    """Law table of a batch of profiles by free rays inside the basin; see `laws.tabulate`."""
    levels = np.arange(1, nodes + 1) / nodes
    reach, length, height, out = _march(profiles, material.m, levels, _TABLE_ROUNDS)
    unit = material.modulus * length ** (1 + material.m)
    force, stiffness, area = np.zeros((3, length.size, nodes + 1))
    force[:, 1:] = np.maximum.accumulate(out[..., 0], axis=1) * (unit * height)[:, None]
    stiffness[:, 1:] = np.maximum.accumulate(out[..., 1], axis=1) * unit[:, None]
    area[:, 1:] = np.maximum.accumulate(out[..., 2], axis=1) * (length**2)[:, None]
    flags = np.zeros(force.shape, dtype=np.uint8)
    flags[:, 1:][out[..., 3] > 0] |= np.uint8(Flag.BEYOND_RADIUS)
    flags[:, 1:][out[..., 3] > 0.999] |= np.uint8(Flag.FILLED)
    return LawTable(
        reach=reach,
        force=force,
        stiffness=stiffness,
        area=area,
        flags=flags,
        spread=np.zeros(force.shape),
        exponent=3 + material.m,
        law=law,
    )


def forces(profiles: Profiles, material: HalfSpace, levels: Array) -> Array:
    """Forces [N] at the approaches reach * levels**2, levels rising, shape (n, levels), within a
    few per cent."""
    reach, length, height, out = _march(profiles, material.m, levels, _COMPARISON_ROUNDS)
    unit = np.where(reach > 0, material.modulus * length ** (1 + material.m) * height, 0.0)
    return np.asarray(out[..., 0] * unit[:, None])


def _march(
    profiles: Profiles, m: float, levels: Array, rounds: int
) -> tuple[Array, Array, Array, Array]:
    """Reach [m], units of length and height [m], and force, stiffness, area, filled share."""
    from ._ray_kernels import march_rays

    length = profiles.edge.max(axis=1, initial=0.0)
    height = 2.0 * (profiles.q[:, :, -1] * profiles.edge**2).max(axis=1, initial=0.0)
    valid = profiles.valid & (length > 0) & (height > 0)
    length, height = np.where(valid, length, 1.0), np.where(valid, height, 1.0)
    out = np.zeros((length.size, levels.size, 4))
    inputs = (
        np.ascontiguousarray(profiles.q),
        np.ascontiguousarray(profiles.weight),
        profiles.edge / length[:, None],
        length**2 / height,
    )
    weights = np.ascontiguousarray(moment_weights(m, profiles.q.shape[2], 0))

    def part(begin: int, end: int) -> None:
        march_rays(begin, end, inputs, weights, levels, m, rounds, out)

    parallel.run(part, parallel.blocks(length.size, 1 + 72 // levels.size))
    return np.where(valid, height, 0.0), length, height, out
