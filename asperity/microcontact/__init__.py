"""Contact laws of single summits, one at a time and in batches."""

from __future__ import annotations

from ..flags import Flag
from .laws import LAWS, tabulate
from .table import LawTable

__all__ = ["LAWS", "Flag", "LawTable", "tabulate"]
