"""Time of segmentation and profiles: full maps, the top tenth of the heights, many peaks.

    python benchmarks/segmentation.py            # 1024 and 2048
    python benchmarks/segmentation.py 4096       # about 50 000 peaks

Compilation is done before and reported apart. Each row is the same map and the same result every
time; the error column is the share of pixels whose basin differs from an exact flood in descending
height (on a 256 x 320 cut of the same spectrum), which must be zero.
"""

from __future__ import annotations

import argparse
import platform
import time
from collections.abc import Callable

import numba
import numpy as np

import surfaces

REPEATS = 7


def rough(shape: tuple[int, int], cutoff: float, seed: int = 0) -> surfaces.HeightMap:
    """Map of unit pixels, roll-off at an eighth of the side, rms slope 0.1."""
    return surfaces.self_affine(
        shape, shape, hurst=0.8, rms_slope=0.1, rolloff=min(shape) / 8, cutoff=cutoff, seed=seed
    )


def timed(call: Callable[[], object]) -> tuple[float, float]:
    """Least and median seconds of several calls."""
    seconds = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - start)
    return min(seconds), float(np.median(seconds))


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
    small = rough((64, 80), 8.0)
    surfaces.fit_profiles(small, surfaces.segment(small))
    compiled = time.perf_counter() - start
    print(
        f"{platform.processor() or platform.machine()}, numba {numba.__version__}, "
        f"numpy {np.__version__}, first call {compiled:.1f} s, best (median) of {REPEATS}"
    )
    print(
        f"{'map':>6} {'cut-off':>7} {'peaks':>7} {'full [s]':>15} {'top 10 % [s]':>15} {'ratio':>6}"
        f" {'profiles [s]':>15} {'us/peak':>8} {'wrong':>6}"
    )
    for n in sizes:
        for cutoff in (4.0, 8.0):
            hm = rough((n, n), cutoff)
            level = float(np.quantile(hm.heights, 0.9))
            full = timed(lambda: surfaces.segment(hm))  # noqa: B023
            top = timed(lambda: surfaces.segment(hm, above=level))  # noqa: B023
            peaks = surfaces.segment(hm)
            fits = timed(lambda: surfaces.fit_profiles(hm, peaks))  # noqa: B023
            cut = rough((256, 320), cutoff, seed=1)
            wrong = np.mean(sorted_flood(cut) != surfaces.segment(cut).labels)
            print(
                f"{n:>6} {cutoff:>7.0f} {len(peaks):>7} {full[0]:>7.3f} ({full[1]:.3f})"
                f" {top[0]:>7.4f} ({top[1]:.3f}) {full[0] / top[0]:>6.1f}"
                f" {fits[0]:>7.3f} ({fits[1]:.3f}) {1e6 * fits[0] / len(peaks):>8.1f} {wrong:>6.0%}"
            )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("points", type=int, nargs="*", default=[1024, 2048], help="per side")
    main(parser.parse_args().points)
