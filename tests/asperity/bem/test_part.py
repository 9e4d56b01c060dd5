"""A part of a solved map, alone, bears what it bears on the whole map."""

from __future__ import annotations

import numpy as np
import pytest

import surfaces
from asperity import HalfSpace, bem_curve, bem_solve
from asperity.bem import part


@pytest.mark.parametrize("m", [0.0, 0.3, -0.3])
@pytest.mark.parametrize("hardness", [np.inf, 0.1])
@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_a_part_alone_bears_the_pressures_of_the_whole(monkeypatch, boundary, hardness, m):
    monkeypatch.setattr(part, "POINTS", 40)
    body = HalfSpace.from_modulus(1.0, m, hardness=hardness)
    hm = surfaces.self_affine((96, 64), (96.0, 80.0), hurst=0.8, rms_slope=0.1, seed=3) + 5.0
    seen = []
    bem_curve(
        hm, body, pressures=[1e-3, 6e-3], tolerance=1e-8, boundary=boundary, progress=seen.append
    )
    for load in seen:
        own = load.part.alone()
        assert own.shape == (40, 40) and own.spacing == hm.spacing
        assert load.part.pressure.any()
        found = bem_solve(
            own,
            body,
            pressure=min(load.part.pressure.mean(), hardness),
            tolerance=1e-8,
            boundary="periodic",
        )
        apart = np.abs(found.pressure - load.part.pressure).max()
        assert apart < 1e-4 * found.pressure.max()
        assert load.separation - own.heights.mean() == pytest.approx(found.separation, abs=1e-5)
        assert load.part.contact_area == pytest.approx(found.contact_area, rel=1e-6)


def test_a_part_of_a_shorter_side_takes_all_of_it():
    hm = surfaces.self_affine((24, 200), (24.0, 200.0), hurst=0.8, rms_slope=0.1, seed=1)
    seen = []
    bem_curve(hm, HalfSpace.from_modulus(1.0), pressures=[1e-3], progress=seen.append)
    assert seen[0].part.hm.shape == (24, part.POINTS)
