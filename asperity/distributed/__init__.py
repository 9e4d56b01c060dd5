"""Many maps, materials and settings: jobs on Dask or a pool of processes, and their index."""
