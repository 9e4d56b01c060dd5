"""Results files: what is written comes back, and damage is told."""

from __future__ import annotations

import dataclasses
import resource
import threading

import h5py
import numpy as np
import pytest
from samples import power_law_curve

from asperity.errors import FileFormatError, InputError
from asperity.results.curve import ContactCurve, read_results
from asperity.results.interpolation import POINT_FIELDS
from asperity.results.storage import ResultFile, structured, write_csv, write_results
from surfaces.files.atomic import replacing


def test_file_gives_back_the_curve(tmp_path):
    curve = power_law_curve(broken=2)
    curve.to_hdf5(tmp_path / "r.h5")
    back = ContactCurve.from_hdf5(tmp_path / "r.h5")
    for name in POINT_FIELDS:
        np.testing.assert_array_equal(getattr(back, name), getattr(curve, name))
        assert getattr(back, name).dtype == getattr(curve, name).dtype
    np.testing.assert_array_equal(back.extra["filled_share"], curve.extra["filled_share"])
    assert back.reasons == curve.reasons
    assert back.settings == {"law": "paper", "above": None, "modulus": 2e11}
    assert back.seconds == curve.seconds


def test_tables_maps_and_facts_come_back(tmp_path):
    table = structured({"model": np.array(["bem", "µ"]), "seconds": np.array([1.0, 2.0])})
    held = ResultFile(
        curves={"a": power_law_curve(), "b": power_law_curve(3)},
        tables={"pareto": table},
        maps={"contact": np.eye(4, 6, dtype=bool)},
        about={"name": "scan", "history": [{"step": "level"}]},
    )
    write_results(tmp_path / "r.h5", held)
    back = read_results(tmp_path / "r.h5")
    assert back.tables["pareto"]["model"].tolist() == ["bem", "µ"]
    np.testing.assert_array_equal(back.tables["pareto"]["seconds"], [1.0, 2.0])
    np.testing.assert_array_equal(back.maps["contact"], np.eye(4, 6, dtype=bool))
    assert set(back.about.pop("made")) == {"date", "command", "versions"}
    assert back.about == held.about
    for name in (None, ["a"]):
        with pytest.raises(FileFormatError, match="holds a, b"):
            ContactCurve.from_hdf5(tmp_path / "r.h5", name)


def test_a_file_that_is_read_and_written_is_the_same_to_the_byte(tmp_path):
    """With its parts in their order, so that tables of a curve and of its file are alike."""
    curve = dataclasses.replace(power_law_curve(), extra={"z": np.arange(12), "a": np.ones(12)})
    held = ResultFile(
        {"second": curve, "first": power_law_curve(broken=2)},
        {"t": structured({"n": [1, 2], "word": ["µ", ""]}), "s": structured({"x": [0.5]})},
        {"m": np.eye(3), "h": np.eye(3) > 0},
    )
    write_results(tmp_path / "1.h5", held)
    back = read_results(tmp_path / "1.h5")
    assert list(back.curves["second"].columns()) == list(curve.columns())
    assert [*back.curves, *back.tables, *back.maps] == ["second", "first", "t", "s", "m", "h"]
    write_results(tmp_path / "2.h5", back)
    assert (tmp_path / "1.h5").read_bytes() == (tmp_path / "2.h5").read_bytes()


@pytest.mark.parametrize("name", ["steel/glass", "", "."])
def test_a_name_that_a_file_cannot_hold_is_refused(tmp_path, name):
    """It would be written where it cannot be read."""
    for odd in ({"model": name}, {"extra": {name: np.ones(12)}}):
        with pytest.raises(InputError, match="is no name in a results file"):
            dataclasses.replace(power_law_curve(), **odd).to_hdf5(tmp_path / "r.h5")
    assert not list(tmp_path.iterdir())


def test_an_interrupted_write_leaves_the_old_file(tmp_path):
    power_law_curve().to_hdf5(tmp_path / "r.h5")
    broken = ResultFile(curves={"a": power_law_curve()}, tables={"bad": np.array([object()])})
    with pytest.raises(TypeError):
        write_results(tmp_path / "r.h5", broken)
    assert len(ContactCurve.from_hdf5(tmp_path / "r.h5")) == 12
    assert [p.name for p in tmp_path.iterdir()] == ["r.h5"]


def test_threads_that_write_one_file_leave_each_other_alone(tmp_path):
    path = tmp_path / "c.csv"
    with replacing(path) as part:
        part.write_text("first")
        other = threading.Thread(target=write_csv, args=(path, {"load": [1.0]}))
        other.start()
        other.join()
        assert path.read_text().split() == ["load", "1.0"]
    assert path.read_text() == "first"
    assert [file.name for file in tmp_path.iterdir()] == ["c.csv"]


def test_unreadable_results_are_one_sentence(tmp_path):
    with pytest.raises(FileFormatError, match="no such results file"):
        read_results(tmp_path / "none.h5")
    (tmp_path / "text.h5").write_text("not HDF5")
    with pytest.raises(FileFormatError, match="not a readable results file"):
        read_results(tmp_path / "text.h5")
    power_law_curve().to_hdf5(tmp_path / "r.h5")
    whole = (tmp_path / "r.h5").read_bytes()
    (tmp_path / "half.h5").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(FileFormatError, match="not a readable results file"):
        read_results(tmp_path / "half.h5")


def _facts(path):
    """All that a file says about its curve, as text."""
    curve = ContactCurve.from_hdf5(path)
    arrays = {**{name: getattr(curve, name) for name in POINT_FIELDS}, **curve.extra}
    text = curve.reasons, curve.model, curve.settings, curve.seconds, curve.version
    return repr(({name: array.tolist() for name, array in arrays.items()}, text))


def test_a_flipped_bit_changes_no_curve_in_silence(tmp_path):
    power_law_curve(broken=3).to_hdf5(tmp_path / "r.h5")
    whole, facts = (tmp_path / "r.h5").read_bytes(), _facts(tmp_path / "r.h5")
    rng, refused = np.random.default_rng(1), 0
    for place, bit in rng.integers((len(whole), 8), size=(400, 2)).tolist():
        changed = bytearray(whole)
        changed[place] ^= 1 << bit
        (tmp_path / "changed.h5").write_bytes(changed)
        try:
            assert _facts(tmp_path / "changed.h5") == facts
        except FileFormatError:
            refused += 1
    assert refused > 200


def test_text_of_any_length_in_files_of_earlier_versions_is_read(tmp_path):
    power_law_curve(broken=3).to_hdf5(tmp_path / "r.h5")
    facts = _facts(tmp_path / "r.h5")
    with h5py.File(tmp_path / "r.h5", "r+") as file:
        for group in (file, file["curves/asperity"]):
            for name, text in dict(group.attrs).items():
                group.attrs[name] = text.decode()
        reasons = file["curves/asperity/reasons"].asstr()[()]
        _replaced(file["curves/asperity"], "reasons", reasons.astype(object))
    assert _facts(tmp_path / "r.h5") == facts


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda group: group.__delitem__("load"), "lacks load"),
        (lambda group: group.attrs.__delitem__("settings"), "lacks settings"),
        (lambda group: _replaced(group, "load", [b"heavy"] * 12), "column load holds no numbers"),
        (lambda group: _replaced(group, "load", [1.0]), r"load has shape \(1,\)"),
        (
            lambda group: group.__setitem__("extra/area_error_estimate", [b"small"] * 12),
            "area_error_estimate is .* must hold numbers",
        ),
    ],
)
def test_a_curve_with_a_column_missing_or_in_words_is_one_sentence(tmp_path, change, match):
    power_law_curve().to_hdf5(tmp_path / "r.h5")
    with h5py.File(tmp_path / "r.h5", "r+") as file:
        change(file["curves/asperity"])
    with pytest.raises(FileFormatError, match=match):
        ContactCurve.from_hdf5(tmp_path / "r.h5")


def _replaced(group, name, values):
    del group[name]
    group[name] = values


def test_no_folder_to_write_into(tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        power_law_curve().to_hdf5(tmp_path / "absent" / "r.h5")


def test_a_full_disk_is_one_sentence_and_leaves_the_file_that_was_there(tmp_path):
    """However much of the file it takes; the HDF5 library fails when it closes such a file."""
    path, (soft, hard) = tmp_path / "r.h5", resource.getrlimit(resource.RLIMIT_FSIZE)
    write_results(path, ResultFile({"old": power_law_curve()}))
    size = path.stat().st_size
    for room in (0, size // 2, size - 100):
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, hard))
        try:
            with pytest.raises(InputError, match=r"r\.h5: cannot be written"):
                write_results(path, ResultFile({"new": power_law_curve()}))
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert list(read_results(path).curves) == ["old"]
    assert [file.name for file in tmp_path.iterdir()] == ["r.h5"]
