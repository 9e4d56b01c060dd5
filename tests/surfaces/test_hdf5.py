"""Schema-1 files: what goes in comes out, in whole or in parts; every fault has its sentence."""

from __future__ import annotations

import threading
import warnings
from pathlib import Path

import h5py
import numpy as np
import pytest
from samples import SPACING, bumps

import surfaces
from surfaces.errors import FileFormatError, SurfaceError

TEXT = h5py.string_dtype()


@pytest.fixture
def foreign(tmp_path: Path) -> Path:
    """A file of another program: integer heights in um under a name of its own."""
    path = tmp_path / "foreign.h5"
    with h5py.File(path, "w") as file:
        file["scan/z"] = np.arange(12 * 15, dtype="int16").reshape(12, 15)
        file["scan/mask"] = np.zeros((12, 15), dtype="uint8")
    return path


def edit(path: Path, **attributes: object) -> Path:
    """Set attributes of the heights, or delete those given as None."""
    with h5py.File(path, "r+") as file:
        for name, value in attributes.items():
            del file["heights"].attrs[name]
            if value is not None:
                file["heights"].attrs[name] = value
    return path


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    surfaces.write(bumps(), tmp_path / "bumps.h5")
    return tmp_path / "bumps.h5"


def test_round_trip_keeps_everything(stored: Path) -> None:
    back, hm = surfaces.read(stored), bumps()
    assert back.digest == hm.digest
    assert (back.name, back.history, back.periodic) == (hm.name, hm.history, hm.periodic)
    assert surfaces.validate(stored) == []


def test_layout_is_schema_1(stored: Path) -> None:
    with h5py.File(stored) as file:
        heights = file["heights"]
        assert heights.attrs["schema"] == "surface/1"
        assert heights.attrs["unit"] == "m"
        assert heights.attrs["instrument"] == "stylus"
        assert heights.attrs["spacing"].tolist() == list(SPACING)
        assert bool(heights.attrs["periodic"]) is True
        assert heights.chunks is not None and heights.compression == "gzip"


def test_float32_keeps_seven_digits(tmp_path: Path) -> None:
    surfaces.write(bumps(), tmp_path / "half.h5", dtype="float32")
    back = surfaces.read(tmp_path / "half.h5").heights
    np.testing.assert_allclose(back, bumps().heights, rtol=1e-7)


@pytest.mark.parametrize(("unit", "metres"), [("mm", 1e-3), ("um", 1e-6), ("nm", 1e-9)])
def test_units_are_converted_at_the_edge(stored: Path, unit: str, metres: float) -> None:
    expected = bumps().heights * metres
    np.testing.assert_allclose(surfaces.read(edit(stored, unit=unit)).heights, expected, rtol=1e-12)


@pytest.mark.parametrize("region", [((3, 20), (10, 57)), ((0, 40), (0, 1)), ((39, 40), None)])
def test_regions_equal_slices(stored: Path, region: tuple) -> None:
    rows, columns = region
    inside = (slice(*rows), slice(*columns) if columns else slice(None))
    with surfaces.open(stored) as file:
        np.testing.assert_array_equal(file.heights(rows, columns), bumps().heights[inside])


def test_a_region_is_a_map_that_is_not_periodic(stored: Path) -> None:
    with surfaces.open(stored) as file:
        part = file.read((4, 30), (7, 50))
    assert part.shape == (26, 43) and not part.periodic and part.spacing == SPACING
    assert part.history[-1] == {"step": "crop", "rows": [4, 30], "columns": [7, 50]}


def test_blocks_cover_the_map_once(stored: Path) -> None:
    with surfaces.open(stored) as file:
        starts, blocks = zip(*file.blocks(rows=9), strict=True)
    assert starts == (0, 9, 18, 27, 36)
    np.testing.assert_array_equal(np.vstack(blocks), bumps().heights)


def test_region_outside_is_refused(stored: Path) -> None:
    with surfaces.open(stored) as file, pytest.raises(SurfaceError, match="not inside"):
        file.heights((0, 41))


def test_a_map_larger_than_memory_is_read_in_parts(
    stored: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("surfaces.numerics.memory.available_bytes", lambda: 8 * 57 * 12)
    with pytest.raises(SurfaceError, match=r"needs .* GB of memory .* read a region"):
        surfaces.read(stored)
    with surfaces.open(stored) as file:
        assert sum(len(block) for _, block in file.blocks(rows=8)) == 40


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ({"unit": None}, "states no unit; pass --unit"),
        ({"unit": "parsec"}, "'parsec' is not a unit"),
        ({"unit": 3.0}, "3.0 is not a unit of length"),
        ({"spacing": None}, "states no pixel size; pass --spacing"),
        ({"spacing": [1e-6, -1e-6]}, "spacing is "),
        ({"spacing": [1e-6, np.nan]}, "spacing is "),
        ({"spacing": [1e-6, 1e-6, 1e-6]}, "spacing is "),
        ({"spacing": "1 um"}, "spacing is "),
        ({"periodic": "perhaps"}, "must be true or false"),
        ({"spacing": [1e-6, 1e-2]}, "more than 1000 times"),
        ({"schema": "surface/9"}, "schema 'surface/9'"),
        ({"schema": np.array(["a", "b"], TEXT)}, "has schema array"),
    ],
)
def test_each_bad_attribute_has_its_sentence(
    stored: Path, attributes: dict[str, object], message: str
) -> None:
    edit(stored, **attributes)
    with pytest.raises(FileFormatError, match=message):
        surfaces.read(stored)
    assert any(fault.fatal and message in str(fault) for fault in surfaces.validate(stored))


@pytest.mark.parametrize("wrap", [lambda text: np.array([text.encode()]), lambda text: [text]])
def test_attributes_in_arrays_of_one_are_read(stored: Path, wrap) -> None:
    texts = {"unit": "um", "name": "scan", "schema": "surface/1", "history": '[{"step": "a"}]'}
    arrays = {name: np.array(wrap(text), TEXT) for name, text in texts.items()}
    edit(stored, **arrays, periodic=np.array([1.0]))
    with h5py.File(stored, "r+") as file:
        file["heights"].attrs["source"] = h5py.Empty("S1")
    hm = surfaces.read(stored)
    assert (hm.name, hm.periodic, hm.history[-1]) == ("scan", True, {"step": "a"})
    np.testing.assert_allclose(hm.heights, bumps().heights * 1e-6)
    assert surfaces.validate(stored) == []


def test_a_history_does_not_hide_what_else_the_file_tells(stored: Path, tmp_path: Path) -> None:
    edit(stored, history='[{"step": "level"}]', instrument="AFM 3")
    with h5py.File(stored, "r+") as file:
        file["heights"].attrs["operator"] = "me"
    hm = surfaces.read(stored)
    first, last = hm.history
    assert (first["step"], first["instrument"], first["operator"]) == ("read", "AFM 3", "me")
    assert last == {"step": "level"}
    surfaces.write(hm, tmp_path / "again.h5")
    assert surfaces.read(tmp_path / "again.h5").history == hm.history


def test_explicit_options_stand_in_for_missing_attributes(stored: Path) -> None:
    edit(stored, unit=None, spacing=None)
    hm = surfaces.read(stored, unit="nm", spacing=(1e-6, 2e-6))
    assert hm.spacing == (1e-6, 2e-6)
    np.testing.assert_allclose(hm.heights, bumps().heights * 1e-9, rtol=1e-12)


@pytest.mark.parametrize("options", [{"unit": "um"}, {"spacing": 1e-6}])
def test_options_that_contradict_the_file_are_refused(
    stored: Path, options: dict[str, object]
) -> None:
    with pytest.raises(FileFormatError, match="leave out"):
        surfaces.read(stored, **options)


def test_missing_schema_is_a_note_only(stored: Path) -> None:
    edit(stored, schema=None)
    assert surfaces.read(stored).digest == bumps().digest
    (note,) = surfaces.validate(stored)
    assert not note.fatal and "schema" in str(note)


def test_foreign_file_by_explicit_options(foreign: Path) -> None:
    hm = surfaces.read(foreign, dataset="scan/z", unit="um", spacing=1e-6)
    np.testing.assert_allclose(hm.heights[1], (15 + np.arange(15)) * 1e-6)
    assert hm.history[0]["dataset"] == "/scan/z"


@pytest.mark.parametrize("dtype", [">i2", "<f4"])
def test_packed_numbers_are_unpacked_as_netcdf_does(tmp_path: Path, dtype: str) -> None:
    numbers = np.arange(12 * 15).reshape(12, 15).astype(dtype)
    numbers[2, 3], numbers[4, 5] = -9999, -1
    with h5py.File(tmp_path / "a.nc", "w") as file:
        z = file.create_dataset("z", data=numbers, chunks=(5, 4))
        facts = {"scale_factor": 0.5, "add_offset": 3.0, "unit": "um", "spacing": 1e-6}
        z.attrs.update(facts | {"_FillValue": np.array([-9999], dtype), "missing_value": -1.0})
    heights = (0.5 * numbers.astype(float) + 3.0) * 1e-6
    heights[2, 3] = heights[4, 5] = np.nan
    with surfaces.open(tmp_path / "a.nc", dataset="z") as file:
        for hm in (file.read(), file.on_disk()):
            np.testing.assert_allclose(hm.heights, heights, rtol=1e-15)
        part = file.heights((1, 9), (2, 7))
        np.testing.assert_array_equal(part, file.read().heights[1:9, 2:7])
    with h5py.File(tmp_path / "a.nc", "r+") as file:
        file["z"].attrs["scale_factor"] = 0.0
    with pytest.raises(FileFormatError, match=r"scale_factor is 0\.0 .* give no heights"):
        surfaces.read(tmp_path / "a.nc", dataset="z")


def test_attributes_that_are_there_are_listed(foreign: Path) -> None:
    with h5py.File(foreign, "r+") as file:
        file["scan/z"].attrs["pixel_size"] = 2.0
    with pytest.raises(FileFormatError, match=r"spacing=.*its attributes: pixel_size"):
        surfaces.read(foreign, dataset="scan/z", unit="um")


def test_wrong_dataset_lists_what_the_file_holds(foreign: Path) -> None:
    for name in (None, "nothing", "scan"):
        with pytest.raises(FileFormatError, match=r"holds scan/mask \(12, 15\) uint8, scan/z"):
            surfaces.read(foreign, dataset=name)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (np.zeros((2, 2)), "at least 3 points"),
        (np.zeros((4, 5, 6)), "at least 3 points"),
        (np.zeros(7), "at least 3 points"),
        (np.full((4, 5), b"abc"), "must be real numbers"),
        (np.zeros((4, 5), dtype=complex), "must be real numbers"),
        (np.full((4, 5), np.inf), "infinite"),
        (np.full((4, 5), np.nan), "missing"),
    ],
)
def test_unusable_heights(tmp_path: Path, values: np.ndarray, message: str) -> None:
    path = tmp_path / "bad.h5"
    with h5py.File(path, "w") as file:
        file["heights"] = values
    with pytest.raises(surfaces.InputError, match=message) as caught:
        surfaces.read(path, unit="m", spacing=1e-6)
    assert str(caught.value).count(str(path)) == 1


def test_declared_but_unwritten_heights_are_not_zeros(tmp_path: Path) -> None:
    path = tmp_path / "hollow.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset(
            "heights", (10**6, 10**6), "f4", chunks=(1000, 1000), compression="gzip"
        )
    with pytest.raises(FileFormatError, match="0 of its 1000000 chunks"):
        surfaces.read(path, unit="m", spacing=1e-6)


def test_hardly_anything_of_a_huge_dataset_is_stored(tmp_path: Path) -> None:
    path = tmp_path / "hollow.h5"
    with h5py.File(path, "w") as file:
        options = {"chunks": (256, 256), "fillvalue": np.nan}
        z = file.create_dataset("heights", (10**7, 10**7), "f4", **options)
        z.attrs.update({"unit": "m", "spacing": 1e-6})
        z[5 * 10**6, 10**7 - 3 :] = [1, np.inf, 3]
    assert [str(fault) for fault in surfaces.validate(path) if fault.fatal] == [
        "1 heights are infinite; mark missing points with NaN"
    ]


def test_chunks_of_missing_points_need_not_be_stored(tmp_path: Path) -> None:
    path = tmp_path / "hollow.h5"
    with h5py.File(path, "w") as file:
        z = file.create_dataset("heights", (9, 12), "i2", chunks=(3, 4), fillvalue=-9999)
        z[:3, :4] = np.arange(12).reshape(3, 4)
        z.attrs.update({"unit": "m", "spacing": 1e-6})
    with pytest.raises(FileFormatError, match=r"1 of its 9 chunks; .* -9999 .* name that _Fill"):
        surfaces.read(path)
    with h5py.File(path, "r+") as file:
        file["heights"].attrs["_FillValue"] = np.int16(-9999)
    hm = surfaces.read(path)
    np.testing.assert_array_equal(hm.heights[:3, :4], np.arange(12).reshape(3, 4))
    assert hm.missing == 96
    assert not any(fault.fatal for fault in surfaces.validate(path))


@pytest.mark.parametrize("keep", [0.0, 0.001, 0.3, 0.5, 0.9, 0.999])
def test_truncated_files(stored: Path, keep: float) -> None:
    content = stored.read_bytes()
    stored.write_bytes(content[: int(keep * len(content))])
    with pytest.raises(FileFormatError) as caught:
        surfaces.read(stored)
    assert str(stored) in str(caught.value)
    if keep:
        assert len(surfaces.validate(stored)) == 1


def test_not_a_file(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match="no such file"):
        surfaces.read(tmp_path / "none.h5")
    with pytest.raises(FileFormatError, match=r"of a folder give the maps in it.*\*\.h5"):
        surfaces.read(tmp_path)
    assert "no such file" in str(surfaces.validate(tmp_path / "none.h5")[0])
    (tmp_path / "text.h5").write_text("not HDF5 at all")
    with pytest.raises(FileFormatError, match="not an HDF5 file"):
        surfaces.read(tmp_path / "text.h5")


@pytest.mark.parametrize(
    "link", [h5py.SoftLink("/heights"), h5py.SoftLink("/none"), h5py.ExternalLink("none.h5", "/z")]
)
def test_links_that_lead_nowhere_are_no_damage(tmp_path: Path, link: object) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["heights"] = link
    with pytest.raises(FileFormatError, match=r"is a link to .* leads nowhere .*--dataset"):
        surfaces.read(tmp_path / "a.h5")


def test_results_are_no_height_map(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "results.h5", "w") as file:
        file["curves/bem/load"] = np.zeros(3)
    with pytest.raises(FileFormatError, match=r"results of a run and no height map; give the map$"):
        surfaces.read(tmp_path / "results.h5")


def test_links_into_other_files_are_not_followed(stored: Path, tmp_path: Path) -> None:
    path = tmp_path / "linked.h5"
    with h5py.File(path, "w") as file:
        file["heights"] = h5py.ExternalLink(stored, "heights")
    with pytest.raises(FileFormatError, match="link into another file"):
        surfaces.read(path)


def test_measured_files_are_readable(measured: Path) -> None:
    for path in sorted(measured.glob("*.h5")):
        assert not any(fault.fatal for fault in surfaces.validate(path))
        hm = surfaces.read(path)
        assert hm.history[0]["instrument"]


def test_a_file_that_is_tried_in_a_child_is_read_beside_threads_without_a_warning(foreign):
    """Python 3.12 and later warn of a fork in a program with threads."""
    done = threading.Event()
    threading.Thread(target=done.wait).start()
    try:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            surfaces.read(foreign, dataset="scan/z", unit="um", spacing=1e-6)
    finally:
        done.set()
    assert not told
