"""Quantities that follow from a contact curve alone."""
