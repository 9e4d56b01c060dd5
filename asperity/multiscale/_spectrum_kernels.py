"""Compiled sums over the spectrum of a map."""

from __future__ import annotations

import math

from surfaces.numerics.compiled import compiled


@compiled()
def shell_sums(waves, qy, qx, width, even, m, out):
    """Add to `out` (shells, 5) sums of |h|^2 over the waves of each shell.

    They are those of 1, q^2, q^4, q^(1 - m) and q^(2 - 2 m). `waves` are rows of a real transform,
    of wave numbers `qy` and `qx`; `even` says that its last column stands for itself, as the first
    does, and the others for their mirror images too. A wave belongs to the shell nearest to
    q / `width`.
    """
    last = waves.shape[1] - 1
    inverse = 1.0 / width
    for i in range(waves.shape[0]):
        y = qy[i]
        for j in range(last + 1):
            wave = waves[i, j]
            power = wave.real * wave.real + wave.imag * wave.imag
            if 0 < j and not (even and j == last):
                power *= 2.0
            x = qx[j]
            square = x * x + y * y
            number = math.sqrt(square)
            root = number
            if m != 0.0 and square > 0.0:
                root = math.exp((1.0 - m) * math.log(number))  # a power slows the loop threefold
            row = out[int(number * inverse + 0.5)]
            row[0] += power
            row[1] += power * square
            row[2] += power * square * square
            row[3] += power * root
            row[4] += power * root * root
