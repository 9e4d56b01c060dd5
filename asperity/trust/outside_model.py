"""Contacts that no law describes: on flat tops and ridges, and cut by the border of a punch.

A law presses a summit that falls away on all sides. Where the highest points of a basin have one
height, contact begins on all of them; where the border cuts a contact, there is no other side.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.contacts.table import summit_pixel
from asperity.microcontact.basin_bem.press import SPREAD

if TYPE_CHECKING:
    from asperity.interaction.population import PopulationState
    from asperity.model.decomposition import Asperities

__all__ = ["LAWLESS", "lawless", "top_areas"]

Array = NDArray[np.float64]

LAWLESS = {"flat_tops": 1.0, "at_border": 0.6, "unsure": 1.0, "unresolved": 1.0}
"""Terms of the error estimate with their weights, for load and area alike: the largest errors where
all contacts are such, of heights cut off at one rms height and of a single wave (0.7 to 0.99), of
tilted maps and of cups (0.6), of single tips r and r^4 (0.8 to 1.6)."""

PRESSED = 0.5
"""Part of the errors on flat tops that is gone where these are pressed alone: of heights cut off at
one and two rms heights, cut cones and coarse steps those of load are 0.2 then, those of area 0.5 at
the lightest loads (seeds 1, 2 and 11)."""

WIDE = 0.2
"""Part of the map over which a flat top reaches from which on it is no contact among others: of
heights cut off at 0.3 rms heights, whose tops hang together, the load is up to 80 % low."""

RESOLVED = 2.0
"""Pixels of a contact from which on the points of the map tell its load: of smaller ones they do
not tell how high the summit between them is. Boundary elements on the map and refined twice are 1.4
and 0.5 of the load off at a pixel for each contact (uniform heights, 128 x 128, seed 1)."""

TELLS_NOTHING = 0.2
"""Part of the load from which on contacts too small for the map are warned of."""

TINIEST = 0.1
"""Pixels of the smallest contact that counts as smaller."""

UNSURE = 0.5
"""Error of its force that a law expects from which on it tells nothing of a contact."""


def lawless(bodies: Asperities, state: PopulationState) -> dict[str, float]:
    """Load on contacts that no law describes or no grid, at one load point; each term from 0.

    Returns
    -------
    flat_tops
        Share of the load on flat tops and ridges: of each contact as much as the top is of it; less
        the larger the part of these tops that is pressed alone.
    at_border
        Square of the share on contacts that the border of a finite punch cuts, as far as it does:
        a few among many do no harm, all of them leave little to trust.
    unsure
        Square of the share on contacts whose law expects an error of `UNSURE` and more of itself.
    unresolved
        One over the number of pixels of the contacts, less that of `RESOLVED`, weighted by load; of
        the smaller pixels where a map whose waves reach the pixel is solved on those.
    """
    closed = np.flatnonzero(state.force > 0)
    if not closed.size:
        return dict.fromkeys(LAWLESS, 0.0)
    share = state.force[closed] / state.force.sum()
    area = np.maximum(state.area[closed], np.finfo(float).tiny)
    spread = np.abs(bodies.population.table.spread_at(closed, state.approach[closed]))
    spans = bodies.top_areas[closed]
    tops = np.minimum(spans, area)
    flat = share @ (tops / area)
    if flat > 0.0:
        summits = bodies.laws.summits
        alone = (summits.dip[closed] > summits.peaks.min_prominence) & (spread == SPREAD)
        alone &= spans < WIDE * bodies.hm.area
        flat *= 1.0 - PRESSED * float(tops @ alone / tops.sum())
    cut = 0.0
    if bodies.plan.boundary == "free":
        places = bodies.profiles.y[closed], bodies.profiles.x[closed]
        sides = [
            np.minimum(at, size - at) - 0.5 * step  # from the outermost points
            for at, size, step in zip(places, bodies.hm.size, bodies.hm.spacing, strict=True)
        ]
        inside = np.clip(np.minimum(*sides) / np.sqrt(area / np.pi), 0.0, 1.0)
        cut = share @ (1.0 - inside)
    unsure = share @ (spread >= UNSURE)
    pixels = area / min(np.prod(hm.spacing) for hm in (bodies.hm, bodies.solved))
    unresolved = share @ np.maximum(1.0 / np.maximum(pixels, TINIEST) - 1.0 / RESOLVED, 0.0)
    return {
        "flat_tops": float(flat),
        "at_border": float(cut**2),
        "unsure": float(unsure**2),
        "unresolved": float(unresolved),
    }


def top_areas(bodies: Asperities) -> Array:
    """Area [m^2] of a disc that spreads as far as the highest points of each basin, shape (n,).

    They are those of one height with the highest beside the summit. A disc of area A has the mean
    squared distance A/(2 pi) from its middle.
    """
    hm, number = bodies.hm, np.arange(len(bodies.profiles))
    if not hm.repeats:
        return np.zeros(number.size)
    wraps = hm.periodic and bodies.plan.boundary == "periodic"
    row, col = np.divmod(summit_pixel(bodies, number, hm), hm.shape[1])
    around = np.array([-1, 0, 1])
    rows, cols = (
        (at[:, None] + around) % n if wraps else np.clip(at[:, None] + around, 0, n - 1)
        for at, n in zip((row, col), hm.shape, strict=True)
    )
    top = hm.heights[rows[:, :, None], cols[:, None, :]].max(axis=(1, 2))
    owner = np.append(bodies.profiles.owner, number.size)[bodies.labels]
    level = np.nonzero(hm.heights == np.append(top, np.inf)[owner])
    own = owner[level]
    square = np.zeros(own.size)
    for at, summit, step, n in zip(level, (row, col), hm.spacing, hm.shape, strict=True):
        away = at - summit[own]
        square += (step * (away - n * np.round(away / n) if wraps else away)) ** 2
    total = np.bincount(own, square, number.size)
    return np.asarray(2.0 * np.pi * total / np.maximum(np.bincount(own, None, number.size), 1))
