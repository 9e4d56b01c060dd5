"""Peaks of a map: segmentation, summits, and profiles about them."""
