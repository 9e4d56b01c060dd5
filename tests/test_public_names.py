"""Names, order and defaults that scripts rely on; they may grow, but not change."""

from __future__ import annotations

import inspect

import numpy as np
import pytest

import asperity
import surfaces

PROMISED = {
    surfaces.read: "path, *, dataset=None, unit=None, spacing=None",
    surfaces.self_affine: "shape, size, *, hurst, rms_slope=None, rms_height=None, rolloff=None, "
    "cutoff=None, anisotropy=1.0, angle=0.0, seed=0",
    surfaces.HeightMap: "heights, spacing, *, periodic=False, name=''",
    surfaces.prepare: "hm, *, level='plane', fill='harmonic', outliers=None, bandpass=None, "
    "periodic=None",
    surfaces.write: "hm, path",
    surfaces.segment: "hm, *, above=None, min_prominence=0.0",
    surfaces.fit_profiles: "hm, peaks",
    surfaces.PowerLawProfile: "k, psi",
    surfaces.PolarProfile: "r, phi, f",
    asperity.HalfSpace: "E, nu, m=0.0, *, hardness=None",
    asperity.HalfSpace.from_modulus: "modulus, m=0.0, *, hardness=None",
    asperity.indent: "profile, material, approach, *, law='harmonic'",
    asperity.indent_bem: "profile, material, approach, *, grid=256, tolerance=1e-6",
    asperity.contact_curve: "hm, material, *, pressures=None, separations=None, law='auto', "
    "interaction=True, plan=None",
    asperity.bem_curve: "hm, material, *, pressures=None, separations=None, tolerance=1e-6, "
    "boundary=None",
    asperity.bem_solve: "hm, material, *, pressure=None, separation=None, tolerance=1e-6, "
    "boundary=None, guess=None",
    asperity.solve: "hm, material, *, pressures=None, separations=None, accuracy=0.05, "
    "verify='auto'",
    asperity.compare: "hm, material, *, pressures=None",
}


@pytest.mark.parametrize("function", PROMISED, ids=lambda f: f.__qualname__)
def test_arguments_are_those_promised(function):
    promised = inspect.signature(eval(f"lambda {PROMISED[function]}: None")).parameters.values()
    found = inspect.signature(function).parameters
    ordered = [name for name, one in found.items() if one.kind is one.POSITIONAL_OR_KEYWORD]
    by_order = [one.name for one in promised if one.kind is one.POSITIONAL_OR_KEYWORD]
    assert ordered[: len(by_order)] == by_order
    for one in promised:
        kept = found[one.name].default
        assert kept == one.default or one.default is inspect.Parameter.empty, one


def test_results_have_the_columns_promised():
    hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    body, loads = asperity.HalfSpace(1e9, 0.3), [1e6, 5e6]
    for engine in (asperity.solve, asperity.contact_curve, asperity.bem_curve):
        curve = engine(hm, body, pressures=loads)
        for name in (
            "separation mean_pressure load area_fraction contact_area contacts stiffness converged "
            "residual error_estimate"
        ).split():
            assert np.shape(getattr(curve, name)) == (2,), name
        assert curve.seconds and curve.settings and curve.version == asperity.__version__
    assert asperity.solve(hm, body, pressures=loads).settings["engine"] == "bem"
