"""Reads ParaView image files by the rules of the format, for the tests of what we write."""

from __future__ import annotations

import base64
from xml.etree import ElementTree

import numpy as np

NUMPY_TYPES = {"Float64": np.float64, "Float32": np.float32, "UInt8": np.uint8, "Int64": np.int64}


def read_vti(path):
    """Cells (x, y), spacing (x, y) and the flat data of each field, by the format's own rules."""
    root = ElementTree.parse(path).getroot()
    assert (root.get("type"), root.get("header_type")) == ("ImageData", "UInt64")
    image = root.find("ImageData")
    x0, x1, y0, y1, z0, z1 = map(int, image.get("WholeExtent").split())
    assert z0 == z1 == 0
    fields = {}
    for data in image.iter("DataArray"):
        raw = base64.b64decode(data.text)
        count = int(np.frombuffer(raw[:8], np.uint64)[0])
        assert count == len(raw) - 8
        fields[data.get("Name")] = np.frombuffer(raw[8:], NUMPY_TYPES[data.get("type")])
    spacing = tuple(map(float, image.get("Spacing").split()))
    return (x1 - x0, y1 - y0), spacing[:2], fields
