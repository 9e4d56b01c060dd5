"""Height maps: heights on a regular grid, with the pixel size and what is measured at once."""

from .height_map import LONGEST, SHORTEST, HeightMap, checked_spacing, require_map

__all__ = ["LONGEST", "SHORTEST", "HeightMap", "checked_spacing", "require_map"]
