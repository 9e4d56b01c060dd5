"""How much of a rough surface touches, at what load and separation, and how far to trust it."""

import os

import lazy_loader

__version__ = "0.1.0"

# A waiting OpenMP thread must sleep soon: on a busy machine a barrier that spins for long costs
# more than the loop that it ends.  10 000 spins (below 0.5 ms) bridge the gap between two loops,
# so that schedulers that pack tasks do not put both threads on one processor.  The runtime reads
# this once, when the first parallel kernel loads it.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
os.environ.setdefault("GOMP_SPINCOUNT", "10000")

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
