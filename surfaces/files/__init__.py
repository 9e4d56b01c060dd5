"""Files of height maps and profiles: HDF5, arrays, text, instruments."""
