"""Fine waves as a law of contacts: closed forms, what they rest on, and boundary elements."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scales_support import FINE, STEEL, broad
from scipy.integrate import quad
from scipy.special import erf, exp1

import asperity
import surfaces
from asperity.asperities import Asperities
from asperity.bem.kernel import compliance
from asperity.cli.main import main
from asperity.curve import solve_contacts
from asperity.errors import InputError
from asperity.loadpoints import pressure_scale
from asperity.plan import make_plan
from asperity.scales.split import split_scales
from surfaces import HeightMap


@pytest.fixture(scope="module")
def rough() -> HeightMap:
    return broad()


@pytest.fixture(scope="module")
def loads(rough) -> np.ndarray:
    return np.array([3e-3, 1e-2, 3e-2, 6e-2]) * pressure_scale(rough, STEEL)


@pytest.mark.parametrize("pressure", [2e7, 3e8, 2e9, 3e10])
@pytest.mark.parametrize("share", [0.0, 0.4])
def test_closed_forms_are_means_over_rayleighs_distribution(pressure, share):
    scale = np.sqrt(2 / np.pi) * pressure
    spread = (FINE.spread + (1 - FINE.spread) * share**2) * FINE.variance

    def mean(law):
        def weighed(t):
            return t * np.exp(-0.5 * t * t) * law(t * scale / np.sqrt(2 * spread))

        return quad(weighed, 0, 1, epsrel=1e-9)[0] + quad(weighed, 1, 12, epsrel=1e-9)[0]

    def energy(x):
        return erf(x) + (x * exp1(x * x) / np.sqrt(np.pi) if 0 < x < 20 else 0.0)

    assert FINE.remaining(pressure, share) == pytest.approx(mean(erf), rel=1e-6)
    assert FINE.stored(pressure, share) == pytest.approx(FINE.energy * mean(energy), rel=1e-6)


def test_pressed_hard_all_is_closed_and_all_energy_stored():
    assert FINE.remaining(1e14, 0.1) == pytest.approx(1.0, abs=1e-8)
    assert FINE.stored(1e14, 0.1) == pytest.approx(FINE.energy, rel=1e-6)
    assert FINE.lift(1.0) == 1.0


@settings(deadline=None, derandomize=True, max_examples=20)
@given(st.floats(1e6, 1e11), st.floats(0.0, 0.9), st.floats(1e-18, 1e-6))
def test_a_contact_smaller_than_the_fine_waves_stays_whole(pressure, share, area):
    areas = np.array([1e-22, area, 2.0 * area, np.inf])
    kept = FINE.remaining(pressure, share, areas)
    assert np.all(np.diff(kept) <= 0)
    assert kept[0] == pytest.approx(1.0, abs=1e-2)
    assert kept[-1] == FINE.remaining(pressure, share)
    # half the pressure of the fine waves where a wave number times the radius is 1, with lay 1 / w
    for evenness in (1.0, 0.5):
        law = dataclasses.replace(FINE, evenness=evenness)
        halved = dataclasses.replace(law, variance=0.5 * FINE.variance)
        assert law.remaining(
            pressure, share, np.pi / (evenness * FINE.number) ** 2
        ) == pytest.approx(halved.remaining(pressure, share))


@settings(deadline=None, derandomize=True, max_examples=20)
@given(st.floats(1e6, 1e11), st.floats(0.0, 0.9))
def test_more_pressure_closes_more_and_stores_more(pressure, share):
    pair = np.array([pressure, 1.1 * pressure])
    closed, stored = FINE.remaining(pair, share), FINE.stored(pair, share)
    assert 0 < closed[0] < closed[1] <= 1
    assert 0 < stored[0] < stored[1] <= FINE.energy
    assert FINE.remaining(pressure, share) >= FINE.remaining(pressure, min(share + 0.1, 1.0))


def test_the_map_is_the_band_of_longer_waves(rough):
    split = split_scales(rough, STEEL)
    coarse, fine = split.coarse, split.fine
    shell = 1 / max(rough.size)
    edge = 1 / (1 / fine.shortest + 0.5 * shell)
    band = surfaces.resample(surfaces.bandpass(rough, shortest=edge), coarse.spacing)
    assert band.shape == coarse.shape
    assert fine.shortest >= 6 * max(coarse.spacing) > 0.9 * fine.shortest
    np.testing.assert_allclose(coarse.heights, band.heights, atol=1e-9 * rough.rms_height)


def sums(hm: HeightMap, body) -> tuple[float, float, np.ndarray]:
    """Variance of the pressure and energy per area of a map pressed flat, and its slope tensor."""
    waves = np.abs(np.fft.fft2(hm.heights) / hm.heights.size) ** 2
    qy, qx = np.meshgrid(
        *(2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(hm.shape, hm.spacing, strict=True)),
        indexing="ij",
    )
    stiffness = np.hypot(qy, qx) ** (1 - body.m) / compliance((1.0, 1.0), body)
    tensor = np.array([[(waves * a * b).sum() for a in (qy, qx)] for b in (qy, qx)])
    return (waves * stiffness**2).sum(), 0.5 * (waves * stiffness).sum(), tensor


@pytest.mark.parametrize("more", [{}, {"anisotropy": 3.0, "angle": 0.5}])
@pytest.mark.parametrize("m", [0.0, 0.3, -0.3])
def test_pressure_and_energy_are_those_of_the_waves_left_out(m, more):
    hm, body = broad(**more), asperity.HalfSpace.from_modulus(2e11, m=m)
    split = split_scales(hm, body)
    coarse, fine = split.coarse, split.fine
    (whole, stored, slopes), (longer, held, gentle) = (sums(map_, body) for map_ in (hm, coarse))
    assert fine.variance == pytest.approx(whole - longer, rel=1e-6)
    assert fine.energy == pytest.approx(stored - held, rel=1e-6)
    assert fine.ratio == pytest.approx(whole / longer - 1, rel=1e-6)
    low, high = np.linalg.eigvalsh(slopes - gentle)
    assert fine.evenness == pytest.approx(2 * np.sqrt(low * high) / (low + high), rel=1e-6)


@pytest.mark.parametrize("more", [{}, {"anisotropy": 3.0, "angle": 0.5}])
def test_a_finer_split_is_one_of_the_same_waves(more):
    """It has only the longer of them at hand, and the sums of all."""
    hm = broad((400, 480), **more)
    split = split_scales(hm, STEEL)
    finer = split.finer(STEEL)
    assert finer.shells.waves.size < 0.6 * hm.heights.size / 2
    assert finer.fine.shortest < 0.75 * split.fine.shortest
    (whole, stored, _), (longer, held, _) = (sums(map_, STEEL) for map_ in (hm, finer.coarse))
    assert finer.fine.variance == pytest.approx(whole - longer, rel=1e-6)
    assert finer.fine.energy == pytest.approx(stored - held, rel=1e-6)
    assert finer.finer(STEEL) is finer


def test_a_free_map_is_taken_with_its_mirror_images(rough):
    free = dataclasses.replace(rough, periodic=False)
    split = split_scales(free, STEEL)
    coarse, fine = split.coarse, split.fine
    mirrored, smooth = (
        surfaces.prepare(hm, level=None, periodic="mirror") for hm in (free, coarse)
    )
    (whole, stored, _), (longer, held, _) = (sums(hm, STEEL) for hm in (mirrored, smooth))
    assert fine.variance == pytest.approx(whole - longer, rel=1e-6)
    assert fine.energy == pytest.approx(stored - held, rel=1e-6)
    edge = (1 + 1e-9) / (1 / fine.shortest + 0.5 / max(rough.size))
    band = surfaces.resample(surfaces.bandpass(mirrored, shortest=edge), smooth.spacing)
    ny, nx = coarse.shape
    np.testing.assert_allclose(coarse.heights, band.heights[:ny, :nx], atol=1e-9 * rough.rms_height)
    periodic = split_scales(rough, STEEL)
    assert fine.variance == pytest.approx(periodic.fine.variance, rel=0.1)


@pytest.mark.parametrize("border", ["free", "fading"])
def test_maps_of_other_borders_agree_with_boundary_elements(loads, border):
    hm = dataclasses.replace(broad((160, 200)), periodic=False)
    if border == "fading":
        hm = surfaces.prepare(hm, periodic="taper")
    refined = surfaces.resample(hm, np.asarray(hm.spacing) / 2)
    exact = asperity.bem_curve(refined, STEEL, pressures=loads, tolerance=1e-4)
    curve = asperity.contact_curve(hm, STEEL, separations=exact.separation)
    assert curve.settings["shortest_wave"] is not None
    assert np.abs(curve.mean_pressure / loads - 1).max() < 0.03
    assert np.abs(curve.contact_area / exact.contact_area - 1).max() < 0.06


def test_worn_plateaus_agree_with_boundary_elements():
    """Their fine waves are weak where contacts are."""
    recipe = {"shape": (400, 400), "size": (400.0, 400.0), "rms_slope": 0.1, "seed": 2}
    hm = surfaces.plateau_honed(**recipe, cutoff=2.0, rolloff=100.0)
    found = split_scales(hm, STEEL).fine.strength
    assert found.at(np.zeros(1), np.zeros(1), hm.rms_height) < 0.5
    pressures = np.array([1e-2, 3e-2]) * pressure_scale(hm, STEEL)
    exact = asperity.bem_curve(hm, STEEL, pressures=pressures, tolerance=1e-3)
    curve = asperity.contact_curve(hm, STEEL, separations=exact.separation)
    assert np.abs(curve.mean_pressure / pressures - 1).max() < 0.03
    assert np.abs(curve.contact_area / exact.contact_area - 1).max() < 0.06
    less = surfaces.plateau_honed(**recipe, cutoff=2.0)
    assert "narrow" in split_scales(less, STEEL)


def test_the_law_of_stronger_waves_is_that_of_more_variance_and_energy():
    more = dataclasses.replace(FINE, variance=4 * FINE.variance, energy=4 * FINE.energy)
    at = np.array([3e8, 2e9]), 0.1
    np.testing.assert_allclose(FINE.remaining(*at, strong=4.0), more.remaining(*at), rtol=1e-12)
    np.testing.assert_allclose(FINE.stored(*at, strong=4.0), more.stored(*at), rtol=1e-12)


def test_the_law_does_not_jump_at_a_homogeneous_body_nor_at_no_lay(rough):
    plain = split_scales(rough, STEEL).fine
    near = split_scales(rough, asperity.HalfSpace.from_modulus(2e11, m=1e-7)).fine
    for name in ("shortest", "spread", "energy", "variance", "ratio"):
        assert getattr(near, name) == pytest.approx(getattr(plain, name), rel=1e-5)
    assert near.lift(0.1) == pytest.approx(plain.lift(0.1), rel=1e-6)
    assert plain.evenness == pytest.approx(1.0, abs=5e-3)
    even, nearly = (dataclasses.replace(plain, evenness=w) for w in (1.0, 1.0 - 1e-7))
    assert nearly.spread == pytest.approx(even.spread, rel=1e-6)


@settings(deadline=None, derandomize=True, max_examples=20)
@given(st.floats(-0.5, 0.5), st.floats(0.3, 1.0), st.floats(0.1, 50.0))
def test_part_of_the_pressure_spreads(m, evenness, ratio):
    law = dataclasses.replace(FINE, m=m, evenness=evenness, ratio=ratio)
    assert 0 < law.spread < 1 <= law.lift(0.1)
    assert law.spread <= dataclasses.replace(law, evenness=1.0).spread
    assert law.spread <= dataclasses.replace(law, m=m - 0.01).spread


def test_vanishing_fine_waves_leave_the_contacts_as_they_are():
    law = dataclasses.replace(FINE, variance=1e-12 * FINE.variance, energy=1e-6 * FINE.energy)
    assert law.remaining(3e8, 0.1) == pytest.approx(1.0, abs=1e-9)
    assert law.stored(3e8, 0.1) == pytest.approx(law.energy, rel=1e-6)


def test_with_lay_waves_are_told_apart_along_and_across(rough):
    """Of a map squeezed in one direction the shortest that is kept is squeezed half as far."""
    law = split_scales(rough, STEEL).fine
    for factors in ((1.0, 3.0), (3.0, 1.0)):
        spacing = tuple(d * f for d, f in zip(rough.spacing, factors, strict=True))
        split = split_scales(HeightMap(rough.heights, spacing, periodic=True), STEEL)
        coarse, fine = split.coarse, split.fine
        waves = np.abs(np.fft.fft2(coarse.heights))
        kept = waves > 1e-9 * waves.max()
        reach = [
            np.abs(np.fft.fftfreq(n, d))[kept.any(axis=1 - axis)].max()
            for axis, (n, d) in enumerate(zip(coarse.shape, coarse.spacing, strict=True))
        ]
        assert reach[0] / reach[1] == pytest.approx(np.sqrt(factors[1] / factors[0]), rel=0.05)
        assert fine.shortest == pytest.approx(1 / np.sqrt(np.prod(reach)), rel=0.05)
        assert law.shortest < fine.shortest < np.sqrt(3.0) * law.shortest
        assert 0.45 < fine.evenness < 0.6  # those left out have more of the lay than all, 0.6


def test_maps_that_keep_all_their_summits(monkeypatch):
    def why(hm, body=STEEL):
        found = split_scales(hm, body)
        assert isinstance(found, str)
        return found

    rough = broad()
    assert "|m| <= 0.5" in why(rough, asperity.HalfSpace.from_modulus(2e11, m=0.6))
    assert "direction" in why(broad(anisotropy=12.0))
    assert "direction" in why(broad(anisotropy=8.0, hurst=0.3, cutoff=4.4e-6))
    assert "narrow" in why(broad(anisotropy=5.0))
    with monkeypatch.context() as less:
        less.setattr("asperity.scales.split.SURELY_WORTH_IT", 0.5)
        assert not isinstance(split_scales(broad(anisotropy=5.0), STEEL), str)
        assert "direction" in why(broad(anisotropy=5.0, angle=0.5))
    for angle in (0.0, 0.8):
        lay = dataclasses.replace(broad(anisotropy=3.0, angle=angle), periodic=False)
        assert "for periodic maps only" in why(lay)
    assert "narrow" in why(broad(cutoff=1.2e-5))
    spikes = rough.heights.copy()
    spikes[::40, ::40] += 4 * rough.rms_height
    assert "not random" in why(rough.replace(heights=spikes))
    assert make_plan(rough, STEEL, scales="all").fine is None
    assert make_plan(rough, STEEL, interaction=False).fine is None
    with pytest.raises(InputError, match="choose one of auto, all"):
        make_plan(rough, STEEL, scales="coarse")


def test_the_plan_says_so(rough):
    plan = make_plan(rough, STEEL)
    assert plan.fine is not None
    assert "act as a law of the contacts" in str(plan)
    assert "points hold the longer waves of 240 x 288" in str(plan)


def test_both_controls_agree(rough, loads):
    plan = make_plan(rough, STEEL, pressures=loads)
    by_load = asperity.contact_curve(rough, STEEL, pressures=loads, plan=plan)
    by_gap = asperity.contact_curve(rough, STEEL, separations=by_load.separation, plan=plan)
    assert by_load.converged.all() and by_gap.converged.all()
    np.testing.assert_allclose(by_gap.mean_pressure, loads, rtol=1e-2)
    np.testing.assert_allclose(by_gap.contact_area, by_load.contact_area, rtol=1e-2)


def test_the_lift_is_the_slope_of_the_energy(rough, loads):
    """It is factor * d(sum Phi)/dF, and the stiffness is a slope."""
    near = loads[2] * np.array([0.97, 1.0, 1.03])
    plan = make_plan(rough, STEEL, pressures=near)
    bodies = Asperities.of(rough, STEEL, plan)
    states = [bodies.population.solve(mean_pressure=p, tolerance=1e-4) for p in near]
    points = [bodies.point(state) for state in states]
    fine = plan.fine
    state = states[1]
    share = state.contact_area / rough.area
    closed = state.force > 0
    kept = fine.remaining(state.force[closed] / state.area[closed], share, state.area[closed])
    share = 0.5 * (share + float(state.area[closed] @ kept) / rough.area)

    def energy(state):
        closed = state.force > 0
        pressure = state.force[closed] / state.area[closed]
        return float(state.area[closed] @ fine.stored(pressure, share))

    rise = energy(states[2]) - energy(states[0])
    lift = rise / (states[2].force.sum() - states[0].force.sum()) * fine.lift(share)
    assert points[1].separation - state.separation == pytest.approx(lift, rel=0.03)

    def slope(those):
        return (near[2] - near[0]) / (those[0].separation - those[2].separation)

    # the tangent of the contacts leaves out how they move aside: both stiffnesses miss that alike
    missed = slope(states) / state.normal_stiffness
    assert points[1].stiffness == pytest.approx(slope(points) / missed, rel=0.02)
    # what the lift adds to the compliance, to first order in the fine waves
    lifts = [point.separation - one.separation for point, one in zip(points, states, strict=True)]
    added = 1 / points[1].stiffness - 1 / state.normal_stiffness
    assert added == pytest.approx((lifts[0] - lifts[2]) / (near[2] - near[0]), rel=0.6)


def test_the_flat_stands_no_higher_than_the_highest_point(rough):
    curve = asperity.contact_curve(rough, STEEL, pressures=[0.0, 1e-9 * STEEL.modulus])
    top = float(rough.heights.max() - rough.heights.mean())
    assert curve.separation[0] == pytest.approx(top)
    assert curve.contact_area[0] == 0.0 and curve.separation[1] <= top
    above = asperity.contact_curve(rough, STEEL, separations=[1.2 * top, 1.01 * top])
    np.testing.assert_array_equal(above.mean_pressure, 0.0)


def test_lengths_and_modulus_only_scale(rough, loads):
    small = HeightMap(1e3 * rough.heights, tuple(1e3 * d for d in rough.spacing), periodic=True)
    body = asperity.HalfSpace.from_modulus(10 * STEEL.modulus)
    one = asperity.contact_curve(rough, STEEL, pressures=loads[:2])
    other = asperity.contact_curve(small, body, pressures=10 * loads[:2])
    np.testing.assert_allclose(other.area_fraction, one.area_fraction, rtol=1e-3)
    np.testing.assert_allclose(1e-3 * other.separation, one.separation, rtol=1e-3)
    stiffness = 100 * other.stiffness
    np.testing.assert_allclose(stiffness, one.stiffness, rtol=5e-3)


@pytest.mark.parametrize(
    ("m", "more"), [(0.0, {}), (0.3, {}), (-0.3, {}), (0.0, {"anisotropy": 2.5, "angle": 0.7})]
)
def test_nearer_to_boundary_elements_than_with_all_summits(m, more):
    hm, body = broad(**more), asperity.HalfSpace.from_modulus(2e11, m=m)
    loads = np.array([1e-2, 3e-2, 6e-2]) * pressure_scale(hm, body)
    refined = surfaces.resample(hm, np.asarray(hm.spacing) / 2)
    exact = asperity.bem_curve(refined, body, pressures=loads, tolerance=1e-4)
    auto, every = (
        asperity.contact_curve(hm, body, pressures=loads, scales=scales)
        for scales in ("auto", "all")
    )
    assert auto.settings["shortest_wave"] is not None

    def worst(found):
        return np.abs(found.separation - exact.separation).max() / hm.rms_height

    assert worst(auto) < min(0.03, 0.9 * worst(every))
    error = np.abs(auto.contact_area / exact.contact_area - 1)
    assert error.max() < 0.06


def test_states_are_of_the_longer_waves(rough, loads):
    plan = make_plan(rough, STEEL, pressures=loads)
    run = solve_contacts(rough, STEEL, plan, pressures=loads)
    for point, area in enumerate(run.curve.contact_area):
        table = run.microcontacts(point)
        assert table["closed_area"].sum() == pytest.approx(area, rel=1e-9)
        assert (table["closed_area"] < table["area"]).all()
        assert table["area"].sum() == pytest.approx(run.states[point].contact_area, rel=1e-9)
        force = run.curve.mean_pressure[point] * rough.area
        assert table["force"].sum() == pytest.approx(force, rel=1e-9)


def test_from_the_command_line(rough, tmp_path, capsys):
    file, results = tmp_path / "rough.h5", tmp_path / "results.h5"
    surfaces.write(rough, file)
    body = ["--modulus", "2e11", "--pressure", "1e8,4e8"]
    assert main(["plan", str(file), *body]) == 0
    assert "act as a law of the contacts" in capsys.readouterr().out
    for scales, waves in (("auto", True), ("all", False)):
        asked = ["--scales", scales, "--results", str(results)]
        assert main(["curve", str(file), *body, *asked]) == 0
        curve = asperity.ContactCurve.from_hdf5(results, "asperity")
        assert (curve.settings["shortest_wave"] is not None) == waves


def test_no_wave_shorter_than_three_pixels_is_kept():
    """A spectrum that is not broad is cut there if it holds much beyond, else not at all."""
    for hurst in (0.6, 0.7):
        hm = broad(rolloff=2.9e-5, hurst=hurst, cutoff=2.2e-6)
        kept = split_scales(hm, STEEL).fine.shortest / max(hm.spacing)
        assert 3.0 <= kept < 3.1
    for hurst, cutoff, rolloff in ((0.8, 2.2e-6, 2.9e-5), (0.9, 2.2e-6, 2.9e-5), (0.8, 3e-6, 6e-5)):
        found = split_scales(broad(rolloff=rolloff, hurst=hurst, cutoff=cutoff), STEEL)
        assert isinstance(found, str) and "narrow" in found


@pytest.mark.parametrize("hurst", [0.5, 0.8, 1.0])
def test_without_a_rolloff_enough_waves_are_kept(hurst):
    """The longest waves make a spectrum as broad as one likes, and all others would be short."""
    hm = broad(hurst=hurst, rolloff=None)
    side = np.sqrt(hm.area)
    assert side / split_scales(hm, STEEL).fine.shortest == pytest.approx(50, rel=0.02)
    assert "too few waves" in split_scales(broad(hurst=hurst, rolloff=None, cutoff=5e-6), STEEL)


def test_without_a_rolloff_the_area_of_crowded_hills_is_nearer():
    hm = broad(rolloff=None, seed=12)
    loads = np.array([2.5e-2, 6e-2]) * pressure_scale(hm, STEEL)
    exact = asperity.bem_curve(hm, STEEL, pressures=loads, tolerance=1e-3)
    auto, every = (
        asperity.contact_curve(hm, STEEL, pressures=loads, scales=scales).contact_area
        / exact.contact_area
        - 1
        for scales in ("auto", "all")
    )
    assert (np.abs(auto) < 0.05).all() and (np.abs(auto) < 0.5 * np.abs(every)).all()
