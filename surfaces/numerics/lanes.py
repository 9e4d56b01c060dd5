"""Eight numbers at once (`vectors`): one lane per profile, or per node of a contour.

A kernel that handles eight profiles reads like that of one. Arrays hold them as eight contiguous
numbers; an index counts such groups.
"""

from __future__ import annotations

from .vectors import adder, loader, picker, splatter, storer, transposer

__all__ = ["LANES", "add", "load", "pick", "splat", "store", "transpose"]

LANES = 8
"""Numbers in a vector."""

load = loader(LANES, grouped=True)
store = storer(grouped=True)
add = adder(grouped=True)
pick = picker()
transpose = transposer(LANES, grouped=True)
splat = splatter(LANES)
