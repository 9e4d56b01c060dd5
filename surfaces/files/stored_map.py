"""A height map that stays on disk: what can read it in parts does, all else loads it."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from surfaces.arrays import Array
from surfaces.errors import as_text, as_truth, checked_history, checked_range, checked_spacing
from surfaces.heightmap import HeightMap
from surfaces.numerics.memory import require_memory
from surfaces.numerics.stored_array import Source, StoredArray, windows

__all__ = ["StoredMap"]


class StoredMap(HeightMap):
    """A height map too large for memory, made by `surfaces.read` and `SurfaceFile.on_disk`.

    Notes
    -----
    Preparation and resampling (but for the spline filter of a free border), statistics, the plan of
    a run, the split of waves, coarser grids, peaks and summits read `source` in parts. All else
    takes `heights`, which are loaded then, or refused in a sentence.
    """

    def __init__(
        self,
        source: StoredArray,
        spacing: tuple[float, float],
        *,
        periodic: bool = False,
        name: str = "",
        history: Iterable[Mapping[str, Any]] = (),
    ) -> None:
        given = {
            "_source": source,
            "spacing": checked_spacing(spacing),
            "periodic": as_truth("periodic", periodic),
            "name": as_text(name),
            "history": checked_history(history),
        }
        for key, value in given.items():
            object.__setattr__(self, key, value)

    @classmethod
    def of_blocks(
        cls,
        blocks: Iterable[tuple[int, Array]],
        shape: tuple[int, int],
        dtype: Any,
        spacing: tuple[float, float],
        **facts: Any,
    ) -> StoredMap:
        """The map of some blocks of whole rows, each with the number of its first row.

        Raises
        ------
        SurfaceError
            If there is no room on disk, or the heights are none of a map.
        """
        source = StoredArray(shape, dtype)
        low, high = np.nan, np.nan
        for first, rows in blocks:
            low = np.fmin(low, np.fmin.reduce(rows, axis=None))
            high = np.fmax(high, np.fmax.reduce(rows, axis=None))
            source.write(first, rows)
        checked_range(float(low), float(high), source)
        return cls(source, spacing, **facts)

    @property
    def source(self) -> Source:
        """The heights on disk; in memory once something has asked for all of them."""
        found: Source = vars(self).get("heights", vars(self)["_source"])
        return found

    @functools.cached_property
    def heights(self) -> Array:
        """All heights [m], loaded."""
        ny, nx = self.shape
        require_memory(
            8 * ny * nx,
            f"the map of {ny} x {nx} points, of which this step takes all at once,",
            "raise the limit of memory (--memory), crop the map (--crop) or leave out what changes "
            "all of it (--level none)",
        )
        heights = np.empty((ny, nx))
        for begin, end, rows in windows(vars(self)["_source"]):
            heights[begin:end] = rows
        heights.setflags(write=False)
        return heights

    def replace(self, *, step: Mapping[str, Any] | None = None, **changes: Any) -> HeightMap:
        """Copy with some fields changed, and `step` appended to the history."""
        if step is not None:
            changes["history"] = (*changes.get("history", self.history), step)
        names = "spacing", "periodic", "name", "history"
        facts: dict[str, Any] = {name: getattr(self, name) for name in names} | changes
        heights = facts.pop("heights", vars(self)["_source"])
        kind = StoredMap if isinstance(heights, StoredArray) else HeightMap
        return kind(heights, **facts)
