"""Time of segmentation and profiles: full maps, the top tenth of the heights, many peaks.

    python benchmarks/segmentation.py            # 1024 and 2048
    python benchmarks/segmentation.py 4096       # about 50 000 peaks

Compilation is done before and reported apart. Each row is the same map and the same result every
time; the error column is the share of pixels whose basin differs from an exact flood in descending
height (on a 256 x 320 cut of the same spectrum), which must be zero.
"""

from __future__ import annotations

import time

import numpy as np
from common import least, machine, options, rough

import surfaces


def sorted_flood(hm: surfaces.HeightMap) -> np.ndarray:
    """Basins by flooding pixel after pixel in descending height (periodic, no equal heights)."""
    ny, nx = hm.shape
    labels = np.full(hm.shape, -1)
    count = 0
    for p in np.argsort(-hm.heights, axis=None):
        i, j = divmod(int(p), nx)
        best, label = 0.0, -1
        for di, dj in ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)):
            row, col = (i + di) % ny, (j + dj) % nx
            rise = (hm.heights[row, col] - hm.heights[i, j]) / np.hypot(di, dj)
            if rise > best:
                best, label = rise, labels[row, col]
        if label < 0:
            label, count = count, count + 1
        labels[i, j] = label
    return labels


def main(sizes: list[int]) -> None:
    start = time.perf_counter()
    small = rough((64, 80), 8.0, 0)
    surfaces.fit_profiles(small, surfaces.segment(small))
    compiled = time.perf_counter() - start
    print(f"{machine()}, first call {compiled:.1f} s, least of several")
    print(
        f"{'map':>6} {'cut-off':>7} {'peaks':>7} {'full [s]':>9} {'top 10 % [s]':>13} {'ratio':>6}"
        f" {'profiles [s]':>13} {'us/peak':>8} {'wrong':>6}"
    )
    for n in sizes:
        for cutoff in (4.0, 8.0):
            hm = rough((n, n), cutoff, 0)
            level = float(np.quantile(hm.heights, 0.9))
            full = least(lambda: surfaces.segment(hm))  # noqa: B023
            top = least(lambda: surfaces.segment(hm, above=level))  # noqa: B023
            peaks = surfaces.segment(hm)
            fits = least(lambda: surfaces.fit_profiles(hm, peaks))  # noqa: B023
            cut = rough((256, 320), cutoff, 1)
            wrong = np.mean(sorted_flood(cut) != surfaces.segment(cut).labels)
            print(
                f"{n:>6} {cutoff:>7.0f} {len(peaks):>7} {full:>9.3f} {top:>13.4f}"
                f" {full / top:>6.1f} {fits:>13.3f} {1e6 * fits / len(peaks):>8.1f} {wrong:>6.0%}"
            )


if __name__ == "__main__":
    parser = options(__doc__)
    parser.add_argument("points", type=int, nargs="*", default=[1024, 2048], help="per side")
    main(parser.parse_args().points)
