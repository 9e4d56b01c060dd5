"""Roughness parameters of a map: heights, slopes, bearing curve, spectrum and texture."""

from __future__ import annotations

import csv
import json
import math
import os
from dataclasses import dataclass
from typing import NamedTuple

from surfaces.checks import tilt_warning, unit_warning
from surfaces.errors import SurfaceError
from surfaces.files.atomic import replacing
from surfaces.heightmap import HeightMap, require_map
from surfaces.peaks.segmentation import require_wolf

from .bearing import BearingCurve, bearing_curve
from .correlation import Autocorrelation, Texture, autocorrelation, texture
from .density import density_of, texture_direction
from .differences import differences
from .features import FEATURES, features
from .heights import height_parameters
from .parameters import PARAMETERS
from .spectrum import SpectralMoments, Spectrum, spectrum_of
from .spectrum_fit import SpectrumFit, fit_spectrum

__all__ = ["Curves", "Statistics", "describe", "described"]

_RESOLVED = 0.1  # relative difference of finite differences and spectrum that is warned of
_TILTED = 0.01  # share of the height variance in the tilt that is warned of


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
        with replacing(path) as part, part.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, self.rows()[0])
            writer.writeheader()
            writer.writerows(self.rows())

    def to_json(self, path: str | os.PathLike[str]) -> None:
        """Write the table of the parameters as JSON, a list of rows; NaN is null."""
        with replacing(path) as part:
            part.write_text(json.dumps(self.rows(), indent=1), encoding="utf-8")

    def _groups(self) -> dict[str, dict[str, float]]:
        return {name: held for name, held in vars(self).items() if isinstance(held, dict)}

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
        The map. With missing points the spectral and the feature parameters are left out. Of a map
        on disk (`surfaces.SurfaceFile.on_disk`) no more than some blocks are held in memory, and
        the numbers are those of the map in memory, but for rounding; volumes of the functional
        parameters to the share of points between two of 2^20 levels times their distance.
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
    return described(hm, wolf)[0]


class Curves(NamedTuple):
    """What the parameters of a map are read from; no spectrum if points are missing."""

    bearing: BearingCurve
    correlation: Autocorrelation
    spectrum: Spectrum | None


def described(hm: HeightMap, wolf: float = 5.0) -> tuple[Statistics, Curves]:
    """As `describe`, with the curves, each of which is found once."""
    require_wolf(wolf)
    heights, hybrid, curve = height_parameters(hm), differences(hm), bearing_curve(hm)
    missing = hm.missing / hm.source.size
    spectrum, fit, hills, direction = None, None, dict.fromkeys(FEATURES, math.nan), math.nan
    warnings = [*tilt_warning(hm, _TILTED), *unit_warning(hybrid["Sdq"])]
    if missing:
        warnings.append(
            f"{100 * missing:.3g} % of the points are missing: no spectrum and features; fill them"
        )
    else:
        hills, waves = features(hm, wolf), density_of(hm)
        spectrum, direction = spectrum_of(waves), math.degrees(texture_direction(waves))
        near = differences(waves.source)  # without the plane, which no wave holds
        del waves  # as large as the map
        warnings += _resolution_warning(spectrum.moments, near["Sdq"], near["curvature"])
        try:
            fit = fit_spectrum(spectrum)
            warnings += fit.warnings
        except SurfaceError as error:
            warnings.append(f"no self-affine fit: {error}")
    correlation = autocorrelation(hm)
    lay = texture(correlation)
    if lay.bounded:
        warnings.append(
            "the correlation does not fall off within half the map: Str is a bound, and Sal that "
            "of the directions in which it does"
        )
    spatial = {"Sal": lay.shortest, "Str": lay.aspect, "Std": direction}
    found = Statistics(
        heights=heights,
        spatial=spatial | {"lay": math.degrees(lay.direction)},
        hybrid=hybrid,
        functional=curve.core() | curve.heights() | curve.volumes(),
        features=hills,
        texture=lay,
        moments=None if spectrum is None else spectrum.moments,
        fit=fit,
        missing=missing,
        warnings=tuple(warnings),
    )
    return found, Curves(curve, correlation, spectrum)


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
    return ", ".join(
        f"{name} {value:.4g} {PARAMETERS[name][0].strip('-')}".rstrip()
        for name, value in values.items()
    )
