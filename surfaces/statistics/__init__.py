"""Roughness of a map: heights, slopes, spectrum, correlation, bearing curve."""
