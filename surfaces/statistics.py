"""How rough a map is: heights, slopes, curvatures, bearing curve, spectrum and texture."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .bearing import bearing_curve
from .correlation import Texture, autocorrelation, texture
from .errors import SurfaceError
from .heightmap import HeightMap
from .levelling import level
from .spectrum import SpectralMoments, power_spectrum
from .spectrum_fit import SpectrumFit, fit_spectrum

__all__ = ["Statistics", "describe", "gradients"]

_RESOLVED = 0.1
_TILTED = 0.01


@dataclass(frozen=True)
class Statistics:
    """Roughness of a map; heights about the mean of the points present.

    Attributes
    ----------
    heights
        ISO 25178-2 height parameters Sq, Sa, Sp, Sv, Sz [m], Ssk, Sku [-].
    hybrid
        Sdq, rms gradient by finite differences [-]; Sdr, additional area [-]; ``curvature``, rms
        mean curvature by finite differences [1/m].
    functional
        Sk, Spk, Svk [m], Smr1, Smr2 [-], Vmp, Vmc, Vvc, Vvv [m].
    texture
        Sal, Str and the lay.
    moments
        Spectral moments (slope, curvature and Nayak parameter among them); None if points are
        missing.
    fit
        Hurst exponent, roll-off and cut-off; None if points are missing or the map is too small.
    missing
        Fraction of the points that are missing [-].
    warnings
        What keeps these numbers from being trusted, one sentence each.
    """

    heights: dict[str, float]
    hybrid: dict[str, float]
    functional: dict[str, float]
    texture: Texture
    moments: SpectralMoments | None
    fit: SpectrumFit | None
    missing: float
    warnings: tuple[str, ...]

    def __str__(self) -> str:
        rows = [(group, _listed(values)) for group, values in self._groups()]
        if self.moments is not None:
            spectral = (
                f"rms slope {self.moments.rms_slope:.4g}, rms curvature "
                f"{self.moments.rms_curvature:.4g} 1/m, Nayak {self.moments.nayak:.4g}, "
                f"slope ratio {self.moments.slope_ratio:.3g}"
            )
            rows.append(("spectral", spectral))
        if self.fit is not None:
            rows.append(("self-affine", str(self.fit)))
        rows += [("warning", warning) for warning in self.warnings]
        return "\n".join(f"{name:12s}{text}" for name, text in rows)

    def _groups(self) -> list[tuple[str, dict[str, float]]]:
        spatial = {
            "Sal": self.texture.shortest,
            "Str": self.texture.aspect,
            "lay_deg": math.degrees(self.texture.direction),
        }
        return [
            ("heights", self.heights),
            ("hybrid", self.hybrid),
            ("functional", self.functional),
            ("spatial", spatial),
        ]


def describe(hm: HeightMap) -> Statistics:
    """Roughness statistics of a map as it is; it should be levelled first.

    Parameters
    ----------
    hm
        The map. With missing points the spectral parameters are left out.

    Raises
    ------
    SurfaceError
        If the map is constant.
    """
    z = hm.heights[np.isfinite(hm.heights)]
    z = z - z.mean()
    if not z.any():
        raise SurfaceError("the map is constant; it has no roughness")
    square = z * z
    sq = float(np.sqrt(np.mean(square)))
    heights = {
        "Sq": sq,
        "Sa": float(np.mean(np.abs(z))),
        "Ssk": float(np.mean(square * z)) / sq**3,
        "Sku": float(np.mean(square * square)) / sq**4,
        "Sp": float(z.max()),
        "Sv": float(-z.min()),
        "Sz": float(np.ptp(z)),
    }
    slope, curvature = gradients(hm)
    hybrid = {"Sdq": slope, "Sdr": _developed(hm), "curvature": curvature}
    curve = bearing_curve(hm)
    moments, fit = None, None
    warnings = _tilt_warning(hm, sq)
    if hm.missing:
        share = 100 * hm.missing / hm.heights.size
        warnings.append(f"{share:.3g} % of the points are missing: no spectrum; fill them first")
    else:
        spectrum = power_spectrum(hm)
        moments = spectrum.moments
        warnings += _resolution_warning(moments, slope, curvature)
        try:
            fit = fit_spectrum(spectrum)
        except SurfaceError as error:
            warnings.append(f"no self-affine fit: {error}")
    found = texture(autocorrelation(hm))
    if found.bounded:
        warnings.append("the correlation does not fall off within half the map: Str is a bound")
    return Statistics(
        heights=heights,
        hybrid=hybrid,
        functional=curve.core() | curve.volumes(),
        texture=found,
        moments=moments,
        fit=fit,
        missing=hm.missing / hm.heights.size,
        warnings=tuple(warnings),
    )


def gradients(hm: HeightMap) -> tuple[float, float]:
    """Rms gradient [-] and rms mean curvature [1/m] by finite differences.

    Parameters
    ----------
    hm
        The map; differences that meet a missing point are left out.

    Notes
    -----
    Forward differences, and (h_xx + h_yy) / 2 of second central differences; around the seam only
    for a periodic map. Both fall below the spectral values where waves of a few pixels count.
    """
    dy, dx = hm.spacing
    along_y, along_x = _differences(hm)
    slope = math.sqrt(_mean_square(along_y / dy) + _mean_square(along_x / dx))
    z = np.pad(hm.heights, 1, mode="wrap") if hm.periodic else hm.heights
    middle = z[1:-1, 1:-1]
    bend_y = (z[2:, 1:-1] + z[:-2, 1:-1] - 2.0 * middle) / dy**2
    bend_x = (z[1:-1, 2:] + z[1:-1, :-2] - 2.0 * middle) / dx**2
    return slope, 0.5 * math.sqrt(_mean_square(bend_y + bend_x))


def _differences(hm: HeightMap) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Steps between neighbors along y and x."""
    if hm.periodic:
        return (
            np.roll(hm.heights, -1, axis=0) - hm.heights,
            np.roll(hm.heights, -1, axis=1) - hm.heights,
        )
    return np.diff(hm.heights, axis=0), np.diff(hm.heights, axis=1)


def _mean_square(values: NDArray[np.float64]) -> float:
    present = values[np.isfinite(values)]
    return float(np.mean(np.square(present))) if present.size else float("nan")


def _developed(hm: HeightMap) -> float:
    """Additional area of the triangulated surface over its projection, Sdr [-]."""
    dy, dx = hm.spacing
    z = np.pad(hm.heights, ((0, 1), (0, 1)), mode="wrap") if hm.periodic else hm.heights
    step_y, step_x = np.diff(z, axis=0) / dy, np.diff(z, axis=1) / dx
    total = [
        np.sqrt(1.0 + np.square(step_y[:, columns]) + np.square(step_x[rows]))
        for rows in (slice(None, -1), slice(1, None))
        for columns in (slice(None, -1), slice(1, None))
    ]
    mean = np.mean(total, axis=0)
    return float(np.mean(mean[np.isfinite(mean)])) - 1.0


def _tilt_warning(hm: HeightMap, sq: float) -> list[str]:
    if hm.periodic:
        return []
    share = 1.0 - (level(hm, "plane").rms_height / sq) ** 2
    if share < _TILTED:
        return []
    return [f"a plane makes up {100 * share:.3g} % of the variance: level the map first"]


def _resolution_warning(moments: SpectralMoments, slope: float, curvature: float) -> list[str]:
    """Finite differences fall short where the pixels do not resolve the shortest waves."""
    found = []
    for name, spectral, finite in (
        ("slope", moments.rms_slope, slope),
        ("curvature", moments.rms_curvature, curvature),
    ):
        short = 1.0 - finite / spectral if spectral > 0.0 else 0.0
        if abs(short) > _RESOLVED:
            where, why = (
                ("below", "the pixels do not resolve the shortest waves")
                if short > 0.0
                else ("above", "there are spikes, or the border differs from the middle")
            )
            found.append(
                f"rms {name} by finite differences is {100 * abs(short):.2g} % {where} the "
                f"spectral one: {why}"
            )
    return found


def _listed(values: dict[str, float]) -> str:
    return ", ".join(f"{name} {value:.4g}" for name, value in values.items())
