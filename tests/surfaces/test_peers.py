"""The same numbers as other programs, where these are installed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import surfaces
from surfaces.statistics.parameters import PARAMETERS

from .test_exchange_formats import as_sdf, as_text_sdf, as_x3p

LIMITS = dict.fromkeys(
    ("Sq", "Ssk", "Sku", "Sp", "Sv", "Sz", "Sa", "Sdq", "Sdr", "Spc", "Svc", "S5p", "S5v", "S10z"),
    1e-9,
)
LIMITS |= dict.fromkeys(("Smr", "Smc", "Sxp", "Sk", "Smr1", "Smr2", "Vvc"), 1e-3)
LIMITS |= dict.fromkeys(("Vmc", "Spk", "Svk", "Vmp", "Vvv", "Sal"), 3e-3)
MICRO = {"m": 1e-6, "1/m": 1e6, "-": 1.0}
NAMES = {
    "afm_10um_grains": {},
    "focusvar_small_steep": {},
    "wli_milled_a": {"outliers": 6.0},
}


@pytest.mark.parametrize("name", NAMES)
def test_parameters_of_surfalize(measured: Path, name: str) -> None:
    """Volumes and tails differ by the 10 000 points to which the other program cuts its curve."""
    surfalize = pytest.importorskip("surfalize")
    hm = surfaces.prepare(surfaces.read(measured / f"{name}.h5"), **NAMES[name])
    ours = surfaces.describe(hm).parameters
    dy, dx = (1e6 * d for d in hm.spacing)
    theirs = surfalize.Surface(1e6 * hm.heights, dx, dy)
    mean = hm.heights.mean()
    special = {
        "Smr": theirs.Smr(1e6 * mean) / 100,
        "Smc": 1e-6 * theirs.Smc(10) - mean,
        "Smr1": theirs.Smr1() / 100,
        "Smr2": theirs.Smr2() / 100,
        "Sdr": theirs.Sdr() / 100,
    }
    whole = {"exclude_edge": False}
    for symbol, limit in LIMITS.items():
        options = whole if symbol in ("Spc", "Svc", "S5p", "S5v", "S10z") else {}
        factor = MICRO[PARAMETERS[symbol][0]]
        other = special.get(symbol)
        if other is None:
            other = factor * getattr(theirs, symbol)(**options)
        assert ours[symbol] == pytest.approx(other, rel=limit), symbol
    points = np.prod(np.array(hm.shape) - 1) / np.prod(hm.shape)  # their area lacks a pixel
    for symbol in ("Spd", "Svd"):
        other = 1e12 * getattr(theirs, symbol)(**whole)
        assert ours[symbol] == pytest.approx(points * other, rel=1e-9)


def test_gaussian_filter_of_surfalize(measured: Path) -> None:
    """Their weights are cut off at four deviations."""
    surfalize = pytest.importorskip("surfalize")
    from surfalize.filter import GaussianFilter

    hm = surfaces.prepare(surfaces.read(measured / "wli_milled_a.h5"))
    dy, dx = (1e6 * d for d in hm.spacing)
    theirs = GaussianFilter(40.0, "lowpass")(surfalize.Surface(1e6 * hm.heights, dx, dy))
    ours = surfaces.bandpass(hm, 40e-6, filter="gaussian").heights
    assert np.abs(1e-6 * theirs.data - ours).max() < 1e-3 * hm.rms_height


def test_means_of_surfacetopography(measured: Path) -> None:
    library = pytest.importorskip("SurfaceTopography")
    hm = surfaces.prepare(surfaces.read(measured / "wli_milled_a.h5"))
    theirs = library.Topography(hm.heights.T, hm.size[::-1])
    ours = surfaces.describe(hm).parameters
    assert ours["Sq"] == pytest.approx(theirs.rms_height_from_area(), rel=1e-9)
    assert ours["Sdq"] == pytest.approx(theirs.rms_gradient(), rel=0.01)


@pytest.mark.parametrize("name", ["a.sdf", "text.sdf", "a.x3p", "KautschukInfiniteFocus.x3p"])
def test_files_of_surfacetopography(tmp_path: Path, measured: Path, name: str) -> None:
    library = pytest.importorskip("SurfaceTopography")
    makers = {"a.sdf": as_sdf, "text.sdf": as_text_sdf, "a.x3p": as_x3p}
    path = tmp_path / name if name in makers else measured / "raw" / name
    if name in makers:
        makers[name](path)
    hm = surfaces.read(path)
    with np.errstate(over="ignore"):  # they scale the number that marks a missing point
        theirs = library.read_topography(str(path)).to_unit("m")
        heights = np.ma.filled(np.ma.masked_invalid(theirs.heights()), np.nan).T
    np.testing.assert_allclose(hm.heights, heights, rtol=1e-9, atol=1e-15)
    assert hm.spacing == pytest.approx(theirs.pixel_size[::-1], rel=1e-9)
