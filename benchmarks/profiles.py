"""Error of summits and profiles read off the pixels, against the same maps refined by Fourier.

    python benchmarks/profiles.py

The refined map has six times as many points and is exact for a band-limited surface. Printed are
the median and the 90 % quantile of the errors of the profiles of all peaks found on both maps: of
the sub-pixel summit [pixels], of the curvatures, and of the gap f on the rays at a quarter and at
the whole of their length, for the quintic spline in use and for two usual local choices.
"""

from __future__ import annotations

import argparse

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

import surfaces

N, TIMES = 192, 6


def refined(hm: surfaces.HeightMap) -> surfaces.HeightMap:
    """The same periodic surface on a grid TIMES as fine; point (0, 0) is kept."""
    n = hm.shape[0]
    small, half = np.fft.rfft2(hm.heights), n // 2
    large = np.zeros((n * TIMES, n * TIMES // 2 + 1), complex)
    large[:half, :half] = small[:half, :half]
    large[-half:, :half] = small[-half:, :half]
    heights = np.fft.irfft2(large, s=(n * TIMES, n * TIMES)) * TIMES**2
    return surfaces.HeightMap(heights, hm.spacing[0] / TIMES, periodic=True)


def catmull_rom(heights: np.ndarray, y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Catmull-Rom interpolation at pixel coordinates of a periodic map."""
    row, col = np.floor(y).astype(int), np.floor(x).astype(int)

    def weights(t: np.ndarray) -> list[np.ndarray]:
        return [
            t * (-0.5 + t * (1 - 0.5 * t)),
            1 + t * t * (-2.5 + 1.5 * t),
            t * (0.5 + t * (2 - 1.5 * t)),
            t * t * (-0.5 + 0.5 * t),
        ]

    wy, wx = weights(y - row), weights(x - col)
    n = heights.shape[0]
    return sum(
        wy[a] * wx[b] * heights[(row + a - 1) % n, (col + b - 1) % n]
        for a in range(4)
        for b in range(4)
    )


def quantiles(error: np.ndarray) -> str:
    """Median and 90 % quantile of the magnitudes."""
    return "{:8.5f} {:8.5f}".format(*np.quantile(np.abs(error), [0.5, 0.9]))


def row(cutoff: float) -> None:
    """Print the errors at one cut-off wavelength [pixels]."""
    hm = surfaces.self_affine(
        (N, N), (N, N), hurst=0.8, rms_slope=0.1, rolloff=N / 8, cutoff=cutoff, seed=3
    )
    fine = refined(hm)
    coarse_fit = surfaces.fit_profiles(hm, surfaces.segment(hm))
    fine_fit = surfaces.fit_profiles(fine, surfaces.segment(fine))
    shift = 0.5 * (1.0 - 1.0 / TIMES)  # both first pixel centers are the same point
    place = np.stack([fine_fit.y + shift, fine_fit.x + shift], axis=1) % N
    mine = np.stack([coarse_fit.y, coarse_fit.x], axis=1) % N
    away, match = cKDTree(place, boxsize=N).query(mine)
    good = np.flatnonzero((away < 0.5) & coarse_fit.valid & fine_fit.valid[match])
    match = match[good]
    print(f"cut-off {cutoff:g} pixels: {len(coarse_fit)} peaks, {good.size} on both maps")
    print(f"  place [pixels]        {quantiles(away[good])}")
    for k in (0, 1):
        ratio = coarse_fit.curvature[good, k] / fine_fit.curvature[match, k]
        print(f"  curvature k{k + 1}          {quantiles(ratio - 1)}")
    fine_spline = ndimage.spline_filter(fine.heights, order=5, mode="grid-wrap")
    cubic_spline = ndimage.spline_filter(hm.heights, order=3, mode="grid-wrap")
    for node in (4, 16):
        r = coarse_fit.edge[good] * coarse_fit.t[node]
        sin, cos = np.sin(coarse_fit.phi[good]), np.cos(coarse_fit.phi[good])

        def read(spline, order, y, x, scale):
            at = [(y[:, None] + r * sin) * scale, (x[:, None] + r * cos) * scale]  # noqa: B023
            return ndimage.map_coordinates(
                spline, at, order=order, mode="grid-wrap", prefilter=False
            )

        truth = fine_fit.height[match, None] - read(
            fine_spline, 5, place[match, 0] - 0.5, place[match, 1] - 0.5, TIMES
        )
        y, x = mine[good, 0] - 0.5, mine[good, 1] - 0.5
        height = coarse_fit.height[good, None]
        choices = {
            "quintic spline": coarse_fit.q[good][:, :, node] * r**2,
            "cubic spline": height - read(cubic_spline, 3, y, x, 1),
            "Catmull-Rom": height
            - catmull_rom(hm.heights, y[:, None] + r * sin, x[:, None] + r * cos),
        }
        for name, f in choices.items():
            print(f"  f, t = {coarse_fit.t[node]:4.2f} {name:<15}{quantiles(f / truth - 1)}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "cutoffs", type=float, nargs="*", default=[4.0, 6.0, 8.0, 16.0], help="[pixels]"
    )
    for cutoff in parser.parse_args().cutoffs:
        row(cutoff)
