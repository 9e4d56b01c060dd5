"""Warnings that a careful colleague would give: each with its number and cure, once."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import asperity
from surfaces import PowerLawProfile, crop, self_affine

HARD = asperity.HalfSpace.from_modulus(1e11, hardness=1e9)
SOLVERS = {
    "contact_curve": asperity.contact_curve,
    "bem_curve": asperity.bem_curve,
    "solve": asperity.solve,
    "compare": asperity.compare,
    "solve_contacts": asperity.solve_contacts,
    "bem_solve": lambda hm, body, pressures: asperity.bem_solve(hm, body, pressure=pressures[0]),
}


def smooth(shape=(48, 60), **changes):
    hm = self_affine(shape, (7.2e-5, 6e-5), hurst=0.8, rms_slope=0.1, cutoff=1e-5, seed=1)
    return hm.replace(**changes)


def wedge():
    hm = smooth(periodic=False)
    return hm.replace(heights=hm.heights + 0.3 * np.arange(60) * hm.spacing[1])


def cliff():
    hm = smooth()
    return hm.replace(heights=hm.heights + 0.3 * np.arange(60) * hm.spacing[1])


def noise():
    heights = np.random.default_rng(0).normal(size=(48, 60)) * 1e-8
    return smooth(heights=heights)


SCENES = {
    "tilt": (wedge, HARD, "a plane makes up 9", "--level plane"),
    "modulus in GPa": (smooth, asperity.HalfSpace(210.0, 0.3), "E* of 231 Pa", "210GPa"),
    "steep": (lambda: smooth(heights=8 * smooth().heights), HARD, "slope is 0.8", "not of a body"),
    "yields": (smooth, asperity.HalfSpace(210e9, 0.3), "% of the modulus", "--hardness"),
    "too coarse": (noise, HARD, "of the squared slope is lost", "--bandpass"),
    "seam": (cliff, HARD, "across its seam is", "--periodic taper"),
}


def told(solver, hm, body):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        solver(hm, body, pressures=[1e-4 * body.modulus])
    found = [one for one in caught if issubclass(one.category, asperity.ContactWarning)]
    assert all(one.filename == __file__ for one in found)
    return [str(one.message) for one in found]


@pytest.mark.parametrize("solver", SOLVERS)
def test_nothing_is_said_of_a_clean_scene(solver):
    assert told(SOLVERS[solver], smooth((144, 180)), HARD) == []


@pytest.mark.parametrize("scene", SCENES)
def test_each_doubt_is_told_once_with_its_number_and_its_cure(scene):
    hm, body, number, cure = SCENES[scene]
    (found,) = [text for text in told(SOLVERS["bem_solve"], hm(), body) if number in text]
    assert cure in found


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("scene", ["tilt", "yields"])
def test_every_solver_tells_what_the_scene_makes_doubtful(solver, scene):
    hm, body, number, _ = SCENES[scene]
    assert sum(number in text for text in told(SOLVERS[solver], hm(), body)) == 1


@pytest.mark.parametrize("solver", [asperity.indent, asperity.indent_bem])
def test_one_contact_tells_of_a_modulus_in_gpa(solver):
    with pytest.warns(asperity.ContactWarning, match="moduli are in Pa") as caught:
        solver(PowerLawProfile(2, 1.0), asperity.HalfSpace(210.0, 0.3), 0.01)
    assert len(caught) == 1


def test_a_modulus_of_one_is_a_unit(recwarn):
    asperity.indent(PowerLawProfile(2, 1.0), asperity.HalfSpace.from_modulus(1.0), 0.01)
    assert not recwarn.list


def test_a_solver_that_fails_leaves_the_next_one_its_voice():
    with pytest.raises(asperity.InputError):
        asperity.bem_solve(smooth(), HARD)
    assert len(told(SOLVERS["bem_solve"], wedge(), HARD)) == 1


def test_a_map_is_judged_by_the_boundary_that_it_is_pressed_with():
    """A window pressed as a cell was not told of its seam, and errors were stated that the load
    exceeded eightfold; one flagged periodic and pressed free was told of a seam that it lacks."""
    whole = self_affine((128, 128), (128.0, 128.0), hurst=0.8, rms_slope=0.05, cutoff=8.0, seed=2)
    window = crop(whole, rows=(0, 64), columns=(0, 64))
    tilt = 10.0 * whole.rms_height * np.linspace(0.0, 1.0, 64)
    window = window.replace(heights=window.heights + tilt)
    body, loads = asperity.HalfSpace.from_modulus(1.0), {"pressures": [3e-5, 1e-4, 1e-3]}
    for flag in (True, False):
        asked = {"boundary": "free" if flag else "periodic", **loads}
        for door in (asperity.contact_curve, asperity.bem_curve, asperity.solve):
            odd = door(window.replace(periodic=flag), body, **asked)
            plain = door(window.replace(periodic=not flag), body, **loads)
            assert odd.settings["warnings"] == plain.settings["warnings"]
            assert any("seam" in why for why in odd.settings["warnings"]) is not flag
            for name in ("separation", "contact_area", "error_estimate"):
                np.testing.assert_array_equal(getattr(odd, name), getattr(plain, name))
