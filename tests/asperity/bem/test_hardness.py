"""A hardness in the boundary elements: bounds, certificate, limits, oracles, laws of scaling."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import periodic_displacement
from scipy.integrate import trapezoid
from scipy.optimize import minimize
from strategies import rough

from asperity import HalfSpace, bem_curve, bem_solve, errors, indent_bem
from asperity.bem.certificate import Prescribed, certify
from surfaces import HeightMap, PowerLawProfile

BODY = HalfSpace.from_modulus(1.0)
HM = rough((48, 60))
SCALE = HM.roughness.rms_slope
"""E* times the rms slope of the map."""


def body(x, m=0.0):
    """Half-space whose hardness is x times E* h'."""
    return HalfSpace.from_modulus(1.0, m, hardness=x * SCALE)


def test_no_cap_and_a_cap_out_of_reach_are_the_same():
    elastic = bem_solve(HM, BODY, pressure=0.05 * SCALE)
    assert not elastic.saturated.any() and not elastic.plastic_depth.any()
    assert elastic.plastic_share == elastic.certificate.lift == 0.0
    assert "hardness" not in elastic.settings
    for hardness in (np.inf, 1e6):
        capped = bem_solve(
            HM, HalfSpace.from_modulus(1.0, hardness=hardness), pressure=0.05 * SCALE
        )
        np.testing.assert_array_equal(capped.pressure, elastic.pressure)
        assert capped.separation == elastic.separation
        assert capped.contact_area == elastic.contact_area
        assert capped.certificate.worst == pytest.approx(elastic.certificate.worst, rel=1e-8)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("m", [0.0, 0.5, -0.5])
@pytest.mark.parametrize("x", [0.02, 0.2, 1.0])
def test_the_conditions_of_the_problem(boundary, m, x):
    """Bounds, gap and depth fit each other; the separation found gives the load back."""
    mat = body(x, m)
    load = 0.1 * mat.hardness
    found = bem_solve(HM, mat, pressure=load, boundary=boundary)
    assert found.converged and found.fft_pairs <= 9
    p, depth, gap = found.pressure, found.plastic_depth, found.gap
    assert p.min() >= 0.0 and p.max() <= mat.hardness
    assert found.mean_pressure == pytest.approx(load, rel=1e-11)
    assert not depth[~found.saturated].any() and (depth >= 0.0).all()
    small = 5e-6 * HM.rms_height
    assert np.abs(gap[found.contact]).max() < small and gap.min() > -small
    assert found.area_fraction >= load / mat.hardness * (1 - 1e-12)
    again = bem_solve(HM, mat, separation=found.separation, boundary=boundary)
    assert again.converged
    assert again.mean_pressure == pytest.approx(load, rel=1e-4)


def lowest_energy(matrix, heights, load, hardness):
    """Pressure of least energy between its bounds at a load, by a general solver."""
    n = heights.size
    found = minimize(
        lambda p: 0.5 * p @ matrix @ p - p @ heights,
        np.full(n, load),
        jac=lambda p: matrix @ p - heights,
        bounds=[(0.0, hardness)] * n,
        constraints={"type": "eq", "fun": lambda p: p.sum() - n * load, "jac": np.ones_like},
        method="SLSQP",
        options={"ftol": 1e-16, "maxiter": 500},
    )
    return found.x


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_against_a_general_solver(seed, share):
    rng = np.random.default_rng(seed)
    shape, spacing = (8, 8), (1.0, 0.7)
    heights = rng.standard_normal(shape)
    heights -= heights.mean()
    hm = HeightMap(heights, spacing, periodic=True)
    units = np.eye(64).reshape(64, *shape)
    matrix = np.array([periodic_displacement(one, spacing, 1.0, 0.0).ravel() for one in units])
    hardness = 0.4
    mat = HalfSpace.from_modulus(1.0, hardness=hardness)
    found = bem_solve(hm, mat, pressure=share * hardness, tolerance=1e-9)
    exact = lowest_energy(matrix, heights.ravel(), share * hardness, hardness)
    np.testing.assert_allclose(found.pressure.ravel(), exact, atol=2e-5 * hardness)


def certificate_of(pressure, hm, hardness):
    """Certificate of a periodic pressure on a body of unit modulus, and its energy."""
    displacement = periodic_displacement(pressure, hm.spacing, 1.0, 0.0)
    h = hm.heights - hm.heights.mean()
    reading = certify(
        pressure,
        displacement,
        h,
        h.std(),
        cap=hardness,
        goal=Prescribed(float(np.minimum(pressure, hardness).mean())),
    )
    energy = (pressure * (0.5 * displacement - h)).sum()
    return reading.certificate, energy


@pytest.mark.parametrize("x", [0.05, 0.5, np.inf])
def test_the_certificate_bounds_the_energy(x):
    mat = body(x)
    exact = bem_solve(HM, mat, pressure=0.04 * SCALE, tolerance=1e-10).pressure
    _, least = certificate_of(exact, HM, mat.hardness)
    rng = np.random.default_rng(3)
    for _ in range(20):
        other = rng.random(HM.shape) < rng.uniform(0.2, 1.0)
        other = np.where(other, rng.random(HM.shape), 0.0)
        other *= min(1.0, mat.hardness) / 2
        share = rng.random() ** 3
        mixed = (1 - share) * exact + share * other * exact.sum() / other.sum()
        if mixed.max() > mat.hardness:
            continue
        certificate, energy = certificate_of(mixed, HM, mat.hardness)
        bound = certificate.complementarity * mixed.sum() * HM.heights.std()
        assert -1e-9 * abs(least) <= energy - least <= bound * (1 + 1e-9)


def test_the_certificate_sees_each_violation():
    mat = body(0.2)
    exact = bem_solve(HM, mat, pressure=0.05 * SCALE, tolerance=1e-9)
    good, _ = certificate_of(exact.pressure, HM, mat.hardness)
    assert good.worst < 1e-8
    over = exact.pressure.copy()
    over[exact.saturated] *= 1.001
    assert certificate_of(over, HM, mat.hardness)[0].load > 5e-4
    elastic = bem_solve(HM, BODY, pressure=0.05 * SCALE).pressure
    assert certificate_of(elastic, HM, mat.hardness)[0].worst > 0.1
    clipped = np.minimum(elastic, mat.hardness)
    clipped *= np.where(clipped < mat.hardness, 1.1, 1.0)
    assert certificate_of(clipped, HM, mat.hardness)[0].worst > 1e-3
    highest = bem_solve(HM, mat, pressure=0.02 * SCALE).gap.argmax()
    lifted = exact.pressure.copy().ravel()
    lifted[highest] = mat.hardness
    assert certificate_of(lifted.reshape(HM.shape), HM, mat.hardness)[0].lift > 0.1


def test_soft_limit():
    """H -> 0: the area is the load over the hardness, the separation that of the bearing curve."""
    for share in (0.02, 0.1, 0.4):
        found = bem_solve(HM, body(1e-4), pressure=share * body(1e-4).hardness)
        h = HM.heights - HM.heights.mean()
        assert found.area_fraction == pytest.approx(share, rel=1e-3)
        bearing = np.quantile(h, 1 - share)
        assert found.separation == pytest.approx(bearing, abs=0.02 * h.std())
        place = np.sort(h.ravel())[::-1][int(share * h.size)]
        assert found.separation == pytest.approx(place, abs=1e-3 * h.std())
        assert found.plastic_share > 1 - 1.01 / found.contact.sum()


@settings(max_examples=10, deadline=None)
@given(x=st.floats(0.01, 2.0), share=st.floats(0.01, 0.99), factor=st.floats(0.01, 100.0))
def test_scaling_laws(x, share, factor):
    """Pressures go with the modulus; lengths all together."""
    mat = body(x)
    base = bem_solve(HM, mat, pressure=share * mat.hardness, tolerance=1e-8)
    stiff = HalfSpace.from_modulus(factor, hardness=factor * mat.hardness)
    found = bem_solve(HM, stiff, pressure=share * stiff.hardness, tolerance=1e-8)
    assert found.separation == pytest.approx(base.separation, abs=1e-6 * HM.rms_height)
    assert found.area_fraction == pytest.approx(base.area_fraction, rel=1e-2)
    dy, dx = HM.spacing
    large = HeightMap(HM.heights * factor, (dy * factor, dx * factor), periodic=True)
    found = bem_solve(large, mat, pressure=share * mat.hardness, tolerance=1e-8)
    assert found.separation / factor == pytest.approx(base.separation, abs=1e-6 * HM.rms_height)


def test_symmetry():
    mat = body(0.2)
    base = bem_solve(HM, mat, pressure=0.05 * SCALE, tolerance=1e-9)
    for turn in (np.fliplr, np.flipud, np.transpose):
        spacing = HM.spacing[::-1] if turn is np.transpose else HM.spacing
        other = HeightMap(np.ascontiguousarray(turn(HM.heights)), spacing, periodic=True)
        found = bem_solve(other, mat, pressure=0.05 * SCALE, tolerance=1e-9)
        np.testing.assert_allclose(found.pressure, turn(base.pressure), atol=1e-5 * mat.hardness)
        assert found.separation == pytest.approx(base.separation, abs=1e-8 * HM.rms_height)


def test_monotone_in_the_hardness():
    """The harder, the less area and the larger the separation."""
    found = [bem_solve(HM, body(x), pressure=0.03 * SCALE) for x in (0.04, 0.1, 0.3, 0.6, 2.0)]
    assert (np.diff([s.contact_area_raw for s in found]) <= 0).all()
    assert (np.diff([s.contact_area for s in found]) <= 0).all()
    assert (np.diff([s.separation for s in found]) > 0).all()
    assert (np.diff([s.plastic_share for s in found]) < 0).all()


@pytest.mark.parametrize("x", [0.02, 0.3])
@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_up_to_the_hardness_itself(x, boundary):
    mat = body(x)
    for share in (0.9, 0.99, 1.0):
        found = bem_solve(HM, mat, pressure=share * mat.hardness, boundary=boundary)
        assert found.converged
    assert found.saturated.all() and found.area_fraction == pytest.approx(1.0)
    assert found.plastic_share == pytest.approx(1.0)
    deep = bem_solve(HM, mat, separation=-60 * HM.rms_height, boundary=boundary)
    assert deep.converged and deep.saturated.all()
    assert deep.separation == pytest.approx(-60 * HM.rms_height)
    assert deep.gap.max() <= 1e-60 * HM.rms_height
    for one in (found, deep):
        assert one.mean_pressure <= mat.hardness and one.area_fraction <= 1.0
    with pytest.raises(errors.InputError, match="above the hardness"):
        bem_solve(HM, mat, pressure=1.001 * mat.hardness, boundary=boundary)
    with pytest.raises(errors.InputError, match="above the hardness"):
        bem_curve(HM, mat, pressures=[0.1 * mat.hardness, 1.1 * mat.hardness])


def test_small_and_flat_maps():
    mat = HalfSpace.from_modulus(1.0, hardness=0.1)
    for shape in ((3, 3), (3, 5)):
        flat = HeightMap(np.zeros(shape), (1.0, 1.0), periodic=True)
        for load in (0.05, 0.1):
            found = bem_solve(flat, mat, pressure=load)
            assert found.converged
            np.testing.assert_allclose(found.pressure, load)
    single = HeightMap(np.zeros((3, 3)), (1.0, 1.0), periodic=False)
    found = bem_solve(single, mat, pressure=0.1)
    assert found.saturated.all() and found.converged


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_unloaded_surface_carries_the_load_elastically(boundary):
    mat = body(0.3)
    found = bem_solve(HM, mat, pressure=0.06 * SCALE, boundary=boundary, tolerance=1e-9)
    left = found.unloaded()
    np.testing.assert_array_equal(left.heights, HM.heights - found.plastic_depth)
    again = bem_solve(left, BODY, pressure=0.06 * SCALE, boundary=boundary, tolerance=1e-9)
    np.testing.assert_allclose(again.pressure, found.pressure, atol=1e-5 * mat.hardness)
    assert again.contact_area_raw == pytest.approx(found.contact_area_raw, rel=5e-3)
    shift = found.plastic_depth.mean()
    assert again.separation == pytest.approx(found.separation + shift, abs=1e-8 * HM.rms_height)
    assert again.elastic_energy == pytest.approx(found.elastic_energy, rel=1e-6)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("x", [1e-3, 1e-5, 1e-8])
def test_bearing_curve_in_the_limit_of_a_low_hardness(x, boundary):
    """Points yield, others are hardly displaced: the P/H highest of them carry the load, and the
    flat lies on the next, which bears half of the hardness."""
    hm = rough((60, 70), slope=0.1)
    points, mat = hm.heights.size, HalfSpace.from_modulus(1.0, hardness=x * hm.roughness.rms_slope)
    higher = np.round(np.geomspace(0.01, 0.5, 8) * points)
    loads = mat.hardness * (higher + 0.5) / points
    curve = bem_curve(hm, mat, pressures=loads, accuracy=0.05, boundary=boundary)
    assert curve.converged.all()
    heights = np.sort(hm.about_mean.heights.ravel())[::-1][higher.astype(int)]
    displaced = mat.hardness * max(hm.size) / mat.modulus  # at most, all of the map at the hardness
    assert np.abs(curve.separation - heights).max() < displaced


def test_work_done_is_elastic_and_plastic():
    """The load does work: what is stored, and the hardness times the volume that yielded."""
    mat = body(0.3)
    loads = np.linspace(0.0, 0.06 * SCALE, 61)[1:]
    curve = bem_curve(HM, mat, pressures=loads, tolerance=1e-8)
    last = bem_solve(HM, mat, pressure=float(loads[-1]), tolerance=1e-8)
    highest = HM.heights.max() - HM.heights.mean()
    s = np.append(highest, curve.separation)
    p = np.append(0.0, curve.mean_pressure)
    work = trapezoid(p, -s) * HM.area
    plastic = mat.hardness * last.plastic_depth.sum() * HM.spacing[0] * HM.spacing[1]
    assert plastic > 0.1 * last.elastic_energy
    assert last.elastic_energy + plastic == pytest.approx(work, rel=5e-3)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_curves(boundary):
    """Loads, separations and a loose curve agree within their error bounds."""
    mat = body(0.2)
    loads = np.geomspace(0.002, 0.05, 12) * SCALE
    curve = bem_curve(HM, mat, pressures=loads, boundary=boundary)
    assert curve.converged.all() and curve.settings["hardness"] == mat.hardness
    assert ((curve.extra["plastic_share"] > 0) & (curve.extra["plastic_share"] <= 1)).all()
    assert (np.diff(curve.area_fraction) > 0).all() and (np.diff(curve.separation) < 0).all()
    single = bem_solve(HM, mat, pressure=float(loads[6]), boundary=boundary)
    assert curve.separation[6] == pytest.approx(single.separation, abs=3e-6 * HM.rms_height)
    assert curve.extra["plastic_share"][6] == pytest.approx(single.plastic_share, rel=0.02)
    back = bem_curve(HM, mat, separations=curve.separation, boundary=boundary)
    assert back.converged.all()
    bound = curve.error_estimate + back.error_estimate
    assert (np.abs(back.mean_pressure / loads - 1) <= bound).all()
    rough_curve = bem_curve(HM, mat, pressures=loads, boundary=boundary, accuracy=0.02)
    assert rough_curve.converged.all()
    np.testing.assert_allclose(rough_curve.area_fraction, curve.area_fraction, rtol=0.04)
    assert (rough_curve.area_fraction >= loads / mat.hardness * (1 - 1e-12)).all()
    assert "plastic_share" not in bem_curve(HM, BODY, pressures=loads[:1]).extra


@pytest.mark.parametrize("x", [0.05, 0.5])
def test_bound_of_the_load_error(x):
    """A loose solution at equal separation is off by less than it says."""
    mat = body(x)
    exact = bem_curve(HM, mat, pressures=[0.02 * SCALE], tolerance=1e-9)
    for tolerance in (1e-2, 1e-3):
        loose = bem_curve(HM, mat, separations=exact.separation, tolerance=tolerance)
        error = abs(loose.mean_pressure[0] / exact.mean_pressure[0] - 1)
        assert error <= loose.error_estimate[0]


RINGS = {
    1.0: (1.0, 1.0, 0.0),
    1.5: (1.8153, 1.514, 0.488),
    3.0: (4.6962, 3.293, 0.893),
    7.0: (13.66, 9.13, 0.996),
}
"""Approach over that at yield: force, area and saturated share, from 700 rings."""


@pytest.mark.parametrize("approach", RINGS)
def test_paraboloid_against_rings(approach):
    radius, hardness = 1e-3, 1e-2
    mat = HalfSpace.from_modulus(1.0, hardness=hardness)
    reach = 0.5 * np.pi * radius * hardness
    force = 2 / 3 * np.pi * hardness * reach**2
    load, area, share = RINGS[approach]
    ball = PowerLawProfile(2.0, 0.5 / radius)
    found = indent_bem(ball, mat, approach * reach**2 / radius, grid=128)
    assert found.converged and found.force == pytest.approx(load * force, rel=1e-3)
    assert found.contact_area == pytest.approx(area * np.pi * reach**2, rel=0.01)
    assert found.solutions[0].plastic_share == pytest.approx(share, abs=0.02)
    held = indent_bem(ball, mat, load=load * force, grid=128)
    assert held.approach == pytest.approx(approach * reach**2 / radius, rel=1e-3)


def test_summary_tells_what_yielded():
    found = bem_solve(HM, body(0.2), pressure=0.05 * SCALE)
    assert ("at the hardness" in str(found) and "lift" in str(found)) or found.certificate.lift == 0
    assert "at the hardness" not in str(bem_solve(HM, BODY, pressure=0.05 * SCALE))


def test_a_guess_is_cut_at_the_hardness():
    mat = body(0.2)
    guess = np.full(HM.shape, 5 * mat.hardness)
    base = bem_solve(HM, mat, pressure=0.05 * SCALE, tolerance=1e-8)
    found = bem_solve(HM, mat, pressure=0.05 * SCALE, tolerance=1e-8, guess=guess)
    np.testing.assert_allclose(found.pressure, base.pressure, atol=1e-4 * mat.hardness)
