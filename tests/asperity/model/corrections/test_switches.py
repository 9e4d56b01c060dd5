"""Each correction can be switched off, and changes what it is for."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import asperity
from asperity.halfspace.scene import pressure_scale
from asperity.model.law_factory import CORRECTIONS
from asperity.parameters import DEFAULTS, Corrections, Parameters
from surfaces import HeightMap, self_affine

BODY = asperity.HalfSpace.from_modulus(1.0)


def rough(cutoff: float | None = 8.0, anisotropy: float = 1.0) -> HeightMap:
    """Waves of so many pixels and more on pixels that are not square."""
    return self_affine(
        (96, 120), (96.0, 144.0), hurst=0.8, rms_slope=0.1, cutoff=cutoff, seed=3,
        anisotropy=anisotropy,
    )  # fmt: skip


def tip() -> HeightMap:
    """A cone whose contact is small beside its rays."""
    y, x = (np.arange(n) - n // 2 for n in (256, 257))
    return HeightMap(-0.1 * np.hypot(y[:, None], x), (1.0, 1.0))


def answer(hm: HeightMap, load: float, parameters: Parameters) -> tuple[float, float]:
    """Contact area and stated error under a load in units of modulus and slope."""
    pressures = load * pressure_scale(hm, BODY)
    plan = asperity.make_plan(hm, BODY, pressures=pressures, parameters=parameters)
    curve = asperity.contact_curve(hm, BODY, pressures=pressures, plan=plan)
    return float(curve.contact_area[0]), float(curve.error_estimate[0])


CASES = {
    "contact_shift": (rough, 2e-2),
    "elongation": (lambda: rough(anisotropy=4.0), 2e-2),
    "pressed_basins": (rough, 1e-2),
    "joined_pairs": (rough, 1e-2),
    "tilted_basins": (
        lambda: self_affine(
            (96, 120), (96.0, 120.0), hurst=0.8, rms_slope=0.1, cutoff=4.0, seed=12
        ),
        3e-2,
    ),
    "sharp_tips": (tip, 1e-7),
    "wave_split": (
        lambda: self_affine((256, 320), (256.0, 320.0), hurst=0.8, rms_slope=0.1, seed=2),
        1e-2,
    ),
    "finer_grid": (
        lambda: self_affine(
            (96, 120), (96.0, 120.0), hurst=0.8, rms_slope=0.1, rolloff=24.0, cutoff=2.5, seed=2
        ),
        1e-2,
    ),
    "coarser_grid": (lambda: rough(cutoff=24.0), 1e-2),
}


@pytest.mark.parametrize("name", [field.name for field in fields(Corrections)])
def test_a_correction_switched_off_changes_the_answer(name):
    """On its own map; on one of the maps if the correction has none of its own."""
    off = replace(DEFAULTS, corrections=Corrections(**{name: False}))
    maps = [CASES[name]] if name in CASES else CASES.values()
    assert any(answer(make(), load, off) != answer(make(), load, DEFAULTS) for make, load in maps)


def test_every_correction_of_laws_has_a_switch():
    assert set(CORRECTIONS) <= {field.name for field in fields(Corrections)}


def test_the_code_of_every_row_of_the_ablation_is_there(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[4] / "benchmarks")
    from ablation import CORRECTIONS as rows
    from ablation import lines_of

    assert all(lines_of(row.objects) for row in rows.values())


def test_a_family_of_the_ablation_that_is_none_is_named(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[4] / "benchmarks")
    import ablation

    monkeypatch.setattr(ablation, "scenes", lambda maps: [SimpleNamespace(family="worn")])
    args = SimpleNamespace(only=[], families=["wrn"], maps=None)
    with pytest.raises(SystemExit, match=r"no family is called \['wrn'\]; there are \['worn'\]"):
        ablation.measure(args)
