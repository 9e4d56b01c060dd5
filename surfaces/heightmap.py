"""The height map: heights on a regular grid, with its pixel size and its history."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import html
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from surfaces.arrays import Array
from surfaces.drawing import draw_field, figure_height, image
from surfaces.errors import (
    SurfaceError,
    as_number,
    as_text,
    as_truth,
    checked_heights,
    checked_history,
    checked_spacing,
    checked_span,
)
from surfaces.numerics.stored_array import (
    SAMPLED_LINES,
    Source,
    array_of,
    each_block,
    mapped,
    sampled_lines,
    windows,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from surfaces.roughness import Roughness

__all__ = ["HeightMap", "require_full", "require_map"]


@dataclasses.dataclass(frozen=True, eq=False)
class HeightMap:
    """Heights of a surface on a regular grid of cell-centred pixels.

    Parameters
    ----------
    heights
        Heights out of the solid [m], shape (ny, nx), at least 3 x 3; NaN marks a missing point.
        Masked entries are missing. Kept as a read-only float64 copy (an array that is
        read-only itself, and no view, is not copied).
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
    >>> hm = surfaces.HeightMap(np.zeros((3, 4)), (2e-6, 1e-6), name="steps")
    >>> hm
    <HeightMap 'steps' 3 x 4, pixel 2e-06 x 1e-06 m, not periodic>
    >>> hm.size
    (6e-06, 4e-06)
    """

    heights: Array
    spacing: tuple[float, float]
    periodic: bool = dataclasses.field(default=False, kw_only=True)
    name: str = dataclasses.field(default="", kw_only=True)
    history: tuple[Mapping[str, Any], ...] = dataclasses.field(default=(), kw_only=True)

    def __post_init__(self) -> None:
        checks = checked_heights, checked_spacing, as_text, checked_history
        for name, check in zip(("heights", "spacing", "name", "history"), checks, strict=True):
            object.__setattr__(self, name, check(getattr(self, name)))
        object.__setattr__(self, "periodic", as_truth("periodic", self.periodic))

    @property
    def shape(self) -> tuple[int, int]:
        """Number of points (ny, nx)."""
        ny, nx = self.source.shape
        return ny, nx

    def __reduce__(self) -> tuple[Any, ...]:
        """Made anew from its fields: read only, and nothing kept that was derived from others."""
        facts: dict[str, Any] = {n: getattr(self, n) for n in ("periodic", "name", "history")}
        return functools.partial(HeightMap, **facts), (self.heights, self.spacing)

    @property
    def source(self) -> Source:
        """The heights where they are: in memory, or on disk for what can read them in parts."""
        return self.heights

    @property
    def mapped(self) -> Array:
        """The heights [m] for loops that touch some of them, see `stored_array.mapped`."""
        heights = mapped(self.source).view()
        heights.setflags(write=False)
        return heights

    @property
    def size(self) -> tuple[float, float]:
        """Lengths (Ly, Lx) [m] covered by the pixels."""
        return self.shape[0] * self.spacing[0], self.shape[1] * self.spacing[1]

    @property
    def area(self) -> float:
        """Nominal area Ly Lx [m^2]."""
        return self.size[0] * self.size[1]

    @property
    def x(self) -> Array:
        """Pixel centres along the second axis [m], shape (nx,)."""
        return self.spacing[1] * np.arange(0.5, self.shape[1])

    @property
    def y(self) -> Array:
        """Pixel centres along the first axis [m], shape (ny,)."""
        return self.spacing[0] * np.arange(0.5, self.shape[0])

    @functools.cached_property
    def missing(self) -> int:
        """Number of missing points."""
        if "roughness" in vars(self):
            return self.roughness.missing
        return sum(int(np.count_nonzero(np.isnan(rows))) for _, _, rows in windows(self.source))

    @property
    def rms_height(self) -> float:
        """Root-mean-square height about the mean of the points present [m]."""
        return self.roughness.rms_height

    @functools.cached_property
    def roughness(self) -> Roughness:
        """Means over the map: height, slope, curvature by finite differences, found in one pass."""
        from surfaces.roughness import roughness

        return roughness(self.source, self.spacing, self.periodic)

    @functools.cached_property
    def line_power(self) -> tuple[Array, Array]:
        """Mean squares [m^2] of the waves along y and x in some lines (`roughness.line_power`)."""
        from surfaces.roughness import line_power

        return line_power(self.source, self.periodic)

    @functools.cached_property
    def about_mean(self) -> HeightMap:
        """The map with its heights about their mean; itself where that is below the rms height.

        Sums over heights lose the digits that an offset takes; their differences do not.
        """
        mean = self.roughness.mean
        if abs(mean) <= self.roughness.rms_height:
            return self
        return self.replace(heights=each_block(self.source, lambda z: z - mean))

    @functools.cached_property
    def without_rounding(self) -> HeightMap:
        """The map about its mean, with heights that only rounding tells apart made equal.

        Heights that were cut off and then scaled or levelled are no longer one height, but a summit
        at every point. Where more than a thousandth of neighbors are within 1e-8 rms heights, as
        far as some lines tell, heights are rounded to 1e-7 of it about such a pair; other maps are
        left as they are.
        """
        hm = self.about_mean
        lines, unit = sampled_lines(hm.source, 1), 1e-7 * hm.roughness.rms_height
        gap = np.abs(np.diff(lines, axis=1))
        near = (gap <= 0.1 * unit) & (gap > 0.0)
        if np.mean(near) <= 1e-3:
            return hm
        level = float(np.median(lines[:, 1:][near]))
        rounded = each_block(hm.source, lambda z: level + unit * np.round((z - level) / unit))
        return hm.replace(heights=rounded)

    @functools.cached_property
    def has_equal_neighbors(self) -> bool:
        """Whether neighbors of equal height occur on `SAMPLED_LINES` rows."""
        step = max(1, len(self.source) // SAMPLED_LINES)
        lines, below = self.source[:-1:step], self.source[1::step]
        return bool((lines[:, 1:] == lines[:, :-1]).any() or (lines == below).any())

    @functools.cached_property
    def digest(self) -> str:
        """SHA-256 of heights, spacing and periodicity: identifies the input of a result."""
        hasher = hashlib.sha256(np.array([*self.spacing, float(self.periodic)]).tobytes())
        hasher.update(np.array(self.shape).tobytes())
        for _, _, rows in windows(self.source):
            hasher.update(rows.data)
        return hasher.hexdigest()

    def replace(self, *, step: Mapping[str, Any] | None = None, **changes: Any) -> HeightMap:
        """Copy with some fields changed, and `step` appended to the history."""
        if step is not None:
            changes["history"] = (*changes.get("history", self.history), step)
        return dataclasses.replace(self, **changes)

    def with_rows(
        self,
        blocks: Iterable[tuple[int, Array]],
        shape: tuple[int, int] | None = None,
        **changes: Any,
    ) -> HeightMap:
        """Copy with the heights [m] of blocks of whole rows, each with the number of its first row,
        of another shape or the same; on disk if this map is. `changes` are those of `replace`."""
        return self.replace(heights=array_of(blocks, shape or self.shape, self.source), **changes)

    def crop(
        self, *, x: tuple[float, float] | None = None, y: tuple[float, float] | None = None
    ) -> HeightMap:
        """Cut out the pixels whose centres lie in a rectangle; the result is not periodic.

        Parameters
        ----------
        x, y
            First and last place [m], within the map; the whole length if None.

        Raises
        ------
        SurfaceError
            If a span does not lie within the map, or holds fewer than three pixels.

        Examples
        --------
        >>> import surfaces
        >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1)
        >>> hm.crop(x=(8e-6, 40e-6), y=(0.0, 16e-6)).shape
        (16, 32)
        """
        rows = checked_span("y", y, self.y, self.size[0])
        columns = checked_span("x", x, self.x, self.size[1])
        return self.cut(rows, columns)

    def cut(self, rows: tuple[int, int], columns: tuple[int, int]) -> HeightMap:
        """The pixels between two rows and two columns, each the first and one past the last."""
        blocks = (
            (begin - rows[0], z[:, slice(*columns)]) for begin, _, z in windows(self.source, *rows)
        )
        return self.with_rows(
            blocks,
            (rows[1] - rows[0], columns[1] - columns[0]),
            periodic=False,
            step={"step": "crop", "rows": list(rows), "columns": list(columns)},
        )

    def __add__(self, other: HeightMap | float) -> HeightMap:
        """Heights of both maps together, or an offset [m]; missing where one of them is."""
        return self._with(other, 1.0)

    __radd__ = __add__
    __array_ufunc__ = None  # an array of numpy leaves its sum with a map to the map

    def __sub__(self, other: HeightMap | float) -> HeightMap:
        """Heights less those of another map, or an offset [m]; missing where one of them is."""
        return self._with(other, -1.0)

    def _with(self, other: HeightMap | float, sign: float) -> HeightMap:
        """This map plus `sign` times another on the same pixels, or a number."""
        step: dict[str, Any] = {"step": "add" if sign > 0 else "subtract"}
        if isinstance(other, HeightMap):
            for name, text in (("shape", "points"), ("spacing", "pixel [m]"), ("periodic", "")):
                one, two = getattr(self, name), getattr(other, name)
                if not np.allclose(one, two, rtol=1e-6, atol=0.0):
                    raise SurfaceError(
                        f"the maps differ in {name}: {one} and {two} {text}; bring them to the "
                        "same grid with surfaces.resample, crop or replace(periodic=...)"
                    )
            step |= {"name": other.name, "input": other.digest}
            return self.replace(heights=self.heights + sign * other.heights, step=step)
        step["height"] = as_number("what is added to a map", other)
        return self.replace(heights=self.heights + sign * step["height"], step=step)

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Draw the map in true proportions, heights about their mean.

        Parameters
        ----------
        ax
            Axes to draw on; new ones if None.
        style
            Further arguments of `matplotlib.axes.Axes.imshow`, such as ``cmap``.

        Examples
        --------
        >>> import surfaces
        >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1)
        >>> hm.plot().get_xlabel()
        'x'
        """
        heights = self.heights - np.nanmean(self.heights)
        return draw_field(ax, heights, self.size, "height", "m", **style)

    def _repr_html_(self) -> str:
        """Facts and picture for a notebook."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(4.8, figure_height(3.4, self.size) + 0.7), layout="constrained")
        self.plot(figure.add_subplot())
        steps = ", ".join(str(step.get("step", "")) for step in self.history)
        told = f"rms height {self.rms_height:.4g} m" + (f"; {steps}" if steps else "")
        return f"<div><p>{html.escape(f'{self!r}, {told}')}</p>{image(figure)}</div>"

    def __repr__(self) -> str:
        label = f" {self.name!r}" if self.name else ""
        grid = "{} x {}, pixel {:.4g} x {:.4g} m".format(*self.shape, *self.spacing)
        gaps = f", {self.missing} missing" if self.missing else ""
        return f"<HeightMap{label} {grid}, {'' if self.periodic else 'not '}periodic{gaps}>"


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
        row = next(row for row in range(hm.shape[0]) if np.isnan(hm.source[row]).any())
        column = int(np.argmax(np.isnan(hm.source[row])))
        raise SurfaceError(
            f"heights[{row}, {column}] is missing ({hm.missing} of {hm.source.size} points); "
            f"{what} needs a full map: surfaces.fill_missing, surface prepare --fill harmonic"
        )
