"""Displacements of many footprints: near pairs summed, the smooth part on a mesh."""
