"""Roughness parameters of a map: heights, slopes, bearing curve, spectrum and texture."""

from __future__ import annotations

import csv
import json
import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surfaces.checks import tilt_warning
from surfaces.errors import SurfaceError, as_path
from surfaces.heightmap import HeightMap, require_map
from surfaces.roughness import unit_warning

from .bearing import bearing_curve
from .correlation import Texture, autocorrelation, texture
from .features import FEATURES, features
from .parameters import PARAMETERS
from .spectrum import SpectralMoments, power_spectrum, texture_direction
from .spectrum_fit import SpectrumFit, fit_spectrum

__all__ = ["Statistics", "describe", "gradients"]

_RESOLVED = 0.1  # relative difference of finite differences and spectrum that is warned of
_TILTED = 0.01  # share of the height variance in the tilt that is warned of
_BLOCK = 200_000  # points


@dataclass(frozen=True)
class Statistics:
    """Roughness of a map; heights about the mean of the points present.

    Attributes
    ----------
    heights
        Height parameters Sq, Sa, Sp, Sv, Sz [m], Ssk, Sku [-] (ISO 25178-2:2021, 4.2).
    spatial
        Sal [m], Str [-], Std [deg] (4.3), and ``lay`` [deg].
    hybrid
        Sdq, rms gradient by finite differences [-]; Sdr, additional area [-] (4.4); ``curvature``,
        rms mean curvature by finite differences [1/m].
    functional
        Sk, Spk, Svk [m], Smr1, Smr2, Smr [-], Smc, Sxp, Vm, Vv, Vmp, Vmc, Vvc, Vvv [m] (4.5).
    features
        Spd, Svd [1/m^2], Spc, Svc [1/m], S5p, S5v, S10z [m], Sha, Sda [m^2], Shv, Sdv [m^3]
        (clause 5), see `features.features`; NaN if points are missing.
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

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> sorted(surfaces.describe(hm).heights)
    ['Sa', 'Sku', 'Sp', 'Sq', 'Ssk', 'Sv', 'Sz']
    """

    heights: dict[str, float]
    spatial: dict[str, float]
    hybrid: dict[str, float]
    functional: dict[str, float]
    features: dict[str, float]
    texture: Texture
    moments: SpectralMoments | None
    fit: SpectrumFit | None
    missing: float
    warnings: tuple[str, ...]

    @property
    def parameters(self) -> dict[str, float]:
        """All parameters by their symbols, in the order and units of `PARAMETERS`."""
        found = {name: value for group in self._groups().values() for name, value in group.items()}
        return {name: found[name] for name in PARAMETERS}

    def rows(self) -> list[dict[str, str | float | None]]:
        """Table of the parameters: symbol, value (None if NaN), unit and meaning of each."""
        return [
            {
                "parameter": name,
                "value": None if math.isnan(value) else value,
                "unit": PARAMETERS[name][0],
                "meaning": PARAMETERS[name][1],
            }
            for name, value in self.parameters.items()
        ]

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the table of the parameters as CSV; NaN is an empty cell."""
        with as_path(path).open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, self.rows()[0])
            writer.writeheader()
            writer.writerows(self.rows())

    def to_json(self, path: str | os.PathLike[str]) -> None:
        """Write the table of the parameters as JSON, a list of rows; NaN is null."""
        as_path(path).write_text(json.dumps(self.rows(), indent=1), encoding="utf-8")

    def _groups(self) -> dict[str, dict[str, float]]:
        return {
            "heights": self.heights,
            "spatial": self.spatial,
            "hybrid": self.hybrid,
            "functional": self.functional,
            "features": self.features,
        }

    def __str__(self) -> str:
        rows = [(group, _listed(values)) for group, values in self._groups().items()]
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

    __repr__ = __str__


def describe(hm: HeightMap, *, wolf: float = 5.0) -> Statistics:
    """Roughness statistics of a map as it is; it should be levelled first.

    Parameters
    ----------
    hm
        The map. With missing points the spectral and the feature parameters are left out.
    wolf
        Smallest height of a hill above its saddle, and depth of a dale, in percent of Sz, for the
        feature parameters (Wolf pruning, 5 % in ISO 25178-3).

    Raises
    ------
    SurfaceError
        If the map is constant.

    References
    ----------
    ISO 25178-2:2021, clauses 4 and 5; defaults of ISO 25178-3.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> found = surfaces.describe(hm)
    >>> f"{found.heights['Sq'] / hm.rms_height:.3f}"
    '1.000'
    """
    require_map(hm)
    z = hm.heights[np.isfinite(hm.heights)]
    if np.ptp(z) == 0.0:
        raise SurfaceError("the map is constant; it has no roughness")
    z = z - z.mean()
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
    found = texture(autocorrelation(hm))
    spatial = {"Sal": found.shortest, "Str": found.aspect, "Std": math.nan}
    spatial["lay"] = math.degrees(found.direction)
    moments, fit, hills = None, None, dict.fromkeys(FEATURES, math.nan)
    warnings = [*tilt_warning(hm, _TILTED), *unit_warning(slope)]
    if hm.missing:
        share = 100 * hm.missing / hm.heights.size
        warnings.append(
            f"{share:.3g} % of the points are missing: no spectrum and features; fill them"
        )
    else:
        spectrum = power_spectrum(hm)
        moments = spectrum.moments
        spatial["Std"] = math.degrees(texture_direction(hm))
        hills = features(hm, wolf)
        warnings += _resolution_warning(moments, slope, curvature)
        try:
            fit = fit_spectrum(spectrum)
        except SurfaceError as error:
            warnings.append(f"no self-affine fit: {error}")
    if found.bounded:
        warnings.append("the correlation does not fall off within half the map: Str is a bound")
    return Statistics(
        heights=heights,
        spatial=spatial,
        hybrid=hybrid,
        functional=curve.core() | curve.heights() | curve.volumes(),
        features=hills,
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
    slopes_y, slopes_x, bends = _Mean(), _Mean(), _Mean()
    for z in _blocks(hm):
        middle = z[1:-1, 1:-1]
        slopes_y.add(np.square((z[2:, 1:-1] - middle) / dy))
        slopes_x.add(np.square((z[1:-1, 2:] - middle) / dx))
        bend = (z[2:, 1:-1] + z[:-2, 1:-1] - 2.0 * middle) / dy**2
        bend += (z[1:-1, 2:] + z[1:-1, :-2] - 2.0 * middle) / dx**2
        bends.add(np.square(bend))
    return math.sqrt(slopes_y.value + slopes_x.value), 0.5 * math.sqrt(bends.value)


class _Mean:
    """Mean of the numbers present in arrays that come one after the other."""

    def __init__(self) -> None:
        self.total, self.count = 0.0, 0

    def add(self, values: NDArray[np.float64]) -> None:
        self.total += float(np.nansum(values))
        self.count += values.size - int(np.count_nonzero(np.isnan(values)))

    @property
    def value(self) -> float:
        return self.total / self.count if self.count else math.nan


def _blocks(hm: HeightMap) -> Iterator[NDArray[np.float64]]:
    """Rows of the map in blocks that fit the cache, each with one more point on every side.

    Beyond the border of a map that is not periodic there are missing points.
    """
    border: dict[str, Any] = {"mode": "wrap"} if hm.periodic else {"constant_values": np.nan}
    above = hm.heights[-1:] if hm.periodic else np.full((1, hm.shape[1]), np.nan)
    below = hm.heights[:1] if hm.periodic else above
    rows = max(1, _BLOCK // hm.shape[1])
    for start in range(0, hm.shape[0], rows):
        stop = min(start + rows, hm.shape[0])
        top = hm.heights[start - 1 : start] if start else above
        bottom = hm.heights[stop : stop + 1] if stop < hm.shape[0] else below
        block = np.vstack([top, hm.heights[start:stop], bottom])
        yield np.pad(block, ((0, 0), (1, 1)), **border)


def _developed(hm: HeightMap) -> float:
    """Additional area of the triangulated surface over its projection, Sdr [-]."""
    dy, dx = hm.spacing
    area = _Mean()
    for z in _blocks(hm):
        step_y, step_x = np.diff(z[1:, 1:], axis=0) / dy, np.diff(z[1:, 1:]) / dx
        step_y, step_x = np.square(step_y) + 1.0, np.square(step_x)
        ends = (slice(None, -1), slice(1, None))
        corners = [np.sqrt(step_y[:, one] + step_x[other]) for one in ends for other in ends]
        area.add(np.mean(corners, axis=0))
    return area.value - 1.0


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
                f"rms {name} by finite differences is {100 * abs(short):.0f} % {where} the "
                f"spectral one: {why}"
            )
    return found


def _listed(values: dict[str, float]) -> str:
    return ", ".join(f"{name} {value:.4g}" for name, value in values.items())
