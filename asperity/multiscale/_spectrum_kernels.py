"""Compiled sums over the spectrum of a map."""

from __future__ import annotations

import math

from surfaces.numerics.compiled import compiled


@compiled()
def shell_sums(waves, qy, qx, width, even, metric, m, out):
    """Add to `out` (shells, 8) sums of |h|^2 over the waves of each shell.

    They are those of 1, k^2, k^4, q^2, qx^2 - qy^2, 2 qx qy, q^(1 - m) and q^(2 - 2 m), with
    k^2 = xx qx^2 + 2 xy qx qy + yy qy^2 and `metric` = (xx, xy, yy). `waves` are rows of a real
    transform, of wave numbers `qy` and `qx`; `even` says that its last column stands for itself,
    as the first does, and the others for their mirror images too. A wave belongs to the shell
    nearest to k / `width`.
    """
    last = waves.shape[1] - 1
    xx, xy, yy = metric
    inverse = 1.0 / width
    plain = xx == 1.0 and yy == 1.0 and xy == 0.0  # one root in place of two
    for i in range(waves.shape[0]):
        y = qy[i]
        for j in range(last + 1):
            wave = waves[i, j]
            power = wave.real * wave.real + wave.imag * wave.imag
            if 0 < j and not (even and j == last):
                power *= 2.0
            x = qx[j]
            x2, y2, cross = x * x, y * y, 2.0 * x * y
            square = x2 + y2
            stretched = square if plain else xx * x2 + xy * cross + yy * y2
            root = math.sqrt(square)
            number = root if plain else math.sqrt(stretched)
            if m != 0.0 and square > 0.0:
                root = math.exp((1.0 - m) * math.log(root))  # a power slows the loop threefold
            row = out[int(number * inverse + 0.5)]
            row[0] += power
            row[1] += power * stretched
            row[2] += power * stretched * stretched
            row[3] += power * square
            row[4] += power * (x2 - y2)
            row[5] += power * cross
            row[6] += power * root
            row[7] += power * root * root
