"""Compiled sums over the spectrum of a map."""

from __future__ import annotations

import math

from numba import njit


@njit(cache=True, nogil=True)
def shell_sums(waves, qy, qx, width, even, out):
    """Add to `out` (shells, 5) the sums of |h|^2 times 1, q, q^2, q^4 and qx^2 - qy^2.

    `waves` are rows of a real transform, of wave numbers `qy` and `qx`; `even` says that its last
    column stands for itself, as the first does, and the others for their mirror images too. A wave
    belongs to the shell nearest to q / `width`.
    """
    last = waves.shape[1] - 1
    for i in range(waves.shape[0]):
        y2 = qy[i] * qy[i]
        for j in range(last + 1):
            wave = waves[i, j]
            power = wave.real * wave.real + wave.imag * wave.imag
            if 0 < j and not (even and j == last):
                power *= 2.0
            x2 = qx[j] * qx[j]
            square = x2 + y2
            q = math.sqrt(square)
            row = out[int(q / width + 0.5)]
            row[0] += power
            row[1] += power * q
            row[2] += power * square
            row[3] += power * square * square
            row[4] += power * (x2 - y2)
