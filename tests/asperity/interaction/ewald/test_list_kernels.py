"""Near pairs are selected by vector instructions, on processors that lack them too."""

import os
import subprocess
import sys

PROGRAM = """
import numpy as np
from numba import njit
from asperity.interaction.ewald._list_kernels import LANES, keep_near

@njit
def chosen(y, x, first, last, cut, col, dy, dx):
    return keep_near(y, x, first, last, (0.5, 0.5), (1.0, 1.0), cut, col, dy, dx, 0)

rng = np.random.default_rng(1)
y, x = rng.random((2, 5 + LANES))
col, dy, dx = np.empty(LANES, np.int32), np.empty(LANES, np.float32), np.empty(LANES, np.float32)
for cut in (0.0, 0.05, 0.15, 1.0):
    kept = chosen(y, x, 1, 6, cut, col, dy, dx)
    near = 1 + np.flatnonzero((y[1:6] - 0.5) ** 2 + (x[1:6] - 0.5) ** 2 < cut)
    assert col[:kept].tolist() == near.tolist()
    np.testing.assert_allclose(dy[:kept], 0.5 - y[near], rtol=1e-5)
    np.testing.assert_allclose(dx[:kept], 0.5 - x[near], rtol=1e-5)
print("selected")
"""


def test_near_points_are_selected_on_a_processor_without_wide_instructions():
    plain = os.environ | {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    program = [sys.executable, "-c", PROGRAM]
    done = subprocess.run(program, env=plain, capture_output=True, text=True)
    assert done.stdout == "selected\n", done.stderr
