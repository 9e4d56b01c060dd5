"""The law of one contact, and of many at once."""

from __future__ import annotations

from .flags import Flag
from .laws import LAWS, tabulate
from .table import LawTable

__all__ = ["LAWS", "Flag", "LawTable", "tabulate"]
