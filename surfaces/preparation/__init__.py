"""Preparation of a measured map: level, outliers, filling, filters, borders, coarser grids."""
