"""Error of summits and profiles read off the pixels, against the same maps refined by Fourier.

    python benchmarks/profiles.py

The refined map has six times as many points and is exact for a band-limited surface. Printed are
the median and the 90 % quantile of the errors of the profiles of all peaks found on both maps: of
the sub-pixel summit [pixels], of the curvatures, and of the gap f on the rays at a quarter and at
the whole of their length, for the quintic spline in use and for two usual local choices.
"""

from __future__ import annotations

import numpy as np
from common import options, rough
from scipy import ndimage
from scipy.spatial import cKDTree

import surfaces

N, TIMES = 192, 6


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
    hm = rough((N, N), cutoff, 3)
    fine = surfaces.resample(hm, hm.spacing[0] / TIMES)
    coarse_fit = surfaces.fit_profiles(hm, surfaces.segment(hm))
    fine_fit = surfaces.fit_profiles(fine, surfaces.segment(fine))
    place = np.stack([fine_fit.y, fine_fit.x], axis=1) % N
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
            at = [(p[:, None] + r * turn) * scale - 0.5 for p, turn in ((y, sin), (x, cos))]  # noqa: B023
            return ndimage.map_coordinates(
                spline, at, order=order, mode="grid-wrap", prefilter=False
            )

        truth = fine_fit.height[match, None] - read(fine_spline, 5, *place[match].T, TIMES)
        y, x = mine[good].T
        height = coarse_fit.height[good, None]
        choices = {
            "quintic spline": coarse_fit.q[good][:, :, node] * r**2,
            "cubic spline": height - read(cubic_spline, 3, y, x, 1),
            "Catmull-Rom": height
            - catmull_rom(hm.heights, y[:, None] + r * sin - 0.5, x[:, None] + r * cos - 0.5),
        }
        for name, f in choices.items():
            print(f"  f, t = {coarse_fit.t[node]:4.2f} {name:<15}{quantiles(f / truth - 1)}")


if __name__ == "__main__":
    parser = options(__doc__)
    parser.add_argument(
        "cutoffs", type=float, nargs="*", default=[4.0, 6.0, 8.0, 16.0], help="[pixels]"
    )
    for cutoff in parser.parse_args().cutoffs:
        row(cutoff)
