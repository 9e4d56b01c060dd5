"""Height maps of rough surfaces: files, synthesis, preparation, statistics, peaks, profiles."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
