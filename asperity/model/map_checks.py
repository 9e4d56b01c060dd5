"""What makes an answer of the microcontact model doubtful, known before anything runs."""

from __future__ import annotations

import numpy as np

from surfaces.checks import straight_warning
from surfaces.heightmap import HeightMap

__all__ = ["lay", "model_warnings"]

LONG_LAY = 7.0
"""Slopes across over those along a lay from which on ridges are warned of."""

LINES = 16
"""Rows on which a lay is sought."""


def model_warnings(hm: HeightMap, longest_lay: float) -> list[str]:
    """One sentence for each reason why no law of a summit describes the contacts of a map.

    Parameters
    ----------
    hm
        Height map without missing points.
    longest_lay
        Slopes across over those along a lay from which on no errors are estimated.
    """
    return [*straight_warning(hm), *_lay_warning(lay(hm), longest_lay)]


def lay(hm: HeightMap) -> float:
    """Root-mean-square slope across the lay over that along it, by central differences on lines."""
    step = max(1, hm.shape[0] // (2 * LINES))
    above, line, below = (hm.heights[at : hm.shape[0] - 2 + at : step] for at in range(3))
    dy, dx = hm.spacing
    y, x = (below - above)[:, 1:-1].ravel() / dy, (line[:, 2:] - line[:, :-2]).ravel() / dx
    middle = 0.5 * float(np.mean(y * y) + np.mean(x * x))
    apart = float(np.hypot(0.5 * (np.mean(y * y) - np.mean(x * x)), np.mean(y * x)))
    return float(np.sqrt((middle + apart) / (middle - apart))) if middle > apart else np.inf


def _lay_warning(ratio: float, longest: float) -> list[str]:
    if ratio < LONG_LAY:
        return []
    estimate = ", and its error is not estimated" if ratio >= longest else ""
    return [
        f"slopes across the lay are {ratio:.0f} times those along it: the microcontact model is "
        f"doubtful on such ridges{estimate}; use boundary elements"
    ]
