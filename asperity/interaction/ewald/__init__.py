"""Displacements of many footprints: Ewald split into near pairs and a smooth part on a mesh."""
