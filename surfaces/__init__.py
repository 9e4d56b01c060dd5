"""Height maps of rough surfaces: files, synthesis, preparation, statistics, peaks, profiles."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .errors import AsperityError as AsperityError
    from .errors import FileFormatError as FileFormatError
    from .errors import InputError as InputError
    from .errors import SurfaceError as SurfaceError
    from .files.formats import read as read
    from .files.formats import write as write
    from .files.hdf5 import Fault as Fault
    from .files.hdf5 import SurfaceFile as SurfaceFile
    from .files.hdf5 import open as open
    from .files.hdf5 import validate as validate
    from .files.hdf5_write import write_blocks as write_blocks
    from .heightmap import HeightMap as HeightMap
    from .peaks.peaks import Peaks as Peaks
    from .peaks.profiles import Profiles as Profiles
    from .peaks.segmentation import segment as segment
    from .peaks.summits import fit_profiles as fit_profiles
    from .plot import plot_autocorrelation as plot_autocorrelation
    from .plot import plot_bearing as plot_bearing
    from .plot import plot_map as plot_map
    from .plot import plot_profiles as plot_profiles
    from .plot import plot_spectrum as plot_spectrum
    from .polar import PolarProfile as PolarProfile
    from .polar import PolynomialProfile as PolynomialProfile
    from .polar import PowerLawProfile as PowerLawProfile
    from .polar import PowerSumProfile as PowerSumProfile
    from .preparation.filling import fill_missing as fill_missing
    from .preparation.filtering import bandpass as bandpass
    from .preparation.filtering import crop as crop
    from .preparation.filtering import make_periodic as make_periodic
    from .preparation.filtering import resample as resample
    from .preparation.levelling import level as level
    from .preparation.outliers import mark_outliers as mark_outliers
    from .preparation.prepare import prepare as prepare
    from .statistics.bearing import BearingCurve as BearingCurve
    from .statistics.bearing import bearing_curve as bearing_curve
    from .statistics.correlation import Autocorrelation as Autocorrelation
    from .statistics.correlation import Texture as Texture
    from .statistics.correlation import autocorrelation as autocorrelation
    from .statistics.correlation import texture as texture
    from .statistics.describe import Statistics as Statistics
    from .statistics.describe import describe as describe
    from .statistics.spectrum import SpectralMoments as SpectralMoments
    from .statistics.spectrum import Spectrum as Spectrum
    from .statistics.spectrum import power_spectrum as power_spectrum
    from .statistics.spectrum import power_spectrum_2d as power_spectrum_2d
    from .statistics.spectrum_fit import SpectrumFit as SpectrumFit
    from .statistics.spectrum_fit import fit_spectrum as fit_spectrum
    from .synthesis import self_affine as self_affine
    from .textures import ground as ground
    from .textures import plateau_honed as plateau_honed
    from .textures import redistribute as redistribute
    from .textures import turned as turned
    from .textures import two_scale as two_scale

_HOME = {
    "AsperityError": "errors",
    "Autocorrelation": "statistics.correlation",
    "BearingCurve": "statistics.bearing",
    "Fault": "files.hdf5",
    "FileFormatError": "errors",
    "HeightMap": "heightmap",
    "InputError": "errors",
    "Peaks": "peaks.peaks",
    "PolarProfile": "polar",
    "PolynomialProfile": "polar",
    "PowerLawProfile": "polar",
    "PowerSumProfile": "polar",
    "Profiles": "peaks.profiles",
    "SpectralMoments": "statistics.spectrum",
    "Spectrum": "statistics.spectrum",
    "SpectrumFit": "statistics.spectrum_fit",
    "Statistics": "statistics.describe",
    "SurfaceError": "errors",
    "SurfaceFile": "files.hdf5",
    "Texture": "statistics.correlation",
    "autocorrelation": "statistics.correlation",
    "bandpass": "preparation.filtering",
    "bearing_curve": "statistics.bearing",
    "crop": "preparation.filtering",
    "describe": "statistics.describe",
    "fill_missing": "preparation.filling",
    "fit_profiles": "peaks.summits",
    "fit_spectrum": "statistics.spectrum_fit",
    "ground": "textures",
    "level": "preparation.levelling",
    "make_periodic": "preparation.filtering",
    "mark_outliers": "preparation.outliers",
    "open": "files.hdf5",
    "plateau_honed": "textures",
    "plot_autocorrelation": "plot",
    "plot_bearing": "plot",
    "plot_map": "plot",
    "plot_profiles": "plot",
    "plot_spectrum": "plot",
    "power_spectrum": "statistics.spectrum",
    "power_spectrum_2d": "statistics.spectrum",
    "prepare": "preparation.prepare",
    "read": "files.formats",
    "redistribute": "textures",
    "resample": "preparation.filtering",
    "segment": "peaks.segmentation",
    "self_affine": "synthesis",
    "texture": "statistics.correlation",
    "turned": "textures",
    "two_scale": "textures",
    "validate": "files.hdf5",
    "write": "files.formats",
    "write_blocks": "files.hdf5_write",
}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f".{_HOME[name]}", __name__), name)


def __dir__() -> list[str]:
    return __all__
