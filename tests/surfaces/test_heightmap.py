"""What a height map keeps of the heights it is given, and what it refuses."""

from __future__ import annotations

import copy
from pickle import dumps, loads

import numpy as np
import pytest

import surfaces
from surfaces import HeightMap, InputError, SurfaceError, describe, prepare, segment, write

GRID = np.arange(20.0).reshape(4, 5)


@pytest.mark.parametrize("kind", [np.float32, np.int16, np.uint8, ">f8"])
def test_any_real_numbers_are_kept(kind):
    hm = HeightMap(GRID.astype(kind), (2e-6, 1e-6))
    assert hm.heights.dtype == np.float64 and not hm.heights.flags.writeable
    np.testing.assert_array_equal(hm.heights, GRID)


def test_a_masked_point_is_missing():
    """Also of an integer map, where NumPy itself would keep the number under the mask."""
    for heights in (GRID, GRID.astype(int)):
        hm = HeightMap(np.ma.masked_equal(heights, 7), 1e-6)
        assert hm.missing == 1 and np.isnan(hm.heights[1, 2])


@pytest.mark.parametrize(
    ("heights", "match"),
    [
        (GRID + 1j, "complex"),
        (GRID > 0.0, "of type bool"),
        (GRID.astype("M8[s]"), "of type datetime64"),
        (GRID.astype(str), "of type <U32"),
        ([[True, False, True]] * 3, "of type bool"),
        ("heights", "real numbers"),
        (GRID[0], "two axes of at least 3 points.*profile line.*numpy.tile"),
        (GRID[:2], "two axes of at least 3 points"),
        (np.full((4, 5), np.nan), "every point"),
        (np.ma.masked_all((4, 5)), "every point"),
        (np.where(GRID == 7, np.inf, GRID), r"heights\[1, 2\] is infinite \(1 of 20"),
        (np.where(GRID == 7, -np.inf, np.nan), r"heights\[1, 2\] is infinite \(1 of 20"),
        (1e-310 * GRID, "reach from 0 to 1.9e-309 m.*check their unit"),
        (1e200 * GRID, "reach from 0 to 1.9e.201 m.*check their unit"),
    ],
)
def test_what_is_no_map_of_heights(heights, match):
    with pytest.raises(SurfaceError, match=match):
        HeightMap(heights, 1e-6)


@pytest.mark.parametrize(
    "spacing",
    [0.0, (1e-6, -1e-6), np.nan, (1e-6, 2e-6, 3e-6), "wide", (1e-6, 1e-300), 1e-38, np.inf],
)
def test_what_is_no_pixel_size(spacing):
    with pytest.raises(SurfaceError, match="pixel size"):
        HeightMap(GRID, spacing)


def test_pixel_sizes_in_two_units():
    """One in metres, one in nanometres: what follows would take all memory there is."""
    assert HeightMap(GRID, (1e-6, 1e-3)).spacing == (1e-6, 1e-3)
    with pytest.raises(SurfaceError, match="more than 1000 times the other: give both in m"):
        HeightMap(GRID, (1e-6, 1.1e-3))


@pytest.mark.parametrize("periodic", ["no", 1, None])
def test_periodic_is_true_or_false(periodic):
    """Not a text, which would be true whatever it says."""
    with pytest.raises(SurfaceError, match="periodic is"):
        HeightMap(GRID, 1e-6, periodic=periodic)


@pytest.mark.parametrize(
    "use",
    [
        prepare,
        describe,
        segment,
        surfaces.level,
        surfaces.fill_missing,
        surfaces.mark_outliers,
        surfaces.power_spectrum,
        surfaces.autocorrelation,
        surfaces.bearing_curve,
        surfaces.plot_map,
        lambda hm: surfaces.crop(hm, (0, 3), (0, 3)),
        lambda hm: surfaces.resample(hm, 1e-6),
        lambda hm: surfaces.bandpass(hm, longest=1e-5),
        lambda hm: write(hm, "map.h5"),
    ],
)
def test_a_bare_array_is_no_map(use):
    with pytest.raises(SurfaceError, match=r"HeightMap is needed, not ndarray: .*\(dy, dx\)"):
        use(GRID)


def ramp() -> HeightMap:
    return HeightMap(np.arange(80.0).reshape(8, 10) * 1e-9, (2e-6, 1e-6), name="<ramp>")


def test_a_part_is_cut_out_by_lengths() -> None:
    """Pixels whose centres lie within; the same as by rows and columns."""
    part = ramp().crop(x=(2e-6, 7e-6), y=(4e-6, 12e-6))
    same = surfaces.crop(ramp(), (2, 6), (2, 7))
    np.testing.assert_array_equal(part.heights, same.heights)
    assert part.history == same.history and not part.periodic
    assert ramp().crop(x=(0.0, 10e-6)).shape == ramp().shape


@pytest.mark.parametrize(
    "span", [(5e-6, 2e-6), (-1e-6, 5e-6), (0.0, 11e-6), (1e-6, 2e-6), (0.0, np.nan)]
)
def test_a_part_outside_or_too_small_is_refused(span) -> None:
    with pytest.raises(SurfaceError, match="x is"):
        ramp().crop(x=span)


def test_sum_and_difference_of_maps() -> None:
    one, gap = ramp(), ramp().heights.copy()
    gap[2, 3] = np.nan
    other = one.replace(heights=gap)
    np.testing.assert_array_equal(
        (one + other - other).heights, np.where(np.isnan(gap), gap, one.heights)
    )
    assert (one + other).missing == 1 and (one - one).rms_height == 0.0
    np.testing.assert_array_equal((one - 1e-9).heights, one.heights - 1e-9)
    np.testing.assert_array_equal((1e-9 + one).heights, (one + 1e-9).heights)
    assert [step["step"] for step in (one + other - 1e-9).history] == ["add", "subtract"]


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"heights": np.ones((10, 8))}, "differ in shape"),
        ({"spacing": (1e-6, 1e-6)}, "differ in spacing"),
        ({"periodic": True}, "differ in periodic"),
    ],
)
def test_maps_on_other_grids_are_not_added(change, match) -> None:
    with pytest.raises(SurfaceError, match=match):
        ramp() + ramp().replace(**change)
    with pytest.raises(InputError, match="must be a number"):
        ramp() - "a"


def test_a_map_is_drawn_on_axes_and_in_a_notebook() -> None:
    from matplotlib.figure import Figure

    ax = Figure().add_subplot()
    assert ramp().plot(ax, cmap="gray") is ax
    assert ax.images[0].get_extent() == pytest.approx([0.0, 10e-6, 0.0, 16e-6])
    assert ax.images[0].get_cmap().name == "gray"
    page = ramp()._repr_html_()
    assert "&lt;ramp&gt;" in page and "<ramp>" not in page and "data:image/png;base64" in page


def test_only_what_nobody_can_change_is_kept_without_a_copy() -> None:
    heights = np.eye(4, 5)
    assert not np.shares_memory(surfaces.HeightMap(heights, 1.0).heights, heights)
    heights.setflags(write=False)
    assert surfaces.HeightMap(heights, 1.0).heights is heights
    assert surfaces.HeightMap(heights[1:], 1.0).heights.flags.owndata


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda hm: loads(dumps(hm))])
def test_a_copy_cannot_be_changed_either(copied) -> None:
    """Heights of one that was pickled could be, under the digest and roughness of the first."""
    hm = surfaces.self_affine((16, 24), (1.0, 1.0), hurst=0.8, rms_slope=0.1).replace(name="a")
    other = copied(hm)
    assert not other.heights.flags.writeable and other.digest == hm.digest
    assert (other.name, other.history, other.spacing) == (hm.name, hm.history, hm.spacing)


def test_a_map_on_disk_is_pickled_with_its_heights(tmp_path) -> None:
    hm = surfaces.self_affine((16, 24), (1.0, 1.0), hurst=0.8, rms_slope=0.1)
    surfaces.write(hm, tmp_path / "a.h5")
    with surfaces.open(tmp_path / "a.h5") as file:
        assert loads(dumps(file.on_disk())).digest == hm.digest


def test_heights_of_another_kind_of_array_are_copied():
    """What numpy makes of it may be the array that it keeps."""

    class Labelled:
        def __init__(self, values):
            self.values = values

        def __array__(self, dtype=None, copy=None):
            return self.values

    values = np.eye(4)
    hm = surfaces.HeightMap(Labelled(values), 1e-6)
    values[0, 0] = 5.0
    assert hm.heights[0, 0] == 1.0


def test_masked_rows_in_a_list_are_missing():
    rows = [np.ma.masked_equal([1.0, 2.0, -9999.0, 4.0], -9999.0)] * 4
    assert surfaces.HeightMap(rows, 1e-6).missing == 4


def test_an_array_of_numpy_leaves_its_sum_to_the_map():
    """It was an array of as many maps as it had elements."""
    hm = surfaces.HeightMap(np.eye(4), 1e-6)
    assert (np.float64(1.0) + hm).digest == (hm + 1.0).digest
    with pytest.raises(surfaces.InputError, match="must be a number"):
        np.ones((4, 4)) + hm
