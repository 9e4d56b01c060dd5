"""Height maps of rough surfaces: files, synthesis, preparation, statistics, peaks, profiles."""

from ._lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
