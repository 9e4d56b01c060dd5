"""The memory of every stage, bounded in one place."""

from __future__ import annotations

from surfaces.numerics.memory import set_memory

__all__ = ["set_memory"]
