"""Contact laws of single summits, one at a time and in batches."""

from __future__ import annotations

from asperity.errors import Flag

from .law_table import LawTable
from .laws import LAWS, tabulate

__all__ = ["LAWS", "Flag", "LawTable", "tabulate"]
