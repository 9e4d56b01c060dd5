"""Preparation of maps that stay on disk finds what it finds of the map in memory."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import surfaces
from surfaces.files import hdf5
from surfaces.files.stored_map import StoredMap
from surfaces.numerics import memory, stored_array
from surfaces.numerics.stored_array import windows
from surfaces.preparation.levelling import FORMS

SHAPE = 61, 84
SOME = settings(max_examples=25, deadline=None, derandomize=True)


@pytest.fixture(autouse=True)
def _blocks_of_seven_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stored_array, "BLOCK_BYTES", 8 * SHAPE[1] * 7)


def stored(hm: surfaces.HeightMap) -> StoredMap:
    facts = {"periodic": hm.periodic, "name": hm.name, "history": hm.history}
    return StoredMap.of_blocks([(0, hm.heights)], hm.shape, np.float64, hm.spacing, **facts)


def measured(seed: int, gaps: int = 0, periodic: bool = False) -> surfaces.HeightMap:
    """Noise on a tilt and an offset, with spikes, and with gaps that may cross the border."""
    draw = np.random.default_rng(seed)
    heights = draw.normal(3e-6, 1e-8, SHAPE) + np.linspace(0.0, 1e-6, SHAPE[1])
    heights.flat[draw.integers(0, heights.size, 9)] += 1e-5
    for _ in range(gaps):
        row, column = draw.integers(-5, SHAPE[0]), draw.integers(-5, SHAPE[1])
        tall, wide = draw.integers(1, 25), draw.integers(1, 12)
        rows, columns = np.arange(row, row + tall), np.arange(column, column + wide)
        if periodic:
            rows, columns = rows % SHAPE[0], columns % SHAPE[1]
        inside = (rows[:, None] >= 0) & (rows[:, None] < SHAPE[0])
        inside = inside & (columns >= 0) & (columns < SHAPE[1])
        r, c = np.broadcast_arrays(rows[:, None], columns)
        heights[r[inside], c[inside]] = np.nan
    return surfaces.HeightMap(heights, (2e-6, 3e-6), periodic=periodic, name="scan")


def is_equal(found: surfaces.HeightMap, known: surfaces.HeightMap, rounding: float) -> None:
    """On disk, with equal facts, and heights equal to a share of the median deviation."""
    assert isinstance(found, StoredMap) and "heights" not in vars(found)
    assert (found.periodic, found.name, found.shape) == (known.periodic, known.name, known.shape)
    scale = np.nanmedian(np.abs(known.heights - np.nanmedian(known.heights)))
    for begin, end, rows in windows(found.source):
        np.testing.assert_allclose(rows, known.heights[begin:end], rtol=0, atol=rounding * scale)
    for one, two in zip(found.history, known.history, strict=True):
        assert one.keys() == two.keys()
        for key, value in two.items():
            if isinstance(value, float | list):
                np.testing.assert_allclose(one[key], value, max(1e-9, rounding), 1e-15, err_msg=key)
            else:
                assert one[key] == value, key


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("gaps", [0, 4])
def test_level(form: str, gaps: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """To the last digit, on which a curve can hang; by other blocks, a direction is found to the
    root of the rounding only."""
    rounding = 1e-5 if form == "cylinder" else 1e-11
    for periodic in (False, True):
        hm = measured(1, gaps, periodic)
        found = surfaces.level(stored(hm), form)
        is_equal(found, surfaces.level(hm, form), 0.0)
        with monkeypatch.context() as at_once:
            at_once.setattr(stored_array, "BLOCK_BYTES", hm.heights.nbytes)
            known = surfaces.level(hm, form)
        is_equal(found, known, rounding)


def test_nothing_but_rounding_is_levelled_to_zero() -> None:
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]] * 1e-6
    flat = surfaces.level(stored(surfaces.HeightMap(0.2 * x - 0.1 * y + 3e-3, 1e-6)))
    assert flat.roughness.largest == 0.0


@SOME
@given(seed=st.integers(0, 2**31), gaps=st.integers(1, 9), periodic=st.booleans())
def test_filling_is_that_of_the_whole_map(seed: int, gaps: int, periodic: bool) -> None:
    """Gaps that end within a block, cross many, or go on beyond the border."""
    hm = measured(seed, gaps, periodic)
    whole = surfaces.fill_missing(hm, limit=0.9)
    is_equal(surfaces.fill_missing(stored(hm), limit=0.9), whole, 1e-11)


def test_a_gap_too_large_for_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    kept = stored(measured(5, 9))
    monkeypatch.setattr(memory, "available_bytes", lambda: 20_000)
    with pytest.raises(surfaces.SurfaceError, match=r"missing points, of gaps .*--fill none"):
        surfaces.fill_missing(kept, limit=0.9)


@SOME
@given(data=st.data())
def test_crop(data: st.DataObject) -> None:
    hm = measured(2, 2)
    rows, columns = (
        data.draw(
            st.tuples(st.integers(0, n - 3), st.integers(3, n)).map(
                lambda ends: (ends[0], max(ends[0] + 3, ends[1]))
            )
        )
        for n in SHAPE
    )
    is_equal(surfaces.crop(stored(hm), rows, columns), surfaces.crop(hm, rows, columns), 0.0)
    y = tuple(hm.spacing[0] * n for n in rows)
    is_equal(stored(hm).crop(y=y), hm.crop(y=y), 0.0)


@SOME
@given(seed=st.integers(0, 2**31), gaps=st.integers(0, 3), periodic=st.booleans())
def test_outliers(seed: int, gaps: int, periodic: bool) -> None:
    """The same points; limits follow heights that single precision rounds about a median."""
    hm = measured(seed, gaps, periodic)
    known, found = (surfaces.mark_outliers(each, 4.0) for each in (hm, stored(hm)))
    assert known.history[-1]["count"] > 0
    is_equal(found.replace(history=()), known.replace(history=()), 0.0)
    for key in ("limit", "count"):
        assert found.history[-1][key] == pytest.approx(known.history[-1][key], rel=1e-4)


def test_outliers_of_a_map_whose_last_block_is_an_odd_row() -> None:
    """Averages over two rows of the block before take it: none is left to be written."""
    hm = measured(1, 2)
    hm = hm.cut((0, 50), (0, SHAPE[1]))
    assert hm.missing and hm.shape[0] % 14 == 8  # blocks have seven rows
    known, found = (surfaces.mark_outliers(each, 4.0) for each in (hm, stored(hm)))
    is_equal(found.replace(history=()), known.replace(history=()), 0.0)


@pytest.fixture
def sections_of_eight_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "room_for", lambda least, _: 2 * least)


def without_border(shape: tuple[int, int], periodic: bool) -> surfaces.HeightMap:
    """Of an odd or even number of rows and columns."""
    hm = measured(6).cut((0, shape[0]), (0, shape[1]))
    return hm.replace(periodic=periodic)


@pytest.mark.usefixtures("sections_of_eight_columns")
@pytest.mark.parametrize("how", ["mirror", "taper", "smooth", "wrap"])
def test_periodic(how: str) -> None:
    for shape in (SHAPE, (60, 83)):
        hm = without_border(shape, False)
        is_equal(surfaces.make_periodic(stored(hm), how), surfaces.make_periodic(hm, how), 1e-11)


@pytest.mark.usefixtures("sections_of_eight_columns")
@pytest.mark.parametrize("kind", ["sharp", "gaussian", "spline"])
@pytest.mark.parametrize("periodic", [True, False])
def test_bands(kind: str, periodic: bool) -> None:
    """S filter, L filter and both; a filter that keeps a free border takes the map whole."""
    for shape in (SHAPE, (60, 83)):
        hm = without_border(shape, periodic)
        for band in ((9e-6, None), (None, 40e-6), (9e-6, 40e-6)):
            known = surfaces.bandpass(hm, *band, filter=kind)
            kept = stored(hm)
            found = surfaces.bandpass(kept, *band, filter=kind)
            assert ("heights" in vars(kept)) == (kind == "spline" and not periodic)
            if kind != "spline" or periodic:
                is_equal(found, known, 1e-11)


@pytest.mark.usefixtures("sections_of_eight_columns")
@pytest.mark.parametrize("periodic", [True, False])
def test_other_grids(periodic: bool) -> None:
    """Fewer points, more, as many along one side, and the other way along each."""
    for shape in (SHAPE, (60, 83)):
        hm = without_border(shape, periodic)
        for points in ((29, 40), (122, 126), (shape[0], 120), (31, 168)):
            pixel = np.divide(hm.size, points)
            found = surfaces.resample(stored(hm), pixel)
            assert found.shape == points
            is_equal(found, surfaces.resample(hm, pixel), 1e-11)


@pytest.mark.usefixtures("sections_of_eight_columns")
def test_no_wave_in_the_band() -> None:
    for periodic in (True, False):
        with pytest.raises(surfaces.SurfaceError, match="no wavelength of the map lies between"):
            surfaces.bandpass(stored(without_border(SHAPE, periodic)), 50e-6, 50.01e-6)


@pytest.mark.usefixtures("sections_of_eight_columns")
def test_a_measured_map_through_all_steps(measured: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stored_array, "BLOCK_BYTES", 1 << 20)
    hm = surfaces.read(measured / "wli_milled_a.h5")
    steps = {"level": "plane", "bandpass": (8 * max(hm.spacing), None), "periodic": "smooth"}
    whole, kept = (surfaces.prepare(each, fill_limit=0.5, **steps) for each in (hm, stored(hm)))
    is_equal(kept, whole, 1e-11)


def test_what_is_prepared_by_default(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a file, and of a part of it, both too large for the memory."""
    surfaces.write(measured(3, 5), tmp_path / "scan.h5", dtype="float32")
    for span in (None, (5, 50)):
        whole = surfaces.read(tmp_path / "scan.h5", rows=span)
        with monkeypatch.context() as patched:
            patched.setattr(hdf5, "BYTES_OF_WORK", 1e12)
            kept = surfaces.read(tmp_path / "scan.h5", rows=span)
        is_equal(kept, whole, 0.0)
        ready = surfaces.prepare(kept, fill_limit=0.5)
        is_equal(ready, surfaces.prepare(whole, fill_limit=0.5), 1e-12)
        assert ready.missing == 0
