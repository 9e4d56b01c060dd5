"""The contacts of one load point: table, outlines, pressure field, separate spots."""
