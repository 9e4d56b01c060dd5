"""The half-space: closed values of E_m*, limits, pairs, refusals."""

from __future__ import annotations

import numpy as np
import pytest

from asperity import HalfSpace, InputError

EXPONENTS = (-0.5, -0.3, 0.0, 0.3, 0.5, 0.8)
TABLE = {
    0.0: (0.4374157243, 0.6923794117, 1.0, 1.1019069544, 1.0008939632, 0.5364200809),
    0.3: (0.4017282127, 0.6855158373, 1.0989010989, 1.3199977231, 1.2542952221, 0.7059653655),
    0.5: (0.4028330022, 0.7390270006, 1.3333333333, 1.8711179382, 2.1059092039, 2.1991608295),
}


@pytest.mark.parametrize("nu", TABLE)
def test_graded_modulus_matches_the_direct_integration_of_the_layer(nu):
    values = [HalfSpace(1.0, nu, m).modulus for m in EXPONENTS]
    np.testing.assert_allclose(values, TABLE[nu], atol=6e-11)


def test_homogeneous_limit_is_smooth():
    step = 1e-6
    up, mid, down = (HalfSpace(1.0, 0.3, m).modulus for m in (step, 0.0, -step))
    assert mid == 1 / (1 - 0.3**2)
    assert (up - down) / (2 * step) / mid == pytest.approx(1.0714, abs=1e-4)


def test_gibson_soil_tends_to_the_winkler_foundation():
    assert HalfSpace(1.0, 0.5, 1 - 1e-9).modulus == pytest.approx(2 * np.pi / 3, rel=1e-7)


def test_pair_adds_compliances_and_keeps_the_grading():
    first, second = HalfSpace(2e9, 0.3, 0.2), HalfSpace.from_modulus(5e9, 0.2)
    both = HalfSpace.pair(first, second)
    assert 1 / both.modulus == pytest.approx(1 / first.modulus + 1 / second.modulus, rel=1e-15)
    assert both.m == 0.2 and both.E is None


def test_the_softer_body_bounds_the_pressure_of_a_pair():
    hard, soft = HalfSpace(2e11, 0.3), HalfSpace(1e11, 0.3, hardness=1e9)
    assert HalfSpace.pair(hard, soft).hardness == 1e9
    assert HalfSpace.pair(hard, hard).hardness == np.inf


def test_the_elastic_body_of_a_hard_one_differs_by_its_hardness_alone():
    body = HalfSpace(2e11, 0.3, 0.2, hardness=1e9)
    assert body.elastic == HalfSpace(2e11, 0.3, 0.2)
    bare = HalfSpace.from_modulus(3.0, 0.1, hardness=2.0)
    assert bare.hardness == 2.0 and bare.elastic == HalfSpace.from_modulus(3.0, 0.1)


def test_none_is_a_body_without_a_hardness():
    for body in (HalfSpace(1.0, 0.3, hardness=None), HalfSpace.from_modulus(1.0, hardness=None)):
        assert body.hardness == np.inf
    assert HalfSpace(1.0, 0.3, hardness=None) == HalfSpace(1.0, 0.3)
    with pytest.raises(TypeError):
        HalfSpace(1.0, 0.3, 0.0, 2.0)


@pytest.mark.parametrize("hardness", [0.0, -1.0, float("nan"), -float("inf"), "soft", 1e80])
def test_a_hardness_that_is_none_is_refused(hardness):
    with pytest.raises(InputError, match="hardness"):
        HalfSpace(1.0, 0.3, hardness=hardness)


def test_pair_with_a_bare_modulus_is_refused():
    with pytest.raises(InputError, match="not float"):
        HalfSpace.pair(HalfSpace.from_modulus(1e9), 1e9)


def test_pair_of_unequal_gradings_is_refused():
    with pytest.raises(InputError, match="no composite modulus"):
        HalfSpace.pair(HalfSpace(1.0, 0.3), HalfSpace(1.0, 0.3, 0.1))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((-1.0, 0.3), "E must be positive"),
        ((1.0, 0.6), "nu must lie"),
        ((1.0, -1.0), "nu must lie"),
        ((1.0, 0.3, 1.0), "m must lie"),
        ((float("nan"), 0.3), "E must be finite"),
        ((float("inf"), 0.3), "finite.*take the elastic one alone"),
        (("steel", 0.3), "must be a number"),
        ((1e-300, 0.3), "E is 1e-300 Pa.*check its unit"),
        ((1e300, 0.3), "E is 1e.300 Pa.*check its unit"),
    ],
)
def test_values_out_of_range_are_refused_in_one_sentence(arguments, message):
    with pytest.raises(InputError, match=message):
        HalfSpace(*arguments)
