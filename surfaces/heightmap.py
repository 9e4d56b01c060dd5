"""The height map: heights on a regular grid, with its pixel size and its history."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surfaces.errors import SurfaceError
from surfaces.numerics import parallel

if TYPE_CHECKING:
    from surfaces.roughness import Roughness

__all__ = ["LONGEST", "SHORTEST", "HeightMap", "checked_spacing", "require_map"]


SHORTEST, LONGEST = 1e-40, 1e40
"""Lengths [m] between which the fourth power of every slope is a floating-point number."""

SLIMMEST = 1e3
"""Ratio of the pixel sizes beyond which one of them is in another unit: no instrument has it."""


_LINES = 64
"""Rows, and columns, that tell of all of a map: of the power of its waves, of repeated heights."""


@dataclass(frozen=True, eq=False)
class HeightMap:
    """Heights of a surface on a regular grid of cell-centred pixels.

    Parameters
    ----------
    heights
        Heights out of the solid [m], shape (ny, nx), at least 3 x 3; NaN marks a missing point.
        Masked entries are missing. Kept as a read-only float64 copy.
    spacing
        Pixel size (dy, dx) [m], or one number for square pixels; positive.
    periodic
        True if the map continues across its border as if repeated.
    name
        Name for reports; what is no text, as in the name of a file, becomes "?".
    history
        What was done to the map so far, oldest first: one mapping per step with the key ``step``
        and the parameters and counts of that step.

    Raises
    ------
    SurfaceError
        If the heights are not a real 2-D array of at least 3 x 3 points, hold infinities, are all
        missing, or if they or the spacing are no lengths that can be calculated with, or one pixel
        size is more than 1000 times the other.

    Notes
    -----
    The first axis is y, the second x; pixel (i, j) is centred at ``((j + 1/2) dx, (i + 1/2) dy)``
    and the map covers ``ny dy`` by ``nx dx``.

    Examples
    --------
    >>> import numpy as np
    >>> import surfaces
    >>> hm = surfaces.HeightMap(
    ...     np.arange(12.0).reshape(3, 4) * 1e-9, (2e-6, 1e-6), name="steps"
    ... )
    >>> hm
    <HeightMap 'steps' 3 x 4, pixel 2e-06 x 1e-06 m, not periodic>
    >>> hm.size
    (6e-06, 4e-06)
    """

    heights: NDArray[np.float64]
    spacing: tuple[float, float]
    periodic: bool = dataclasses.field(default=False, kw_only=True)
    name: str = dataclasses.field(default="", kw_only=True)
    history: tuple[Mapping[str, Any], ...] = dataclasses.field(default=(), kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "heights", _checked_heights(self.heights))
        object.__setattr__(self, "spacing", checked_spacing(self.spacing))
        if not isinstance(self.periodic, bool | np.bool_):
            raise SurfaceError(f"periodic is {self.periodic!r}; it must be True or False")
        object.__setattr__(self, "name", str(self.name).encode(errors="replace").decode())
        try:
            steps = tuple(dict(step) for step in self.history)
        except (TypeError, ValueError):
            raise SurfaceError(
                f"history is {self.history!r}; it is a sequence of mappings, one per step"
            ) from None
        object.__setattr__(self, "history", steps)

    @property
    def shape(self) -> tuple[int, int]:
        """Number of points (ny, nx)."""
        ny, nx = self.heights.shape
        return ny, nx

    @property
    def size(self) -> tuple[float, float]:
        """Lengths (Ly, Lx) [m] covered by the pixels."""
        return self.shape[0] * self.spacing[0], self.shape[1] * self.spacing[1]

    @property
    def area(self) -> float:
        """Nominal area Ly Lx [m^2]."""
        return self.size[0] * self.size[1]

    @property
    def x(self) -> NDArray[np.float64]:
        """Pixel centres along the second axis [m], shape (nx,)."""
        return self.spacing[1] * np.arange(0.5, self.shape[1])

    @property
    def y(self) -> NDArray[np.float64]:
        """Pixel centres along the first axis [m], shape (ny,)."""
        return self.spacing[0] * np.arange(0.5, self.shape[0])

    @functools.cached_property
    def missing(self) -> int:
        """Number of missing points."""
        if "roughness" in vars(self):
            return self.roughness.missing
        return int(np.count_nonzero(np.isnan(self.heights)))

    @property
    def rms_height(self) -> float:
        """Root-mean-square height about the mean of the points present [m]."""
        return float(np.nanstd(self.heights))

    @functools.cached_property
    def roughness(self) -> Roughness:
        """Means over the map: height, slope, curvature by finite differences, found in one pass."""
        from surfaces.roughness import roughness

        return roughness(self.heights, self.spacing, self.periodic)

    @functools.cached_property
    def line_power(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Mean squares [m^2] of the waves along y and x in some lines of the map.

        The k-th wave has k periods over the length of the map; k / 2 in a map that is not periodic,
        which is continued by its mirror images. No point may be missing.
        """
        from scipy import fft

        def along(axis: int) -> NDArray[np.float64]:
            count = self.heights.shape[axis]
            stride = max(1, self.heights.shape[1 - axis] // _LINES)
            lines = (
                self.heights[::stride]
                if axis
                else np.ascontiguousarray(self.heights[:, ::stride].T)
            )
            if self.periodic:
                waves = fft.rfft(lines, axis=1)
                squares = np.square(waves.real) + np.square(waves.imag)
            else:
                squares = np.square(0.5 * fft.dct(lines, axis=1))
            power: NDArray[np.float64] = squares.mean(axis=0) * (2.0 / count**2)
            power[0] *= 0.5
            if self.periodic and count % 2 == 0:
                power[-1] *= 0.5
            return power

        y, x = parallel.each(along, (0, 1))
        return y, x

    @functools.cached_property
    def about_mean(self) -> HeightMap:
        """The map with its heights about their mean; itself where that is below the rms height.

        Sums over heights lose the digits that an offset takes; the difference of two heights does
        not.
        """
        mean = self.roughness.mean
        if abs(mean) <= self.roughness.rms_height:
            return self
        return self.replace(heights=self.heights - mean)

    @functools.cached_property
    def without_rounding(self) -> HeightMap:
        """The map about its mean, with heights that only rounding tells apart made equal.

        Heights that were cut off and then scaled or levelled are no longer one height, but a summit
        at every point. Where more than a thousandth of neighbors are within 1e-8 rms heights, as
        far as some lines tell, heights are rounded to 1e-7 of it about such a pair; other maps are
        left as they are.
        """
        hm = self.about_mean
        step = max(1, len(hm.heights) // _LINES)
        lines, unit = hm.heights[::step], 1e-7 * hm.roughness.rms_height
        gap = np.abs(np.diff(lines, axis=1))
        near = (gap <= 0.1 * unit) & (gap > 0.0)
        if np.mean(near) <= 1e-3:
            return hm
        level = float(np.median(lines[:, 1:][near]))
        return hm.replace(heights=level + unit * np.round((hm.heights - level) / unit))

    @functools.cached_property
    def repeats(self) -> bool:
        """Whether neighbors have the same height, as far as some lines tell."""
        step = max(1, len(self.heights) // _LINES)
        lines, below = self.heights[:-1:step], self.heights[1::step]
        return bool((lines[:, 1:] == lines[:, :-1]).any() or (lines == below).any())

    @functools.cached_property
    def digest(self) -> str:
        """SHA-256 of heights, spacing and periodicity: identifies the input of a result."""
        hasher = hashlib.sha256(np.array([*self.spacing, float(self.periodic)]).tobytes())
        hasher.update(np.array(self.shape).tobytes())
        hasher.update(self.heights.data)
        return hasher.hexdigest()

    def replace(self, *, step: Mapping[str, Any] | None = None, **changes: Any) -> HeightMap:
        """Copy with some fields changed, and `step` appended to the history."""
        if step is not None:
            changes["history"] = (*changes.get("history", self.history), step)
        return dataclasses.replace(self, **changes)

    def __repr__(self) -> str:
        (ny, nx), (dy, dx) = self.shape, self.spacing
        label = f" {self.name!r}" if self.name else ""
        border = "periodic" if self.periodic else "not periodic"
        gaps = f", {self.missing} missing" if self.missing else ""
        return f"<HeightMap{label} {ny} x {nx}, pixel {dy:.4g} x {dx:.4g} m, {border}{gaps}>"


def _checked_heights(heights: Any) -> NDArray[np.float64]:
    try:
        if np.iscomplexobj(heights):
            raise TypeError("they are complex")
        if isinstance(heights, np.ma.MaskedArray):
            heights = np.ma.filled(heights.astype(np.float64), np.nan)
        array = np.array(heights, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise SurfaceError(f"heights are not an array of real numbers: {error}") from error
    if array.ndim != 2 or min(array.shape) < 3:
        raise SurfaceError(
            f"heights have shape {array.shape}; a height map needs two axes of at least 3 points"
        )
    low, high = float(np.fmin.reduce(array, axis=None)), float(np.fmax.reduce(array, axis=None))
    if math.isnan(low):
        raise SurfaceError("every point of the height map is missing (NaN)")
    if math.isinf(low) or math.isinf(high):
        infinite = np.isinf(array)
        row, col = np.argwhere(infinite)[0]
        raise SurfaceError(
            f"heights[{row}, {col}] is infinite ({np.count_nonzero(infinite)} of {array.size} "
            "points); mark missing points with NaN"
        )
    if max(abs(low), abs(high)) > LONGEST or 0.0 < high - low < SHORTEST:
        raise SurfaceError(
            f"heights reach from {low:.4g} to {high:.4g} m, which no calculation can hold; "
            "check their unit"
        )
    array.setflags(write=False)
    return array


def checked_spacing(spacing: Any) -> tuple[float, float]:
    """Pixel size (dy, dx) [m], both positive and finite, from a pair or one number."""
    try:
        pair = np.broadcast_to(np.asarray(spacing, dtype=np.float64), (2,))
    except (TypeError, ValueError):
        raise SurfaceError(f"spacing is {spacing!r}; give the pixel size (dy, dx) in m") from None
    if not ((pair >= SHORTEST) & (pair <= LONGEST)).all():
        raise SurfaceError(
            f"spacing is {tuple(pair.tolist())}; both pixel sizes (dy, dx) must be positive "
            "lengths in m"
        )
    if pair.max() > SLIMMEST * pair.min():
        raise SurfaceError(
            f"spacing is {tuple(pair.tolist())}; one pixel size (dy, dx) is more than "
            f"{SLIMMEST:g} times the other: give both in m"
        )
    return float(pair[0]), float(pair[1])


def require_map(hm: object) -> None:
    """Refuse what is no height map, such as a bare array, and say how to make one."""
    if not isinstance(hm, HeightMap):
        raise SurfaceError(
            f"a surfaces.HeightMap is needed, not {type(hm).__name__}: "
            "surfaces.HeightMap(heights, (dy, dx)) or surfaces.read(path)"
        )


def require_full(hm: HeightMap, what: str) -> None:
    """Refuse a map with missing points, and say how to fill them."""
    require_map(hm)
    if hm.missing:
        row, column = np.argwhere(np.isnan(hm.heights))[0]
        raise SurfaceError(
            f"heights[{row}, {column}] is missing ({hm.missing} of {hm.heights.size} points); "
            f'{what} needs a full map: pass fill="harmonic" (--fill harmonic)'
        )
