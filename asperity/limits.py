"""The memory and the number of threads of every stage, each set in one place."""

from __future__ import annotations

from surfaces.numerics.memory import set_memory
from surfaces.numerics.parallel import set_threads

__all__ = ["set_memory", "set_threads"]
