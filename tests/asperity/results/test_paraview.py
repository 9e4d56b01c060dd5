"""ParaView files hold the fields that were given, in the right directions."""

from __future__ import annotations

import numpy as np
import pytest
from vti import read_vti

from asperity.errors import InputError
from asperity.results.paraview import write_vti


@pytest.mark.parametrize("dtype", [np.float64, np.float32, bool, np.int64, ">f8", np.float16])
def test_fields_come_back_with_x_running_fastest(tmp_path, dtype):
    field = np.arange(12).reshape(3, 4).astype(dtype)
    write_vti(tmp_path / "f.vti", {"pressure": field, "gap": -field.astype(float)}, (2e-9, 1e-9))
    cells, spacing, fields = read_vti(tmp_path / "f.vti")
    assert cells == (4, 3)
    assert spacing == (1e-9, 2e-9)
    np.testing.assert_array_equal(fields["pressure"], field.astype(float).ravel())
    np.testing.assert_array_equal(fields["gap"], -field.astype(float).ravel())


def test_a_transposed_view_is_written_as_it_is_seen(tmp_path):
    field = np.arange(6.0).reshape(2, 3).T
    write_vti(tmp_path / "f.vti", {"p": field}, (1.0, 1.0))
    np.testing.assert_array_equal(read_vti(tmp_path / "f.vti")[2]["p"], field.ravel())


@pytest.mark.parametrize("dtype", [float, int, bool])
def test_masked_values_are_not_shown(tmp_path, dtype):
    field = np.ma.masked_equal(np.eye(2, 3, dtype=dtype), 0)
    write_vti(tmp_path / "f.vti", {"p": field}, (1.0, 1.0))
    nan = np.nan
    np.testing.assert_array_equal(
        read_vti(tmp_path / "f.vti")[2]["p"], [1.0, nan, nan, nan, 1.0, nan]
    )


@pytest.mark.parametrize("spacing", [np.array([2e-9, 1e-9]), np.float32(1.0)])
def test_spacing_may_be_numbers_of_numpy(tmp_path, spacing):
    write_vti(tmp_path / "f.vti", {"p": np.ones((2, 3))}, spacing)
    dy, dx = np.broadcast_to(spacing, 2)
    assert read_vti(tmp_path / "f.vti")[1] == (dx, dy)


@pytest.mark.parametrize("spacing", [0.0, (1.0, np.nan), (1.0, 1.0, 1.0), "pixel"])
def test_no_pixel_size_is_refused(tmp_path, spacing):
    with pytest.raises(InputError, match="spacing is"):
        write_vti(tmp_path / "f.vti", {"p": np.ones((2, 3))}, spacing)


@pytest.mark.parametrize(
    "fields",
    [
        np.eye(3),
        {"a": np.eye(3) * 1j},
        {"a": [["x", "y"]]},
        {"a": [[1, 2], [3]]},
        {1: np.eye(3)},
        {"\0": np.eye(3)},
    ],
)
def test_fields_without_names_or_numbers_are_refused(tmp_path, fields):
    with pytest.raises(InputError, match=r"by name|must hold real numbers|is called"):
        write_vti(tmp_path / "f.vti", fields, (1.0, 1.0))


@pytest.mark.parametrize("fields", [{}, {"a": np.zeros(3)}, {"a": np.eye(2), "b": np.eye(3)}])
def test_what_is_no_image_is_refused(tmp_path, fields):
    with pytest.raises(InputError, match="one shape"):
        write_vti(tmp_path / "f.vti", fields, (1.0, 1.0))
