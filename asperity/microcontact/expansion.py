"""The first-order solution about the circle: as published, and resolved harmonic by harmonic."""

from __future__ import annotations

from .batch import tabulate

__all__ = ["tabulate"]
