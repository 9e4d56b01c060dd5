"""Fields of one load point as ParaView image data (``.vti``)."""

from __future__ import annotations

import base64
import os
import sys
from collections.abc import Mapping
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import ArrayLike

from asperity.errors import InputError
from surfaces.errors import checked_spacing
from surfaces.files.atomic import replacing

__all__ = ["write_vti"]

VTK_TYPES = {"f8": "Float64", "f4": "Float32", "i8": "Int64", "i4": "Int32", "u1": "UInt8"}


def write_vti(
    path: str | os.PathLike[str], fields: Mapping[str, ArrayLike], spacing: ArrayLike
) -> None:
    """Write fields over the pixels of a map as cell data of a VTK image.

    Parameters
    ----------
    path
        File to write, customarily ``.vti``; replaced at once when it is complete.
    fields
        Arrays by name, all of one shape (ny, nx): the first axis is y, as everywhere here.
    spacing
        Pixel size (dy, dx) [m], or one number for square pixels.

    Raises
    ------
    InputError
        If there is no field, shapes differ, a field holds no real numbers, or the file cannot be
        written.
    SurfaceError
        If the spacing is no pixel size.

    Notes
    -----
    VTK XML format 1.0 with inline base64 data: a UInt64 count of bytes, then the bytes with x
    running fastest.

    Examples
    --------
    >>> import tempfile
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     asperity.write_vti(f"{folder}/map.vti", {"height": hm.heights}, hm.spacing)
    ...     print(Path(f"{folder}/map.vti").read_text()[:21])
    <?xml version='1.0' e
    """
    if not isinstance(fields, Mapping):
        raise InputError('the fields of an image are given by name: {"pressure": pressure}')
    arrays = {name: _vtk_array(name, field) for name, field in fields.items()}
    shapes = {array.shape for array in arrays.values()}
    if len(shapes) != 1 or len(shape := shapes.pop()) != 2:
        raise InputError("the fields of an image must be (ny, nx) arrays of one shape")
    ny, nx = shape
    extent = f"0 {nx} 0 {ny} 0 0"
    order = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
    root = ElementTree.Element(
        "VTKFile", type="ImageData", version="1.0", byte_order=order, header_type="UInt64"
    )
    dy, dx = checked_spacing(spacing)
    image = ElementTree.SubElement(
        root, "ImageData", WholeExtent=extent, Origin="0 0 0", Spacing=f"{dx!r} {dy!r} {dx!r}"
    )
    piece = ElementTree.SubElement(image, "Piece", Extent=extent)
    cells = ElementTree.SubElement(piece, "CellData", Scalars=next(iter(arrays)))
    for name, array in arrays.items():
        kind = VTK_TYPES[array.dtype.str[1:]]
        data = ElementTree.SubElement(cells, "DataArray", type=kind, Name=name, format="binary")
        head = np.array([array.nbytes], dtype=np.uint64).tobytes()
        data.text = base64.b64encode(head + array.tobytes()).decode("ascii")
    with replacing(path) as partial:
        ElementTree.ElementTree(root).write(partial, encoding="utf-8", xml_declaration=True)


def _vtk_array(name: str, field: ArrayLike) -> np.ndarray:
    """The field in native byte order and in a type that VTK knows; masked values become NaN."""
    if not (isinstance(name, str) and name.isprintable()):
        raise InputError(f"a field of an image is called {name!r}; give a name that can be printed")
    try:
        given: Any = np.ma.asarray(field)
        if given.dtype.kind not in "biuf":
            raise ValueError
    except ValueError:
        raise InputError(f"the field {name!r} of an image must hold real numbers") from None
    hidden = np.ma.is_masked(given)
    array = np.ascontiguousarray(given.astype(float).filled(np.nan) if hidden else given.data)
    array = array.astype(array.dtype.newbyteorder("="))
    if array.dtype == bool:
        return array.astype(np.uint8)
    return array if array.dtype.str[1:] in VTK_TYPES else array.astype(float)
