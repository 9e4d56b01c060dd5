"""Figures of height maps: peaks and basins, spectrum with fit, profile fans, bearing curve.

Every function returns a matplotlib `Figure` that belongs to no window; ``figure.savefig(path)``
writes it.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter, MaxNLocator

from surfaces.arrays import Array
from surfaces.peaks.peaks import Peaks, require_peaks
from surfaces.peaks.profiles import Profiles
from surfaces.statistics.bearing import BearingCurve
from surfaces.statistics.correlation import THRESHOLD, Autocorrelation
from surfaces.statistics.spectrum import Spectrum
from surfaces.statistics.spectrum_fit import SpectrumFit

from .drawing import draw_field, figure_height, prefixed_unit, thinning
from .errors import InputError, as_count, require_kind
from .heightmap import HeightMap, require_map

__all__ = ["plot_autocorrelation", "plot_bearing", "plot_map", "plot_profiles", "plot_spectrum"]

_NAMED = 400  # peaks that are marked
_INK = "#1f2a33"
_ACCENT = "#d1495b"
_QUIET = "#8a97a0"


def plot_map(hm: HeightMap, peaks: Peaks | None = None) -> Figure:
    """The map in true proportions, with the summits and the borders of the basins of its peaks.

    Parameters
    ----------
    hm
        The map; missing points are drawn white.
    peaks
        Peaks to mark. Of more than 400 the most prominent 400 are marked; all basins are outlined.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> figure = surfaces.plot_map(hm, surfaces.segment(hm))
    >>> len(figure.axes[0].images)
    2
    """
    require_map(hm)
    width = 6.4
    height = figure_height(width - 2.3, hm.size) + 0.8  # text beside it takes up to 2.3
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = hm.plot(figure.add_subplot())
    if peaks is not None:
        require_peaks(peaks, hm)
        _mark(axes, peaks, thinning(hm.shape), (0.0, hm.size[1], 0.0, hm.size[0]))
    return figure


def plot_spectrum(spectrum: Spectrum, fit: SpectrumFit | None = None) -> Figure:
    """Density of the rings over the wave number, the axes' profiles, and the fitted model.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> figure = surfaces.plot_spectrum(surfaces.power_spectrum(hm))
    >>> figure.axes[0].get_xscale()
    'log'
    """
    require_kind(spectrum, Spectrum, "surfaces.power_spectrum(hm)")
    if fit is not None:
        require_kind(fit, SpectrumFit, "surfaces.fit_spectrum(spectrum)")
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.add_subplot()
    seen = spectrum.seen
    axes.loglog(spectrum.q[seen], spectrum.density[seen], "o", ms=3.5, color=_INK, label="rings")
    if fit is not None:
        label = f"fit, H = {fit.hurst:.2f} $\\pm$ {fit.hurst_error:.2g}"
        label += " (doubtful)" if fit.warnings else ""
        axes.loglog(fit.q, fit.density, color=_ACCENT, lw=1.6, label=label)
        for wavelength, name in ((fit.rolloff, "roll-off"), (fit.cutoff, "cut-off")):
            if np.isfinite(wavelength):
                axes.axvline(2.0 * np.pi / wavelength, color=_QUIET, lw=0.8, ls="--")
                axes.annotate(
                    f" {name} {EngFormatter('m', places=1)(wavelength)}",
                    (2.0 * np.pi / wavelength, 0.02),
                    xycoords=("data", "axes fraction"),
                    rotation=90,
                    fontsize=8,
                    color=_INK,
                    ha="right",
                )
    axes.set_xlabel("wave number 2$\\pi$/$\\lambda$ [rad/m]")
    axes.set_ylabel("power spectral density [m$^4$]")
    axes.legend(frameon=False)
    axes.grid(alpha=0.25)
    return figure


def plot_profiles(profiles: Profiles, chosen: Iterable[int]) -> Figure:
    """Fans of chosen peaks: gap f over the distance from the summit, one line per ray.

    Parameters
    ----------
    profiles
        From `surfaces.fit_profiles`.
    chosen
        Indices of up to nine peaks, from 0 on.

    Raises
    ------
    InputError
        If there is no such peak, or more than nine are chosen.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> profiles = surfaces.fit_profiles(hm, surfaces.segment(hm))
    >>> figure = surfaces.plot_profiles(profiles, [0, 1])
    >>> len(figure.axes)
    2
    """
    require_kind(profiles, Profiles, "surfaces.fit_profiles(hm, peaks)")
    require_kind(chosen, Iterable, "the numbers of some peaks")
    indices = [as_count("a chosen peak", index, 0) for index in chosen]
    if len(indices) > 9:
        raise InputError(f"{len(indices)} peaks are chosen; give up to nine")
    if max(indices, default=-1) >= len(profiles):
        raise InputError(f"there is no peak {max(indices)} among the {len(profiles)}, from 0 on")
    columns = min(3, len(indices)) or 1
    rows = -(-len(indices) // columns) or 1
    figure = Figure(figsize=(2.9 * columns + 0.6, 2.5 * rows + 0.3), layout="constrained")
    gap = profiles.f()
    for place, index in enumerate(indices):
        axes = figure.add_subplot(rows, columns, place + 1)
        lengths = profiles.t * profiles.edge[index][:, None]
        scale, unit = prefixed_unit(float(gap[index].max()), "m")
        turn = (profiles.phi[index] - profiles.angle[index]) % (2.0 * np.pi)
        for ray, angle in enumerate(turn):
            color = _ray_color(float(angle))
            axes.plot(lengths[ray], gap[index, ray] / scale, color=color, lw=1.0)
        axes.invert_yaxis()
        axes.xaxis.set_major_locator(MaxNLocator(4))
        axes.xaxis.set_major_formatter(EngFormatter(unit="m"))
        axes.tick_params(labelsize=7)
        axes.set_ylabel(f"f [{unit}]", fontsize=8)
        axes.set_title(
            f"peak {index}" + ("" if profiles.valid[index] else ", not resolved"), size=9
        )
        axes.grid(alpha=0.25)
    figure.supxlabel(
        "distance from the summit; dark along the long axis of the contact", fontsize=8
    )
    return figure


def plot_bearing(curve: BearingCurve) -> Figure:
    """Height over material ratio, with the core between its reduced peaks and dales.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> figure = surfaces.plot_bearing(surfaces.bearing_curve(hm))
    >>> len(figure.axes) > 0
    True
    """
    require_kind(curve, BearingCurve, "surfaces.bearing_curve(hm)")
    figure = Figure(figsize=(6.4, 3.4), layout="constrained")
    axes = figure.add_subplot()
    scale, unit = prefixed_unit(float(np.abs(curve.height).max()), "m")
    axes.plot(100.0 * curve.ratio, curve.height / scale, color=_INK, lw=1.6)
    core = curve.core()
    for ratio in (core["Smr1"], core["Smr2"]):
        axes.axhline(curve.height_at(ratio) / scale, color=_ACCENT, lw=0.9, ls="--")
    axes.set_xlabel("material ratio [%]")
    axes.set_ylabel(f"height [{unit}]")
    axes.set_xlim(0.0, 100.0)
    axes.grid(alpha=0.25)
    return figure


def plot_autocorrelation(correlation: Autocorrelation) -> Figure:
    """Correlation over shifts along x and y, with the contour at which Sal and Str are read.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> figure = surfaces.plot_autocorrelation(surfaces.autocorrelation(hm))
    >>> len(figure.axes) > 0
    True
    """
    require_kind(correlation, Autocorrelation, "surfaces.autocorrelation(hm)")
    # of each axis alone, or few lines are left of a slim map; the peak in the middle is drawn
    steps = [(n, thinning((n,))) for n in correlation.value.shape]
    rows, columns = (slice(n // 2 % step, None, step) for n, step in steps)
    lag_y, lag_x = correlation.lag_y[rows], correlation.lag_x[columns]
    value, (length_y, length_x) = correlation.value[rows, columns], correlation.size
    figure = Figure(figsize=(6.4, 4.6), layout="constrained")
    axes = draw_field(
        figure.add_subplot(),
        value,
        correlation.size,
        f"correlation; line at {THRESHOLD:g}",
        "",
        origin=(-0.5 * length_y, -0.5 * length_x),
        cmap="RdGy_r",
        vmin=-1.0,
        vmax=1.0,
    )
    axes.contour(lag_x, lag_y, value, levels=[THRESHOLD], colors=[_INK], linewidths=1.0)
    axes.locator_params(nbins=5)
    axes.set(xlabel="shift along x", ylabel="shift along y")
    return figure


def _mark(axes: Axes, peaks: Peaks, stride: int, extent: tuple[float, float, float, float]) -> None:
    labels = peaks.labels[::stride, ::stride]
    edge = np.zeros((*labels.shape, 4))
    edge[..., :3] = 1.0
    edge[:-1, :, 3] = labels[:-1] != labels[1:]
    edge[:, :-1, 3] = np.maximum(edge[:, :-1, 3], labels[:, :-1] != labels[:, 1:])
    edge[..., 3] *= 0.55
    axes.imshow(edge, origin="lower", extent=extent, aspect="equal", interpolation="nearest")
    order = np.argsort(-peaks.prominence, kind="stable")[:_NAMED]
    axes.plot(
        peaks.x[order], peaks.y[order], "^", ms=3.0, mfc=_ACCENT, mec="white", mew=0.4, ls="none"
    )
    count = f"{len(peaks)} peaks"
    axes.set_title(
        count + (f", the {_NAMED} most prominent marked" if len(peaks) > _NAMED else ""), size=10
    )


def _ray_color(angle: float) -> Array:
    """Dark along the long axis of the contact, light across it."""
    share = np.sin(angle) ** 2
    dark, light = np.array([0.12, 0.16, 0.20]), np.array([0.82, 0.29, 0.36])
    return np.asarray(dark + share * (light - dark))
