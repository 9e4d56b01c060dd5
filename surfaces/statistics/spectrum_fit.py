"""Fit of a self-affine spectrum: Hurst exponent, roll-off and cut-off, with uncertainties."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from surfaces.arrays import Array
from surfaces.errors import SurfaceError, require_kind

from .spectrum import Spectrum

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

__all__ = ["SpectrumFit", "fit_spectrum"]

_SCATTER = 0.1  # deviation of a ring, in natural logarithms, that no model describes
_SEGMENT = 3  # least rings of a part
_DECADES = 0.5  # of a power law below which exponents of exact ones are off by 30 (0.02 above)
_UNTOLD = 0.25  # standard deviation of an exponent that may be any from 0 to 1


@dataclass(frozen=True)
class SpectrumFit:
    """Self-affine model of a spectrum; uncertainties are one standard deviation.

    Attributes
    ----------
    hurst, hurst_error
        Hurst exponent H: the density falls as q^(-2 - 2H) [-].
    rolloff, rolloff_error
        Wavelength above which the density is flat [m]; NaN if the map is too small to show it.
    cutoff, cutoff_error
        Wavelength below which the density leaves the power law [m]; NaN if it does not.
    cutoff_kind
        How it leaves: ``sharp`` (nothing beyond), ``fall`` (steeper), ``floor`` (flatter, as with
        white noise), or an empty string.
    level
        Density of the power law at the shortest wavelength that it was fitted to [m^4].
    scatter
        Rms deviation of the rings from the model, in natural logarithms [-].
    q, density
        The model on the rings that were fitted [rad/m], [m^4].

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((128, 192), (1e-4, 1.5e-4), hurst=0.6, rms_slope=0.1)
    >>> fit = surfaces.fit_spectrum(surfaces.power_spectrum(hm))
    >>> abs(fit.hurst - 0.6) < 0.1
    True
    """

    hurst: float
    hurst_error: float
    rolloff: float
    rolloff_error: float
    cutoff: float
    cutoff_error: float
    cutoff_kind: str
    level: float
    scatter: float
    q: Array
    density: Array

    @property
    def self_affine(self) -> bool:
        """Whether the exponent lies between 0 and 1, within two standard deviations."""
        return -2.0 * self.hurst_error <= self.hurst <= 1.0 + 2.0 * self.hurst_error

    @property
    def decades(self) -> float:
        """Decades of wavelengths over which the power law was fitted."""
        low = np.fmax(self.q[0], 2.0 * np.pi / self.rolloff)
        high = np.fmin(self.q[-1], 2.0 * np.pi / self.cutoff)
        return float(np.log10(high / low))

    @property
    def warnings(self) -> list[str]:
        """What keeps the exponent from being trusted, one sentence each."""
        found = []
        if not self.self_affine:
            found.append(
                f"the Hurst exponent {self.hurst:.2f} is not between 0 and 1: the spectrum is that "
                "of no self-affine surface"
            )
        if self.decades < _DECADES or self.hurst_error > _UNTOLD:
            found.append(
                f"the Hurst exponent {self.hurst:.2f} +- {self.hurst_error:.2g} is that of "
                f"{self.decades:.2g} decades of wavelengths, which do not tell it"
            )
        return found

    def __str__(self) -> str:
        def shown(value: float, error: float) -> str:
            return f"{value:.4g} +- {error:.2g} m" if math.isfinite(value) else "not seen"

        kind = f" ({self.cutoff_kind})" if self.cutoff_kind else ""
        note = ", doubtful" if self.warnings else ""
        return (
            f"Hurst exponent {self.hurst:.3f} +- {self.hurst_error:.2g}, roll-off "
            f"{shown(self.rolloff, self.rolloff_error)}, cut-off "
            f"{shown(self.cutoff, self.cutoff_error)}{kind}, "
            f"scatter {100 * self.scatter:.2g} %{note}"
        )


def fit_spectrum(spectrum: Spectrum) -> SpectrumFit:
    """Fit a flat part, a power law and a third part to the rings of a spectrum.

    Parameters
    ----------
    spectrum
        From `power_spectrum`.

    Raises
    ------
    SurfaceError
        If fewer than six rings carry power.

    Notes
    -----
    Weighted least squares of ln C over ln q, continuous and piecewise linear. A ring of n modes has
    the variance 1/n + 0.1^2 (chance, and what no model describes). Roll-off and cut-off are kept
    only if each lowers the Bayesian information criterion. The covariance is scaled by the
    reduced chi-square if that exceeds one.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((128, 192), (1e-4, 1.5e-4), hurst=0.8, rms_slope=0.1)
    >>> fit = surfaces.fit_spectrum(surfaces.power_spectrum(hm))
    >>> f"{fit.hurst:.1f}"
    '0.8'
    """
    require_kind(spectrum, Spectrum, "surfaces.power_spectrum(hm)")
    sharp = spectrum.edge < 0.98 * spectrum.nyquist
    inside = spectrum.seen & (spectrum.q <= (0.9 if sharp else 1.0) * spectrum.edge)
    q, density, modes = spectrum.q[inside], spectrum.density[inside], spectrum.modes[inside]
    if len(q) < 2 * _SEGMENT:
        raise SurfaceError(
            f"{len(q)} rings of the spectrum carry power; a fit needs at least {2 * _SEGMENT}"
        )
    x, y = np.log(q / q[-1]), np.log(density / density[-1])  # the same in all units
    root = 1.0 / np.sqrt(1.0 / modes + _SCATTER**2)
    choices = [
        (parts, _refined(x, y, root, parts))
        for parts in ((False, False), (True, False), (False, True), (True, True))
        if len(x) >= _SEGMENT * (1 + sum(parts)) and not (parts[1] and sharp)
    ]
    parts, fit = min(  # Bayesian information criterion
        choices, key=lambda choice: 2.0 * choice[1].cost + choice[1].x.size * math.log(len(x))
    )
    return _described(fit, parts, q, density, spectrum, sharp)


def _model(parameters: Array, x: Array, parts: tuple[bool, bool]) -> Array:
    """ln C: level at x = 0, the last, and slope of the power law, breaks and the third slope."""
    low = parameters[2] if parts[0] else -np.inf
    high, last = parameters[-2:] if parts[1] else (np.inf, 0.0)
    return np.asarray(_shapes(x, low, high) @ [*parameters[:2], last])


def _shapes(x: Array, low: float, high: float) -> Array:
    """What level, slope and third slope are the factors of, for breaks that may be infinite."""
    return np.stack([np.ones_like(x), np.clip(x, low, high), np.maximum(x - high, 0.0)], axis=1)


def _refined(x: Array, y: Array, root: Array, parts: tuple[bool, bool]) -> OptimizeResult:
    """Best breaks among the rings, then between them, by least squares."""
    from scipy.optimize import least_squares

    places = range(_SEGMENT - 1, len(x) - _SEGMENT + 1)
    lows = places if parts[0] else [0]
    highs = places if parts[1] else [len(x) - 1]
    starts: list[tuple[float, list[float]]] = []
    for low, high in itertools.product(lows, highs):
        if high - low < _SEGMENT - 1:
            continue
        shapes = _shapes(x, x[low] if parts[0] else -np.inf, x[high] if parts[1] else np.inf)
        matrix = shapes * root[:, None]
        level, slope, last = np.linalg.lstsq(matrix, y * root, rcond=None)[0]
        start = [level, slope]
        start += [x[low]] * parts[0]
        start += [x[high], last] * parts[1]
        starts.append((float(np.sum((matrix @ [level, slope, last] - y * root) ** 2)), start))
    return least_squares(lambda p: root * (_model(p, x, parts) - y), min(starts)[1])


def _described(
    fit: OptimizeResult,
    parts: tuple[bool, bool],
    q: Array,
    density: Array,
    spectrum: Spectrum,
    sharp: bool,
) -> SpectrumFit:
    parameters, model = fit.x, density[-1] * np.exp(_model(fit.x, np.log(q / q[-1]), parts))
    freedom = max(1, len(q) - len(parameters))
    scale = max(1.0, 2.0 * fit.cost / freedom)
    errors = np.sqrt(np.diag(np.linalg.pinv(fit.jac.T @ fit.jac)) * scale)
    hurst, hurst_error = -0.5 * parameters[1] - 1.0, 0.5 * errors[1]
    rolloff = rolloff_error = cutoff = cutoff_error = math.nan
    kind = ""
    if parts[0]:
        rolloff = float(2.0 * math.pi / (q[-1] * math.exp(parameters[2])))
        rolloff_error = rolloff * float(errors[2])
    if sharp:
        kind = "sharp"
        cutoff = 2.0 * math.pi / spectrum.edge
        modes_off = 0.5 if spectrum.window == "none" else 1.5
        step = max(float(spectrum.qx[0]), float(spectrum.qy[0]))
        cutoff_error = cutoff * modes_off * step / spectrum.edge
    elif parts[1]:
        kind = "fall" if parameters[-1] < parameters[1] else "floor"
        cutoff = float(2.0 * math.pi / (q[-1] * math.exp(parameters[-2])))
        cutoff_error = cutoff * float(errors[-2])
    return SpectrumFit(
        hurst=float(hurst),
        hurst_error=float(hurst_error),
        rolloff=rolloff,
        rolloff_error=rolloff_error,
        cutoff=cutoff,
        cutoff_error=cutoff_error,
        cutoff_kind=kind,
        level=float(density[-1] * math.exp(parameters[0])),
        scatter=float(np.sqrt(np.mean(np.log(density / model) ** 2))),
        q=q,
        density=model,
    )
