"""Height maps of rough surfaces: files, synthesis, preparation, statistics, peaks, profiles."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .bearing import BearingCurve as BearingCurve
    from .bearing import bearing_curve as bearing_curve
    from .correlation import Autocorrelation as Autocorrelation
    from .correlation import Texture as Texture
    from .correlation import autocorrelation as autocorrelation
    from .correlation import texture as texture
    from .errors import FileFormatError as FileFormatError
    from .errors import InputError as InputError
    from .errors import SurfaceError as SurfaceError
    from .filling import fill_missing as fill_missing
    from .filtering import bandpass as bandpass
    from .filtering import crop as crop
    from .filtering import make_periodic as make_periodic
    from .filtering import resample as resample
    from .formats import read as read
    from .formats import write as write
    from .hdf5 import Fault as Fault
    from .hdf5 import SurfaceFile as SurfaceFile
    from .hdf5 import open as open
    from .hdf5 import validate as validate
    from .hdf5_write import write_blocks as write_blocks
    from .heightmap import HeightMap as HeightMap
    from .levelling import level as level
    from .outliers import mark_outliers as mark_outliers
    from .peaks import Peaks as Peaks
    from .plot import plot_autocorrelation as plot_autocorrelation
    from .plot import plot_bearing as plot_bearing
    from .plot import plot_map as plot_map
    from .plot import plot_profiles as plot_profiles
    from .plot import plot_spectrum as plot_spectrum
    from .polar import PolarProfile as PolarProfile
    from .polar import PolynomialProfile as PolynomialProfile
    from .polar import PowerLawProfile as PowerLawProfile
    from .polar import PowerSumProfile as PowerSumProfile
    from .preparation import prepare as prepare
    from .profiles import Profiles as Profiles
    from .segmentation import segment as segment
    from .spectrum import SpectralMoments as SpectralMoments
    from .spectrum import Spectrum as Spectrum
    from .spectrum import power_spectrum as power_spectrum
    from .spectrum import power_spectrum_2d as power_spectrum_2d
    from .spectrum_fit import SpectrumFit as SpectrumFit
    from .spectrum_fit import fit_spectrum as fit_spectrum
    from .statistics import Statistics as Statistics
    from .statistics import describe as describe
    from .summits import fit_profiles as fit_profiles
    from .synthesis import self_affine as self_affine
    from .textures import ground as ground
    from .textures import plateau_honed as plateau_honed
    from .textures import redistribute as redistribute
    from .textures import turned as turned
    from .textures import two_scale as two_scale

_HOME = {
    "Autocorrelation": "correlation",
    "BearingCurve": "bearing",
    "Fault": "hdf5",
    "FileFormatError": "errors",
    "HeightMap": "heightmap",
    "InputError": "errors",
    "Peaks": "peaks",
    "PolarProfile": "polar",
    "PolynomialProfile": "polar",
    "PowerLawProfile": "polar",
    "PowerSumProfile": "polar",
    "Profiles": "profiles",
    "SpectralMoments": "spectrum",
    "Spectrum": "spectrum",
    "SpectrumFit": "spectrum_fit",
    "Statistics": "statistics",
    "SurfaceError": "errors",
    "SurfaceFile": "hdf5",
    "Texture": "correlation",
    "autocorrelation": "correlation",
    "bandpass": "filtering",
    "bearing_curve": "bearing",
    "crop": "filtering",
    "describe": "statistics",
    "fill_missing": "filling",
    "fit_profiles": "summits",
    "fit_spectrum": "spectrum_fit",
    "ground": "textures",
    "level": "levelling",
    "make_periodic": "filtering",
    "mark_outliers": "outliers",
    "open": "hdf5",
    "plateau_honed": "textures",
    "plot_autocorrelation": "plot",
    "plot_bearing": "plot",
    "plot_map": "plot",
    "plot_profiles": "plot",
    "plot_spectrum": "plot",
    "power_spectrum": "spectrum",
    "power_spectrum_2d": "spectrum",
    "prepare": "preparation",
    "read": "formats",
    "redistribute": "textures",
    "resample": "filtering",
    "segment": "segmentation",
    "self_affine": "synthesis",
    "texture": "correlation",
    "turned": "textures",
    "two_scale": "textures",
    "validate": "hdf5",
    "write": "formats",
    "write_blocks": "hdf5_write",
}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f".{_HOME[name]}", __name__), name)


def __dir__() -> list[str]:
    return __all__
