"""Compare statistics and spectra with SurfaceTopography on the same maps.

``python benchmarks/statistics_against_surfacetopography.py ../shared/measured/*.h5`` prints one row
per quantity and map: ours, theirs, relative difference. Needs the extra ``asperity[formats]``.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from common import options
from SurfaceTopography import Topography

import surfaces
from surfaces.statistics.bearing import bearing_curve
from surfaces.statistics.describe import gradients


def rows(hm: surfaces.HeightMap) -> Iterator[tuple[str, float, float]]:
    """Name, our value and theirs; heights, slopes, spectra and correlation."""
    nx, (length_y, length_x) = hm.shape[1], hm.size
    theirs = Topography(hm.heights.T, (length_x, length_y), periodic=hm.periodic, unit="m")
    spectrum = surfaces.power_spectrum(hm)
    yield "rms height", hm.rms_height, theirs.rms_height_from_area()
    slope, curvature = gradients(hm)
    yield "rms slope, differences", slope, theirs.rms_gradient()
    yield "rms curvature, differences", curvature, theirs.rms_curvature_from_area()
    q, density = theirs.power_spectrum_from_profile(
        resampling_method=None, reliable=False, window="None" if hm.periodic else "hann"
    )
    part = slice(3, nx // 4)
    yield "profile spectrum, mean ln", *_means(spectrum.density_x[2 : nx // 4 - 1], density[part])
    q, density = theirs.power_spectrum_from_area(
        collocation="log", nb_points_per_decade=10, reliable=False
    )
    used = (q > spectrum.q[3]) & (q < 0.5 * spectrum.nyquist) & ~np.ma.getmaskarray(density)
    ours = np.exp(np.interp(np.log(q[used]), np.log(spectrum.q), np.log(spectrum.density)))
    yield "ring spectrum, mean ln", *_means(ours, np.asarray(density[used]))
    if hm.periodic:
        structure = theirs.autocorrelation_from_profile(reliable=False, resampling_method=None)[1]
        found = surfaces.autocorrelation(hm)
        middle = found.value.shape[1] // 2
        along_x = found.value[found.value.shape[0] // 2, middle : middle + nx // 4]
        yield (
            "structure function, mean",
            float(np.mean(hm.rms_height**2 * (1.0 - along_x))),
            float(np.mean(np.asarray(structure)[: nx // 4])),
        )
    curve = bearing_curve(hm)
    level = curve.height_at(0.3)
    mean = float(hm.heights.mean())
    yield "bearing area at 30 %", 0.3, float(theirs.bearing_area(np.array([level + mean]))[0])


def _means(ours: np.ndarray, theirs: np.ndarray) -> tuple[float, float]:
    """Mean logarithms where there is power; beyond a sharp cut-off rounding is compared."""
    seen = (ours > 1e-9 * ours.max()) & (theirs > 1e-9 * theirs.max())
    ours, theirs = ours[seen], theirs[seen]
    return float(np.mean(np.log(ours))), float(np.mean(np.log(theirs)))


def main(paths: list[str]) -> None:
    maps = [
        surfaces.self_affine(
            (384, 512), (1e-3, 2e-3), hurst=0.8, rms_slope=0.1, rolloff=2e-4, cutoff=3e-5
        ).replace(name="synthetic, periodic")
    ]
    maps += [surfaces.prepare(surfaces.read(Path(path))) for path in paths]
    print(f"{'map':24s}{'quantity':32s}{'ours':>14s}{'theirs':>14s}{'difference':>12s}")
    for hm in maps:
        start = time.perf_counter()
        for name, ours, theirs in rows(hm):
            difference = ours - theirs if "ln" in name else ours / theirs - 1.0
            print(f"{hm.name:24s}{name:32s}{ours:14.6g}{theirs:14.6g}{difference:12.2e}")
        print(f"{hm.name:24s}{'(seconds, both)':32s}{time.perf_counter() - start:14.2f}")


if __name__ == "__main__":
    parser = options(__doc__)
    parser.add_argument("maps", nargs="*", help="surface files")
    main(parser.parse_args().maps)
