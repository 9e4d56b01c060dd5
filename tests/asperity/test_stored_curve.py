"""The curve of a map that stays on disk is that of the map in memory."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
import surfaces
from asperity.multiscale import spectrum_shells
from surfaces.files.stored_map import StoredMap
from surfaces.numerics import splines, stored_array
from surfaces.peaks import strips

STEEL = asperity.HalfSpace(210e9, 0.3)


def scene(kind: str) -> surfaces.HeightMap:
    size = 240e-6, 256e-6
    if kind == "smooth":
        return surfaces.self_affine(
            (240, 256), size, hurst=0.8, rms_slope=0.1, rolloff=120e-6, cutoff=40e-6
        )
    if kind.startswith("as given"):
        hm = surfaces.self_affine(
            (240, 256), size, hurst=0.8, rms_slope=0.1, rolloff=60e-6, cutoff=6e-6
        )
        if kind.endswith("worn"):
            hm = hm.replace(heights=np.minimum(hm.heights, np.quantile(hm.heights, 0.97)))
        return hm.replace(periodic=kind.endswith("periodic"))
    rough = surfaces.self_affine((480, 512), size, hurst=0.8, rms_slope=0.1)
    return rough if kind == "rough" else rough.replace(periodic=False)


@pytest.mark.parametrize(
    "kind",
    ["rough", "rough, free", "smooth", "as given, periodic", "as given, free", "as given, worn"],
)
def test_curve_from_disk(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    hm = scene(kind)
    monkeypatch.setattr(stored_array, "BLOCK_BYTES", 8 * hm.shape[1] * 50)
    monkeypatch.setattr(spectrum_shells, "BLOCK_BYTES", 2 * hm.shape[0] * 40)
    monkeypatch.setattr(strips, "BLOCK_BYTES", 8 * hm.shape[1] * 30)
    monkeypatch.setattr(splines, "BLOCK_BYTES", 8 * hm.shape[1])
    blocks = ((row, hm.heights[row : row + 64]) for row in range(0, len(hm.heights), 64))
    kept = StoredMap.of_blocks(blocks, hm.shape, np.float64, hm.spacing, periodic=hm.periodic)
    known, found = (asperity.contact_curve(each, STEEL) for each in (hm, kept))
    assert "heights" not in vars(kept)
    assert found.settings["input"] == known.settings["input"]
    assert found.settings["warnings"] == known.settings["warnings"]
    for name, values in known.columns().items():
        if values.dtype.kind == "f":
            np.testing.assert_allclose(found.columns()[name], values, rtol=1e-6, err_msg=name)
