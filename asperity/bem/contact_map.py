"""What a pressure map says of the contact: corrected area, patches, contours, histograms."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ._contact_kernels import contact_counts

__all__ = [
    "contours",
    "histogram",
    "label_patches",
    "read_contact",
]

_NO_PAIRS = np.zeros((0, 2), np.int32)

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


def label_patches(contact: NDArray[np.bool_], *, periodic: bool) -> tuple[NDArray[np.int32], int]:
    """Label the connected contact patches (edge neighbors), joined across the seam if periodic.

    Returns
    -------
    labels
        1..n on the patches, 0 outside, shape (ny, nx).
    count
        Number of patches n.
    """
    labels, count = _components(contact)
    pairs = _seam_pairs(labels) if periodic and count > 1 else _NO_PAIRS
    if not len(pairs):
        return labels, count - 1
    target = _merged(pairs, count)
    return target[labels], int(target.max())


def _components(contact: NDArray[np.bool_]) -> tuple[NDArray[np.int32], int]:
    """Labels of the map without its continuation, and their number with the background."""
    import cv2

    count, labels = cv2.connectedComponents(
        np.ascontiguousarray(contact).view(np.uint8), connectivity=4, ltype=cv2.CV_32S
    )
    return np.asarray(labels, np.int32), count


def _seam_pairs(labels: NDArray[np.int32]) -> NDArray[np.int32]:
    """Pairs of labels that meet across the seam, shape (k, 2)."""
    pairs = []
    for first, last in ((labels[0], labels[-1]), (labels[:, 0], labels[:, -1])):
        both = (first > 0) & (last > 0)
        pairs.append(np.stack([first[both], last[both]], axis=1))
    return np.unique(np.concatenate(pairs), axis=0)


def _merged(pairs: NDArray[np.int32], count: int) -> NDArray[np.int32]:
    """New label of each old one when the labels of each pair are made equal."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), (count, count))
    _, group = connected_components(graph, directed=False)
    first = np.full(group.max() + 1, -1)
    first[group[::-1]] = np.arange(count)[::-1]
    order = np.argsort(np.argsort(first))
    return np.asarray(order[group], np.int32)


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
