"""Figures hold what they should, on maps that are not square and with points missing."""

from __future__ import annotations

import io
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import surfaces
from surfaces.errors import InputError


def rough(anisotropy: float = 1.0) -> surfaces.HeightMap:
    return surfaces.self_affine(
        (60, 96),
        (1e-4, 2e-4),
        hurst=0.8,
        rms_slope=0.1,
        cutoff=1e-5,
        anisotropy=anisotropy,
        seed=1,
    )


def drawn(figure: Figure) -> str:
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg")
    return buffer.getvalue()


def test_map_with_peaks_and_basins() -> None:
    hm = rough()
    peaks = surfaces.segment(hm)
    figure = surfaces.plot_map(hm, peaks)
    axes = figure.axes[0]
    assert len(axes.images) == 2
    (marks,) = axes.lines
    np.testing.assert_allclose(np.sort(marks.get_xdata()), np.sort(peaks.x))
    assert f"{len(peaks)} peaks" in axes.get_title()
    assert axes.get_xlim() == pytest.approx((0.0, 2e-4))
    assert "<svg" in drawn(figure)


def test_map_with_missing_points_and_more_pixels_than_shown(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("surfaces.drawing.PICTURE_SIDE", 40)
    heights = rough().heights.copy()
    heights[5:20, 7:30] = np.nan
    figure = surfaces.plot_map(rough().replace(heights=heights))
    shown = figure.axes[0].images[0].get_array()
    assert shown.shape == (25, 40) and 0 < np.ma.count_masked(shown) < 15 * 23 / 4
    assert "<svg" in drawn(figure)


@pytest.mark.filterwarnings("error")
def test_a_large_map_of_every_other_line_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("surfaces.drawing.PICTURE_SIDE", 48)
    heights = rough().heights.copy()
    heights[::2] = np.nan
    shown = surfaces.plot_map(rough().replace(heights=heights)).axes[0].images[0].get_array()
    expected = heights[1::2].reshape(30, 48, 2).mean(axis=2)
    expected -= np.nanmean(heights)
    np.testing.assert_allclose(shown, expected / 1e-6)


@pytest.mark.filterwarnings("error")
def test_few_hills_on_a_flat_have_their_colors() -> None:
    heights = np.zeros((60, 96))
    heights[5, 7], heights[40, 80] = 1e-6, 2e-6
    drawn_heights = surfaces.plot_map(surfaces.HeightMap(heights, 1e-6)).axes[0].images[0]
    assert np.ptp(drawn_heights.get_clim()) == pytest.approx(2.0)


def test_spectrum_with_fit() -> None:
    spectrum = surfaces.power_spectrum(rough())
    fit = surfaces.fit_spectrum(spectrum)
    figure = surfaces.plot_spectrum(spectrum, fit)
    rings, model = figure.axes[0].lines[:2]
    assert rings.get_xdata().max() <= spectrum.nyquist
    np.testing.assert_allclose(model.get_ydata(), fit.density)
    assert "cut-off 10.0" in "".join(text.get_text() for text in figure.axes[0].texts)
    assert "<svg" in drawn(figure)


def test_fans_of_chosen_peaks() -> None:
    hm = rough()
    profiles = surfaces.fit_profiles(hm, surfaces.segment(hm))
    figure = surfaces.plot_profiles(profiles, [0, 2, 3, 4])
    assert len(figure.axes) == 4
    assert all(len(axes.lines) == profiles.phi.shape[1] for axes in figure.axes)
    assert "<svg" in drawn(figure)
    for peak in (len(profiles), -1, 0.5):
        with pytest.raises(InputError, match="peak"):
            surfaces.plot_profiles(profiles, [0, peak])
    with pytest.raises(InputError, match="10 peaks are chosen"):
        surfaces.plot_profiles(profiles, [0] * 10)


@pytest.mark.parametrize("shape", [(64, 64), (64, 96), (96, 64), (256, 256)])
def test_nothing_beside_a_map_is_cut_off(shape: tuple[int, int]) -> None:
    size = 1e-6 * shape[0], 1e-6 * shape[1]
    hm = surfaces.self_affine(shape, size, hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    figure = surfaces.plot_map(hm)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    held = figure.get_tightbbox(canvas.get_renderer())
    width, height = figure.get_size_inches()
    assert 0.0 <= held.x0 and held.x1 <= width and 0.0 <= held.y0 and held.y1 <= height


def test_autocorrelation() -> None:
    figure = surfaces.plot_autocorrelation(surfaces.autocorrelation(rough(anisotropy=4.0)))
    assert figure.axes[0].get_xlim() == pytest.approx((-1e-4, 1e-4), rel=0.03)
    lag, image = surfaces.autocorrelation(rough()).lag_x, figure.axes[0].images[0]
    left, right, *_ = image.get_extent()
    assert (right - left) / image.get_array().shape[1] == pytest.approx(lag[1] - lag[0])
    assert "<svg" in drawn(figure)


def test_the_peak_of_a_large_autocorrelation_is_drawn() -> None:
    """Of every third point it was left out: the largest value was 0.43."""
    shape = (2600, 2600)
    noise = np.random.default_rng(0).normal(size=shape)
    found = surfaces.autocorrelation(surfaces.HeightMap(noise, 1.0, periodic=True))
    drawn_values = surfaces.plot_autocorrelation(found).axes[0].images[0].get_array()
    assert max(drawn_values.shape) < 2600 and drawn_values.max() == pytest.approx(1.0)


def test_a_correlation_below_one_has_no_prefix() -> None:
    found = surfaces.autocorrelation(rough())
    image = surfaces.plot_autocorrelation(replace(found, value=0.5 * found.value)).axes[0].images[0]
    assert image.get_array().max() == pytest.approx(0.5)
    assert image.colorbar.ax.get_ylabel() == "correlation; line at 0.2"


@pytest.mark.parametrize("shape", [(3, 1300), (1300, 3)])
def test_autocorrelation_of_a_slim_map(shape: tuple[int, int]) -> None:
    """Of every second of its three lines one was left, and no contour is drawn of one."""
    hm = surfaces.HeightMap(np.random.default_rng(1).normal(size=shape), 1e-6)
    image = surfaces.plot_autocorrelation(surfaces.autocorrelation(hm)).axes[0].images[0]
    assert sorted(image.get_array().shape) == [3, 651]


def test_bearing_curve() -> None:
    figure = surfaces.plot_bearing(surfaces.bearing_curve(rough()))
    assert "<svg" in drawn(figure)


def test_nothing_heavy_is_imported_before_it_is_used() -> None:
    code = (
        "import sys, surfaces; hm = surfaces.HeightMap([[1.0, 2.0, 3.0]] * 3, 1.0)\n"
        "heavy = {'scipy', 'numba', 'matplotlib', 'h5py', 'cv2'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
        "from surfaces import plot_map; assert 'matplotlib.pyplot' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
