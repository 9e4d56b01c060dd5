"""What a pressure map says of the contact: corrected area, contours, histograms."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ._contact_kernels import contact_counts

__all__ = [
    "contours",
    "histogram",
    "read_contact",
]

AREA_FACTOR = (math.pi - 1.0 + math.log(2.0)) / 24.0
"""Correction of the contact area per edge pixel (Yastrebov, Anciaux, Molinari 2017)."""


def read_contact(
    pressure: NDArray[np.float64], spacing: tuple[float, float], nx: int, *, periodic: bool
) -> tuple[float, float, int]:
    """Contact area [m^2] in pixels, the same corrected for the pixels at its edge, and the number
    of patches, of a pressure with nx columns or more.

    Notes
    -----
    ``A = A_px - (pi - 1 + ln 2)/24 P d`` (Yastrebov, Anciaux, Molinari 2017), where P d is the
    number of edges times the pixel area, so that it holds for pixels that are not square.
    """
    pixels, edges, patches = contact_counts(pressure, nx, periodic)
    pixel = spacing[0] * spacing[1]
    return pixels * pixel, max(pixels - AREA_FACTOR * edges, 0.0) * pixel, patches


def contours(contact: NDArray[np.bool_], spacing: tuple[float, float]) -> list[NDArray[np.float64]]:
    """Outlines of the patches as closed polygons of pixel centres (x, y) [m], shape (n, 2) each.

    A patch that crosses the seam of a periodic map gives one outline on each side of it.
    """
    import cv2

    found, _ = cv2.findContours(
        np.ascontiguousarray(contact).view(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE
    )
    scale = np.array([spacing[1], spacing[0]])
    return [(outline[:, 0, :] + 0.5) * scale for outline in found]


def histogram(
    values: NDArray[np.float64], bins: int = 64
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Probability density of positive values, shape (bins,), and bin edges, shape (bins + 1,)."""
    positive = values[values > 0.0]
    if positive.size == 0:
        return np.zeros(bins), np.linspace(0.0, 1.0, bins + 1)
    density, edges = np.histogram(
        positive, bins=bins, range=(0.0, float(positive.max())), density=True
    )
    return density, edges
