"""How much of a rough surface touches, at what load and separation, and how far to trust it."""

import os

import lazy_loader

__version__ = "0.1.0"

# FFTW's threads wait by OpenMP and must sleep soon: while they spin, the loops between two
# transforms lack a processor (boundary elements took 1.1 times as long). 10 000 spins (below
# 0.5 ms) bridge the gap between two stages of a transform. The runtime reads this once.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
os.environ.setdefault("GOMP_SPINCOUNT", "10000")

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
