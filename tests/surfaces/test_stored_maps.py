"""Maps that stay on disk: what reads them in parts finds what it finds of the map in memory."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import surfaces
from surfaces.files.stored_map import StoredMap
from surfaces.numerics import memory, splines, stored_array
from surfaces.numerics.memory import set_memory
from surfaces.numerics.stored_array import StoredArray, drop_pages, mapped, windows
from surfaces.patches import points_at
from surfaces.peaks import strips
from surfaces.peaks.peaks import expected_peaks

SHAPE = 101, 90


def stored(hm: surfaces.HeightMap) -> StoredMap:
    blocks = ((row, hm.heights[row : row + 7]) for row in range(0, len(hm.heights), 7))
    return StoredMap.of_blocks(
        blocks, hm.shape, np.float64, hm.spacing, periodic=hm.periodic, name=hm.name
    )


def waves(seed: int, periodic: bool = True) -> surfaces.HeightMap:
    size = SHAPE[0] * 1e-6, SHAPE[1] * 1e-6
    hm = surfaces.self_affine(SHAPE, size, hurst=0.7, rms_slope=0.1, cutoff=6e-6, seed=seed)
    return hm.replace(periodic=periodic)


def indices(count: int) -> st.SearchStrategy[object]:
    one = st.integers(-count, count - 1)
    end = st.none() | st.integers(-count, count)
    step = st.none() | st.integers(-5, 5).filter(bool)
    return one | st.builds(slice, end, end, step) | st.lists(one, min_size=1).map(np.array)


@pytest.fixture(scope="module")
def both() -> tuple[np.ndarray, StoredArray]:
    values = np.random.default_rng(0).standard_normal((23, 17)).astype(np.float32).astype(float)
    kept = StoredArray(values.shape, np.float32)
    kept.write(0, values[:9])
    kept.write(9, values[9:])
    return values, kept


@settings(deadline=None)
@given(indices(23), indices(17))
def test_parts_are_those_of_the_array(
    both: tuple[np.ndarray, StoredArray], rows: object, columns: object
) -> None:
    values, kept = both
    if all(isinstance(index, np.ndarray) for index in (rows, columns)):
        columns = np.resize(columns, np.shape(rows))  # type: ignore[arg-type]
    for one, two in (
        (values, kept),
        (2.0 * values - 1.0, kept.each(lambda z: 2.0 * z).each(lambda z: z - 1.0)),
    ):
        np.testing.assert_array_equal(two[rows], one[rows])  # type: ignore[index]
        np.testing.assert_array_equal(two[rows, columns], one[rows, columns])  # type: ignore[index]


@pytest.mark.parametrize("below", [0, 2])
def test_windows_of_memory_are_those_of_the_disk(
    both: tuple[np.ndarray, StoredArray], below: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So sums over them are equal to the last digit; together they are the rows asked for. None
    can be written to, or loops would be compiled twice."""
    values, kept = both
    monkeypatch.setattr(stored_array, "BLOCK_BYTES", 8 * values.shape[1] * 4)
    one, two = (list(windows(source, 3, below=below)) for source in (values, kept))
    assert [part[:2] for part in one] == [part[:2] for part in two]
    assert [part[0] for part in one] == [3, 7, 11, 15, 19]
    for begin, end, window in one + two:
        assert not window.flags.writeable
        for row in range(begin, end + below):
            found = window[(row - begin) % len(window)]
            np.testing.assert_array_equal(found, values[row % len(values)])


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("gaps", [0, 3])
def test_one_pass_finds_the_same(
    periodic: bool, gaps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    heights = waves(1).heights.copy()
    heights.flat[[0, 900, 901][:gaps]] = np.nan
    hm = surfaces.HeightMap(heights + 1.0, (1e-6, 2e-6), periodic=periodic)
    monkeypatch.setattr(stored_array, "BLOCK_BYTES", 8 * SHAPE[1] * 5)
    kept = stored(hm)
    for name in ("mean", "rms_height", "slope", "curvature", "kurtosis", "missing", "rows"):
        found, known = (getattr(each.roughness, name) for each in (kept, hm))
        np.testing.assert_allclose(found, known, rtol=1e-12)
    for name in ("digest", "missing", "has_equal_neighbors"):
        assert getattr(kept, name) == getattr(hm, name)
    assert "heights" not in vars(kept)
    offset = kept.about_mean
    assert isinstance(offset, StoredMap)
    np.testing.assert_array_equal(offset.heights, hm.about_mean.heights)


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("kind", ["waves", "noise", "steps", "worn", "floored"])
@pytest.mark.parametrize("limits", [{}, {"share": 0.6}, {"wolf": 5.0}])
def test_peaks_are_equal_to_the_last_summit(
    periodic: bool, kind: str, limits: dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    heights = waves(3).heights
    if kind == "noise":
        heights = np.random.default_rng(3).standard_normal(SHAPE) * 1e-6
    elif kind == "steps":
        heights = np.round(heights / (0.05 * heights.std())) * 0.05 * heights.std()
    elif kind == "worn":
        heights = np.minimum(heights, np.quantile(heights, 0.9))
    elif kind == "floored":
        heights = np.maximum(heights, np.quantile(heights, 0.1))
    hm = surfaces.HeightMap(heights, (1e-6, 1.3e-6), periodic=periodic)
    asked = dict(limits)
    if "share" in asked:
        asked["above"] = float(np.quantile(heights, asked.pop("share")))
    monkeypatch.setattr(strips, "BLOCK_BYTES", 8 * SHAPE[1] * 16)
    kept = stored(hm)
    known, found = surfaces.segment(hm, **asked), surfaces.segment(kept, **asked)
    assert "heights" not in vars(kept)
    for name, value in vars(known).items():
        other = getattr(found, name)
        np.testing.assert_array_equal(other[:] if name == "labels" else other, value, name)


def test_some_rows_tell_how_many_peaks_there_are() -> None:
    hm = surfaces.self_affine((600, 640), (6e-4, 6.4e-4), hurst=0.8, rms_slope=0.1, cutoff=6e-6)
    for above in (-np.inf, float(np.quantile(hm.heights, 0.8))):
        known = len(surfaces.segment(hm, above=above))
        assert abs(expected_peaks(hm, above) / known - 1.0) < 0.25


def test_pages_are_those_of_the_array(both: tuple[np.ndarray, StoredArray]) -> None:
    values, kept = both
    for one, two in ((values, kept), (values - 1.0, kept.each(lambda z: z - 1.0))):
        np.testing.assert_array_equal(mapped(two), one)
        drop_pages()
        np.testing.assert_array_equal(mapped(two), one)


@pytest.mark.parametrize("periodic", [True, False])
def test_spline_in_strips(periodic: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    hm = surfaces.self_affine((500, 40), (500.0, 40.0), hurst=0.7, rms_slope=0.1)
    monkeypatch.setattr(splines, "BLOCK_BYTES", 1)
    known = splines.coefficients(hm.heights, periodic)
    found = splines.coefficients(stored(hm).source, periodic)
    inside = slice(splines.PAD, -splines.PAD)  # further out the one in memory feels its own ends
    np.testing.assert_allclose(found[inside, inside], known[inside, inside], rtol=0.0, atol=1e-8)


def test_a_plateau_as_long_as_the_map_is_flooded_in_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    hm = surfaces.HeightMap(np.minimum(waves(2).heights, 0.0), 1e-6, periodic=True)
    monkeypatch.setattr(strips, "BLOCK_BYTES", 8 * SHAPE[1] * 16)
    found = surfaces.segment(stored(hm))
    np.testing.assert_array_equal(found.labels, surfaces.segment(hm).labels)


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_points_of_some_levels_are_all_found(seed: int) -> None:
    draw = np.random.default_rng(seed)
    heights = draw.integers(-5, 6, (40, 31)) * 0.1
    levels = np.unique(draw.choice(heights.ravel(), 3))
    marked = np.zeros(heights.shape, bool)
    marked[points_at(heights, levels)] = True
    assert marked[np.isin(heights, levels)].all()


def test_a_file_that_does_not_fit_stays_on_disk(tmp_path: Path) -> None:
    hm = waves(1)
    surfaces.write(hm, tmp_path / "a.h5", dtype="float32")
    with surfaces.open(tmp_path / "a.h5") as file:
        kept, whole = file.on_disk(), file.read()
    assert kept.digest == whole.digest and kept.history == whole.history
    np.testing.assert_array_equal(kept.heights, whole.heights)


def test_facts_are_checked_as_those_of_a_map_in_memory() -> None:
    """A map that was said to be no period stayed one, and a misspelt fact was left as it was."""
    for hm in (waves(0), stored(waves(0))):
        with pytest.raises(surfaces.SurfaceError, match="periodic is 'no'"):
            hm.replace(periodic="no")
        with pytest.raises(TypeError, match="perodic"):
            hm.replace(perodic=False)
        assert hm.replace(name="a\0b").name == "a?b"


def test_arrays_that_moved_to_files_are_the_same() -> None:
    """Of a dataclass, and only once; what is no array stays."""
    peaks = surfaces.segment(waves(1))
    moved = memory.on_disk(peaks)
    for name in ("height", "neighbors", "border"):
        np.testing.assert_array_equal(getattr(moved, name), getattr(peaks, name))
    drop_pages()
    np.testing.assert_array_equal(moved.height, peaks.height)
    assert moved.min_prominence == peaks.min_prominence
    assert memory.on_disk(moved).height is moved.height


def test_the_limit_of_memory_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    kept = stored(waves(1))
    with pytest.raises(surfaces.InputError, match="give at least 384 MiB"):
        set_memory(1000)
    try:
        set_memory(384 << 20)  # the least that the refusal names
        set_memory(400 << 20)
        monkeypatch.setattr(memory, "_resident_bytes", lambda: 400 << 20)
        with pytest.raises(surfaces.SurfaceError, match="raise the limit of memory"):
            _ = kept.heights
    finally:
        set_memory(None)
