"""Contact map and pressure field of one load point.

A state gives the force and the area of each contact. This module finds its shape on the pixels from
the gap; force and area do not change.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from asperity.halfspace.footprint import Footprints
from surfaces.arrays import Array, Index
from surfaces.numerics.memory import require_memory
from surfaces.numerics.parallel import threads
from surfaces.numerics.stored_array import mapped
from surfaces.preparation.filtering import bandpass

if TYPE_CHECKING:
    from asperity.interaction.population import PopulationState
    from asperity.model.decomposition import Decomposition
    from asperity.model.load_point import LoadPoint
    from surfaces.heightmap import HeightMap

__all__ = ["pressed_pixels", "pressure_map"]


PRESSURE_CORRECTIONS = 3
"""Number of corrections of the pressure by the remaining gap; more change little."""

SATURATED_PRESSURE = 0.999
"""Least pressure over the hardness of a yielded pixel: its gap is no error."""

CORRECTION_RELAXATION = 0.7
"""Share of a correction that is applied. With 1 the pressure oscillates, by 2 to 4 % of the peak of
a Hertz contact."""

POINT_BYTES, TRANSFORM_BYTES = 68, 32
"""Bytes of peak memory per point of a map, and of its transforms: 80 to 97 were measured in all on
periodic maps, 152 to 186 on free ones, whose transforms have four times the points."""


def pressure_map(decomposition: Decomposition, point: LoadPoint) -> Array:
    """Pressure [Pa] of every pixel, shape (ny, nx), zero outside contacts, see `pressed_pixels`."""
    return _image(decomposition.hm, *pressed_pixels(decomposition, point))


def pressed_pixels(decomposition: Decomposition, point: LoadPoint) -> tuple[Index, Index, Array]:
    """Flat index of each pixel in contact, the contact that presses there, and its pressure [Pa].

    A contact whose basin holds no centre of a pixel gets the pixel of its summit, which it shares
    with another contact.

    Notes
    -----
    Each contact occupies the pixels of its basin with the largest values of a field f, as many as
    fill its area, at least one. Its pressure is f less the f of the next pixel, scaled to its
    force, and cut at the hardness if there is one. At first f is the height h. With the
    displacement u = K p of all contacts and the gap g = u - h it is then corrected
    (`PRESSURE_CORRECTIONS` times) to

        f = p - 0.7 K^-1 g inside the contacts, K^-1 ~ q^(1-m),
        f = -g times the K^-1 of the wave number sqrt(m4/m2) of the map outside,

    where pixels at the hardness are treated as outside ones, with g added.

    With a sub-contact law (`asperity.multiscale`) the pressure K^-1 h that flattens the fine waves
    h is added to f, times sqrt(g0) of that law, to first order (Persson 2001), and the pixels fill
    the area that the fine waves leave closed. With the standard deviation s of the added pressure,
    the pressure at the excess x of f is sqrt(x^2 + 2 s x), which rises as a square root from the
    edges of the spots. The last correction is made on the pixels of the whole map.
    """
    solved, whole, state = decomposition.solved, decomposition.hm, point.state
    if not state.active:
        return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0)
    grid = _Grid.of(decomposition, state, solved, mapped(decomposition.summits.peaks.labels))
    pressed = grid.occupied(solved.heights, state.area, state.force)
    for _ in range(PRESSURE_CORRECTIONS):
        pressure = _image(solved, *pressed)
        field = grid.corrected(pressure, grid.gap_stiffness)
        pressed = grid.occupied(field, state.area, state.force)
    if solved is whole:
        return pressed
    stiffness, fine, deviation = grid.gap_stiffness, 0.0, 0.0
    law = decomposition.plan.sub_contact_law
    full = _Grid.of(decomposition, state, whole, decomposition.labels)
    if law is not None:
        left = bandpass(whole, longest=law.shortest).heights
        fine = np.sqrt(law.spread) * full.pressed_flat(left)
        deviation = float(np.std(fine))
        stiffness = deviation / float(np.std(left))
    area = point.closed_area
    field = _on_the_map(decomposition, grid.corrected(pressure, stiffness)) + fine
    pressure = _image(whole, *full.occupied(field, area, state.force, deviation))
    return full.occupied(full.corrected(pressure, full.gap_stiffness), area, state.force, deviation)


@dataclass(frozen=True)
class _Grid:
    """The half-space and the basins of the contacts that carry load, on the points of a map.

    On a free half-space transforms are padded to twice the size: the images shift the displacement
    of the contacts, but hardly its slope.

    Attributes
    ----------
    hm
        The map.
    padded, number
        Shape of the transforms, and their wave numbers [1/m].
    symbol, m
        A pressure wave p of wave number q has the displacement symbol q^(m-1) p.
    hardness
        Largest pressure [Pa].
    closed
        Contacts with load, shape (c,).
    pixel, contact
        Flat index of each pixel of the basins of these contacts, sorted by contact, and its
        contact, shape (k,) each.
    first
        Index in `pixel` of the first pixel of each contact, shape (c,).
    """

    hm: HeightMap
    padded: tuple[int, int]
    number: Array
    symbol: float
    m: float
    hardness: float
    closed: Index
    pixel: Index
    contact: Index
    first: Index

    @classmethod
    def of(
        cls,
        decomposition: Decomposition,
        state: PopulationState,
        hm: HeightMap,
        labels: NDArray[np.int32],
    ) -> _Grid:
        """The grid of a map; `labels` hold the peak whose basin holds each pixel."""
        free, body = decomposition.plan.boundary == "free", decomposition.material
        ny, nx = (fft.next_fast_len(2 * n, real=True) if free else n for n in hm.shape)
        require_memory(
            POINT_BYTES * math.prod(hm.shape) + TRANSFORM_BYTES * ny * nx,
            f"the pressure at {hm.shape[0]} x {hm.shape[1]} points",
            "raise the limit of memory (--memory), or leave out fields, spots and their sizes",
        )
        qy, qx = fft.fftfreq(ny, hm.spacing[0]), fft.rfftfreq(nx, hm.spacing[1])
        number = 2.0 * np.pi * np.hypot(qy[:, None], qx)
        symbol = Footprints(body.modulus, body.m).symbol
        material = symbol, body.m, body.hardness
        owner = np.append(decomposition.summits.owner, len(state.force))[labels.ravel()]
        pixel = np.flatnonzero(np.append(state.force > 0, False)[owner])
        lost = np.setdiff1d(np.flatnonzero(state.force > 0), owner[pixel])
        summit = decomposition.summit_pixels(lost, hm)
        # a contact without a pixel takes that of its summit, from one that has others
        spare = ~np.isin(pixel, summit)
        pixel = pixel[spare | (np.bincount(owner[pixel], spare)[owner[pixel]] == 0.0)]
        contact = np.append(owner[pixel], lost)
        pixel = np.append(pixel, summit)
        order = np.argsort(contact, kind="stable")
        pixel, contact = pixel[order], contact[order]
        closed, first = np.unique(contact, return_index=True)
        return cls(hm, (ny, nx), number, *material, closed, pixel, contact, first)

    @property
    def gap_stiffness(self) -> float:
        """Pressure over gap [Pa/m] beside the contacts."""
        return float(self.hm.roughness.length ** (self.m - 1.0) / self.symbol)

    def displaced(self, pressure: Array) -> Array:
        """Displacement [m] by a pressure [Pa], but for a constant."""
        number = self.number.copy()
        number[0, 0] = np.inf
        return self._through(pressure, self.symbol * number ** (self.m - 1.0))

    def pressed_flat(self, heights: Array) -> Array:
        """Pressure [Pa] that presses heights [m] flat."""
        return self._through(heights, self.number ** (1.0 - self.m) / self.symbol)

    def corrected(self, pressure: Array, stiffness: float) -> Array:
        """Field [Pa], shape (ny, nx), whose largest values are the pixels of the contacts.

        The gap under each contact is taken relative to its mean; `stiffness` [Pa/m] as
        `gap_stiffness`.
        """
        gap = self.displaced(pressure) - self.hm.heights
        gap -= np.average(gap, weights=pressure)
        gaps = gap.ravel()[self.pixel]
        weight = pressure.ravel()[self.pixel]
        weight = weight + 1e-12 * weight.max()
        mean = np.add.reduceat(weight * gaps, self.first) / np.add.reduceat(weight, self.first)
        gap.flat[self.pixel] = gaps - self._at_pixels(mean)
        touching = (pressure > 0.0) & (pressure < SATURATED_PRESSURE * self.hardness)
        pressed = pressure - CORRECTION_RELAXATION * self.pressed_flat(np.where(touching, gap, 0.0))
        return np.where(touching, pressed, pressure - stiffness * gap)

    def occupied(
        self, field: Array, area: Array, force: Array, deviation: float = 0.0
    ) -> tuple[Index, Index, Array]:
        """Pixels, whose they are, and pressures [Pa] of contacts of areas [m^2] and forces [N].

        They occupy the largest values of the field; `deviation` [Pa] is s in `pressed_pixels`.
        """
        size = self.hm.spacing[0] * self.hm.spacing[1]
        height = field.ravel()[self.pixel]
        order = np.lexsort((-height, self.contact))
        height = height[order]
        end = np.append(self.first[1:], len(order))
        # what a basin does not bear at the hardness is left to the other contacts
        total, room = force[self.closed] / size, self.hardness * (end - self.first).astype(float)
        total = _scaled(total, np.array([0]), total.sum(keepdims=True), room)
        least = np.ceil(total / self.hardness - 1e-9).astype(np.int64)
        whole = np.maximum(_whole(area[self.closed] / size), least)
        stop = np.minimum(self.first + whole, end)
        level = height[np.minimum(stop, end - 1)]
        level = np.where(stop == end, np.minimum(level, 0.0), level)
        over = np.maximum(height - self._at_pixels(level), 0.0)
        over = np.sqrt(over * (over + 2.0 * deviation))
        over += 1e-9 * over.max() or 1.0  # equal heights press alike
        taken = np.arange(len(order)) < self._at_pixels(stop)
        over[~taken] = 0.0
        pressure = _scaled(over, self.first, total, self.hardness)
        return self.pixel[order][taken], self.contact[taken], pressure[taken]

    def _at_pixels(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values of the contacts, at the pixels of their basins."""
        return _spread(values, self.first, len(self.pixel))

    def _through(self, field: Array, factor: Array) -> Array:
        waves = fft.rfft2(field, s=self.padded, workers=threads())
        waves *= factor
        found = fft.irfft2(waves, s=self.padded, workers=threads(), overwrite_x=True)
        return np.asarray(found[: self.hm.shape[0], : self.hm.shape[1]])


def _scaled(over: Array, first: Index, total: Array, most: float | Array) -> Array:
    """Values `over` times a factor for each run that begins at `first` but at most `most`, that add
    up to `total` in each."""
    found = over * _spread(total / np.add.reduceat(over, first), first, len(over))
    while (found > most).any():  # what is too much is left to the others
        held = found >= most
        free = np.add.reduceat(np.where(held, 0.0, found), first)
        left = total - np.add.reduceat(np.where(held, most, 0.0), first)
        factor = np.divide(left, free, out=np.ones(free.shape), where=free > 0.0)
        found = np.where(held, most, found * _spread(factor, first, len(over)))
    return np.asarray(found)


def _spread(values: NDArray[Any], first: Index, count: int) -> NDArray[Any]:
    """Values of runs that begin at `first`, of `count` places in all, at each place."""
    return np.repeat(values, np.diff(np.append(first, count)))


def _image(hm: HeightMap, pixel: Index, contact: Index, pressure: Array) -> Array:
    """Pressure [Pa] of every pixel of a map, shape (ny, nx), of `pressed_pixels`."""
    found = np.bincount(pixel, weights=pressure, minlength=hm.heights.size)
    return np.asarray(found, float).reshape(hm.shape)


def _whole(pixels: Array) -> Index:
    """Pixels of each contact, one at least; what rounding takes from one is given to the next."""
    beyond = np.rint(np.cumsum(np.maximum(pixels - 1.0, 0.0))).astype(np.int64)
    return np.asarray(1 + np.diff(beyond, prepend=0))


def _on_the_map(decomposition: Decomposition, field: Array) -> Array:
    """A field of the grid that is solved, on the pixels of the map, by cubics through its own."""
    from scipy.ndimage import map_coordinates

    hm, solved = decomposition.hm, decomposition.solved
    places = (
        (at - corner) / step - 0.5
        for at, corner, step in zip((hm.y, hm.x), decomposition.corner, solved.spacing, strict=True)
    )
    mode = "grid-wrap" if decomposition.wraps else "nearest"
    return np.asarray(map_coordinates(field, np.meshgrid(*places, indexing="ij"), mode=mode))
