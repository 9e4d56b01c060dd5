"""Elastic interaction of microcontacts: footprints, operators, and the convex coupled solve."""
