"""What follows from a normal contact curve: conductance and partial slip."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import asperity
import surfaces
from asperity.errors import InputError
from asperity.extensions.conductance import constriction_conductance
from asperity.extensions.partial_slip import friction_curve
from surfaces import HeightMap

STEEL = asperity.HalfSpace(210e9, 0.3)
RADIUS = 1e-3


@pytest.fixture(scope="module")
def sphere() -> tuple[HeightMap, asperity.ContactCurve]:
    """One cap on pixels that are not square: every law is Hertz's."""
    y, x = (np.arange(61) - 30) * 1.2e-6, (np.arange(81) - 40) * 1e-6
    hm = HeightMap(-(x[None, :] ** 2 + y[:, None] ** 2) / (2 * RADIUS), (1.2e-6, 1e-6))
    depth = np.geomspace(1e-9, 2e-7, 40)
    return hm, asperity.contact_curve(hm, STEEL, separations=-hm.heights.mean() - depth)


def test_one_spot_conducts_as_holm_says(sphere):
    hm, curve = sphere
    conductance = constriction_conductance(curve, resistivity=(2e-7, 3e-7))
    radius = np.sqrt(curve.contact_area / np.pi)
    np.testing.assert_allclose(conductance * hm.area, 4 * radius / 5e-7, rtol=5e-3)
    one_alone = constriction_conductance(curve, resistivity=(0.0, 5e-7))
    np.testing.assert_allclose(one_alone, conductance, rtol=1e-12)


def test_partial_slip_of_one_sphere_is_cattaneo_mindlin(sphere):
    hm, curve = sphere
    pressure, mu, ratio = float(curve.mean_pressure[-5]), 0.4, 1.2
    slip = friction_curve(curve, pressure, friction=mu, modulus_ratio=ratio)
    whole = curve.at(pressure=pressure)
    depth = (0.75 * pressure * hm.area / (STEEL.modulus * np.sqrt(RADIUS))) ** (2 / 3)
    share = 1 - (1 - slip.shear / (mu * pressure)) ** (2 / 3)
    np.testing.assert_allclose(slip.displacement, mu * ratio * depth * share, atol=2e-3 * depth)
    np.testing.assert_allclose(
        slip.stick_area_fraction,
        whole.area_fraction * (1 - slip.shear / slip.slip_shear) ** (2 / 3),
        rtol=1e-2,
    )
    assert slip.shear[0] == pytest.approx(0.0, abs=1e-9 * pressure)
    assert (np.diff(slip.shear) > 0).all()
    assert (slip.shear < slip.slip_shear).all()


def test_a_point_that_did_not_converge_conducts_nothing_known(sphere):
    failed = np.arange(len(sphere[1])) == 3
    curve = dataclasses.replace(sphere[1], converged=~failed)
    found = constriction_conductance(curve, resistivity=(2e-7, 3e-7))
    np.testing.assert_array_equal(np.isnan(found), failed)


def test_graded_bodies_are_refused(sphere):
    graded = dataclasses.replace(sphere[1], settings={"m": 0.3})
    with pytest.raises(InputError, match="m = 0"):
        constriction_conductance(graded, modulus=1e9, resistivity=(1.0, 1.0))
    with pytest.raises(InputError, match="m = 0"):
        friction_curve(graded, 1e6, friction=0.3, modulus_ratio=1.0)


def test_numbers_out_of_range(sphere):
    with pytest.raises(InputError, match="positive"):
        constriction_conductance(sphere[1], modulus=-1.0, resistivity=(1.0, 1.0))
    with pytest.raises(InputError, match="must not be negative"):
        constriction_conductance(sphere[1], resistivity=(-1.0, 2.0))
    with pytest.raises(InputError, match="each of two bodies"):
        constriction_conductance(sphere[1], resistivity=2.0)
    with pytest.raises(InputError, match="modulus is None"):
        constriction_conductance(
            dataclasses.replace(sphere[1], settings={}), resistivity=(1.0, 1.0)
        )
    with pytest.raises(InputError, match="positive"):
        friction_curve(sphere[1], 1e6, friction=0.0, modulus_ratio=1.0)
    with pytest.raises(InputError, match="outside the converged curve"):
        friction_curve(sphere[1], 1e15, friction=0.3, modulus_ratio=1.0)
    with pytest.raises(InputError, match="lighter load points"):
        friction_curve(sphere[1], float(sphere[1].mean_pressure[0]), friction=1, modulus_ratio=1)


def test_the_lightest_load_point_asked_for_has_no_partial_slip(sphere):
    """A solved pressure may lie below the one that was asked for by the tolerance of the solve."""
    asked = float(sphere[1].mean_pressure[0]) * (1 + 1e-6)
    with pytest.raises(InputError, match="lighter load points"):
        friction_curve(sphere[1], asked, friction=0.3, modulus_ratio=1.2)


@pytest.mark.parametrize("curve", [None, "results.h5", STEEL])
def test_what_is_no_curve_is_refused(curve):
    with pytest.raises(InputError, match="contact curve is needed"):
        constriction_conductance(curve, resistivity=(1.0, 1.0))
    with pytest.raises(InputError, match="contact curve is needed"):
        friction_curve(curve, 1e6, friction=0.3, modulus_ratio=1.2)


@pytest.mark.parametrize(
    "wrong",
    [{"friction": "0.3"}, {"friction": [0.3, 0.4]}, {"modulus_ratio": None}, {"points": 2.5}],
)
def test_what_is_no_number_is_refused(sphere, wrong):
    curve = sphere[1]
    case = {"friction": 0.3, "modulus_ratio": 1.2} | wrong
    with pytest.raises(InputError, match="number"):
        friction_curve(curve, float(curve.mean_pressure[-1]), **case)
    with pytest.raises(InputError, match="number"):
        constriction_conductance(curve, resistivity=("1e-7", 1e-7))


def test_a_hardness_is_refused_where_superposition_ends():
    hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    hard = asperity.HalfSpace(210e9, 0.3, hardness=2e9)
    curve = asperity.contact_curve(hm, hard, pressures=[1e7, 1e8])
    for slip in (
        lambda: asperity.friction_curve(curve, 1e8, friction=0.3, modulus_ratio=1.2),
        lambda: asperity.partial_slip(
            surfaces.PowerLawProfile(2.0, 50.0),
            hard,
            1e-6,
            friction=0.3,
            modulus_ratio=1.2,
            tangential_force=1.0,
        ),
    ):
        with pytest.raises(asperity.InputError, match="leave the hardness out"):
            slip()
