"""Preparation of a measured map: level, outliers, filling, filters, coarser grids."""
