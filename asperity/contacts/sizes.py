"""Size distribution of contacts."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.errors import InputError
from asperity.results.storage import structured
from surfaces.errors import as_count, as_numbers

__all__ = ["size_distribution"]


def size_distribution(area: ArrayLike, *, bins: int = 20) -> NDArray[np.void]:
    """Histogram of contact areas in logarithmic bins.

    Parameters
    ----------
    area
        Contact areas [m^2], shape (n,), positive: the column ``area`` of the table of
        microcontacts, or the spots of a boundary-element solution.
    bins
        Number of bins between the smallest and the largest area, at least 1.

    Returns
    -------
    Structured array, one row per bin: lower, upper [m^2], contacts [-], and area_share [-], the
    share of these contacts in the whole contact area. No row without contacts.

    Raises
    ------
    InputError
        If an area is not positive and finite, or `bins` no whole number above 0.

    Examples
    --------
    >>> import asperity
    >>> sizes = asperity.size_distribution([1.0, 2.0, 4.0, 4.0], bins=2)
    >>> int(sizes["contacts"].sum())
    4
    """
    sizes, rows = as_numbers("the column of areas", area).ravel(), as_count("bins", bins, 1)
    if not (sizes > 0).all():
        raise InputError('contact areas must be positive: give the column table["area"]')
    edges = np.ones(1)
    if sizes.size:
        edges = np.geomspace(sizes.min() * (1 - 1e-9), sizes.max() * (1 + 1e-9), rows + 1)
    return structured(
        {
            "lower": edges[:-1],
            "upper": edges[1:],
            "contacts": np.histogram(sizes, edges)[0],
            "area_share": np.histogram(sizes, edges, weights=sizes / sizes.sum())[0],
        }
    )
