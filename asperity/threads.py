"""The number of threads of every parallel stage, set in one place."""

from __future__ import annotations

from surfaces.numerics.parallel import set_threads

__all__ = ["set_threads"]
