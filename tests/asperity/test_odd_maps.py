"""Maps at the edge of what separate contacts can describe: right, or refused with the reason."""

from __future__ import annotations

import contextlib

import numpy as np
import pytest

import asperity
import surfaces
from asperity.errors import ModelRangeError
from asperity.halfspace.scene import default_pressures, pressure_scale
from asperity.microcontact.laws import tabulate


def _rough(shape, cutoff, *, hurst=0.8, seed=1, **more):
    size = tuple(float(n) for n in shape)
    return surfaces.self_affine(
        shape, size, hurst=hurst, rms_slope=0.1, rolloff=max(size) / 8, cutoff=cutoff, seed=seed,
        **more,
    )  # fmt: skip


def _curve(hm, m, loads, **options):
    body = asperity.HalfSpace.from_modulus(1.0, m=m)
    return asperity.contact_curve(
        hm, body, pressures=np.asarray(loads) * pressure_scale(hm, body), **options
    )


@pytest.mark.parametrize(
    ("shape", "anisotropy", "angle", "m"),
    [((128, 160), 10.0, 0.0, -0.3), ((128, 160), 10.0, 1.57, 0.0), ((64, 80), 20.0, 0.4, -0.3)],
)
def test_the_flat_never_rises_with_the_load(shape, anisotropy, angle, m):
    """Long footprints overlap far along a strong lay; a rise of the flat is no solution."""
    hm = _rough(shape, 12.0, seed=2, anisotropy=anisotropy, angle=angle)
    curve = _curve(hm, m, np.geomspace(1e-3, 0.3, 11))
    used = curve.converged
    assert used[: used.sum()].all() and curve.area_fraction[used].max() > 0.3 / anisotropy
    assert all(reason for reason, good in zip(curve.reasons, used, strict=True) if not good)
    fall = -np.diff(curve.separation[used])
    assert (fall > -3e-3 * np.ptp(curve.separation[used])).all()


@pytest.mark.parametrize("m", [-0.99, 0.99])
def test_gradings_at_the_edge_of_their_range(m):
    """Basins pressed alone come out as no numbers near m = -1: the expansion stands."""
    hm = surfaces.self_affine((24, 32), (24e-6, 32e-6), hurst=0.8, rms_slope=0.1, seed=1)
    body = asperity.HalfSpace.from_modulus(1e10 * 1e-6**-m, m)
    curve = asperity.contact_curve(hm, body)
    assert curve.converged.all() and (np.diff(curve.area_fraction) > 0).all()


def _grooved(periodic=True):
    """A step, and a groove of five pixels in it."""
    x = np.arange(64)
    line = np.where((x >= 8) & (x < 40), 1e-6, 0.0) - 1e-6 * ((x >= 20) & (x < 25))
    return surfaces.HeightMap(np.tile(line, (48, 1)), (1e-6, 1e-6), periodic=periodic)


@pytest.mark.parametrize("m", [-0.9, -0.95, -0.99])
def test_a_load_on_a_grooved_step_needs_an_area_and_is_that_asked_for(m, recwarn):
    noise = np.random.default_rng(0).normal(size=(48, 64))
    rough = surfaces.self_affine((48, 64), (48e-6, 64e-6), hurst=0.8, rms_slope=0.1, seed=1)
    step = _grooved()
    maps = (step, step.replace(heights=step.heights + 1e-8 * noise), rough)
    body = asperity.HalfSpace.from_modulus(1e10 * 1e-6**-m, m)
    for hm in maps:
        for scales, boundary in (("auto", "periodic"), ("all", "periodic"), ("all", "free")):
            pressures = 5.0 * default_pressures(hm, body)
            curve = asperity.contact_curve(
                hm, body, pressures=pressures, scales=scales, boundary=boundary
            )
            good = curve.converged
            assert all(curve.reasons[i] for i in np.flatnonzero(~good))
            assert (curve.contact_area[good] > 0.0).all()
            np.testing.assert_allclose(curve.mean_pressure[good], pressures[good], rtol=0.025)
    assert all(issubclass(one.category, asperity.ContactWarning) for one in recwarn)


@pytest.mark.parametrize(
    ("shape", "spacing", "height", "m", "law"),
    [
        ((26, 3), (9.139e-9, 1.826e-8), 6.139e-9, -0.9, "paper"),
        ((42, 110), (8.636e-10, 3.501e-10), 5.63e-9, -0.5, "hertz"),
    ],
)
def test_checkerboards_leak_no_warning(shape, spacing, height, m, law, recwarn):
    """Sharp summits beside each other: numbers that are not finite end in a reason."""
    y, x = np.indices(shape)
    hm = surfaces.HeightMap(height * ((x + y) % 2), spacing)
    body = asperity.HalfSpace.from_modulus(1e10, m)
    with contextlib.suppress(ModelRangeError):
        curve = asperity.contact_curve(hm, body, law=law)
        told = zip(curve.reasons, curve.converged, strict=True)
        assert all(reason or good for reason, good in told)
        assert (curve.contact_area[curve.converged] > 0.0).all()
    assert all(issubclass(one.category, asperity.ContactWarning) for one in recwarn)


@pytest.mark.parametrize("m", [-0.998, -0.99995, -0.9999999])
def test_gradings_nearest_to_minus_one_are_refused(m):
    body = asperity.HalfSpace.from_modulus(1e10 * 1e-6**-m, m)
    with pytest.raises(ModelRangeError, match="use boundary elements"):
        asperity.contact_curve(_grooved(), body)
    assert asperity.bem_curve(_grooved(), body, pressures=[1e6], tolerance=1e-3).converged.all()


def test_joined_contacts_without_an_area_keep_the_form_of_their_summit():
    """Near m = -1 a contact pressed alone may have a force and the moments of no area."""
    hm = surfaces.self_affine(
        (64, 96), (1e-3, 1.5e-3), hurst=0.8, rms_slope=0.1, rolloff=3e-4, cutoff=6e-5, seed=1
    )
    curve = asperity.contact_curve(hm, asperity.HalfSpace(200e9 * 2e-5**0.99, 0.3, -0.99))
    assert curve.converged.all() and np.isfinite(curve.error_estimate).all()


def test_a_negative_mean_gap_is_refused():
    x = 2 * np.pi * np.arange(72) / 18
    hm = surfaces.HeightMap(np.tile(np.cos(x), (64, 1)), (1.0, 1.0), periodic=True)
    curve = _curve(hm, 0.0, [1e-3, 1e-2, 0.07, 0.15])
    assert curve.converged[0] and not curve.converged[-1]
    assert (curve.separation[curve.converged] >= 0).all()
    assert any(why in curve.reasons[-1] for why in ("mean gap", "overlap", "crowded"))


def test_no_contact_above_a_map_whose_finest_waves_are_highest():
    hm = surfaces.HeightMap(
        np.random.default_rng(3).normal(size=(96, 120)), (1.0, 1.0), periodic=True
    )
    body = asperity.HalfSpace.from_modulus(1.0)
    top = float(np.ptp(hm.heights))
    curve = asperity.contact_curve(hm, body, separations=[top, 2 * top])
    assert curve.converged.all() and not curve.load.any() and not curve.contact_area.any()


def test_contacts_that_all_open_within_a_step():
    """The kernel of m = -0.8 hardly decays: a step can lift the flat off every contact."""
    hm = surfaces.turned((128, 160), (128.0, 160.0), feed=20.0, nose_radius=100.0, seed=1)
    curve = _curve(hm, -0.8, np.geomspace(1e-5, 0.35, 7))
    assert all(reason or good for reason, good in zip(curve.reasons, curve.converged, strict=True))


def test_no_law_of_a_fading_border_pulls():
    """Hardly curved plateaus where a border fades closed a fiftieth of the map without a force."""
    shape, size, rng = (96, 120), (96.0, 120.0), np.random.default_rng(1)
    noise = rng.normal(size=shape)
    ground = surfaces.ground(shape, size, rms_slope=0.1, cutoff=5.0, seed=1)
    y, x = (np.linspace(-1, 1, n) for n in shape)
    form = -ground.rms_height * (y[:, None] ** 2 + 0.5 * x**2)
    raw = surfaces.HeightMap(ground.heights + form + 0.01 * noise, (1.0, 1.0))
    hm = surfaces.prepare(raw, periodic="taper")
    profiles = surfaces.fit_profiles(hm, surfaces.segment(hm))
    table = tabulate(profiles, asperity.HalfSpace.from_modulus(1.0), law="auto")
    known = profiles.valid & (table.reach > 0)
    assert known.sum() > 100
    assert (table.force[known, 1:] > 0).all()
    assert (np.diff(table.force[known], axis=1) >= 0).all()


@pytest.mark.parametrize(("shape", "angle"), [((64, 80), 0.4), ((128, 160), 1.57)])
def test_ridges_that_overlap_are_solved_or_refused_without_a_warning(shape, angle):
    hm = _rough(shape, 8.0, seed=5, anisotropy=20.0, angle=angle)
    body = asperity.HalfSpace.from_modulus(1.0, m=-0.3)
    places = hm.rms_height * np.array([1.0, 0.4])
    curve = asperity.contact_curve(hm, body, separations=places)
    assert all(reason or good for reason, good in zip(curve.reasons, curve.converged, strict=True))


def test_contacts_that_overlap_end_to_end_are_refused():
    hm = _rough((128, 160), 8.0, seed=5, anisotropy=20.0)
    curve = _curve(hm, 0.0, np.array([2e-3, 0.1]))
    assert curve.converged.tolist() == [True, False]
    assert "end to end" in curve.reasons[1]
    assert not any(_curve(_rough((128, 160), 8.0, seed=5), 0.0, np.array([2e-3, 0.1])).reasons)


@pytest.mark.parametrize("cut", [0.7, 1.5])
@pytest.mark.parametrize("noise", [1e-14, 1e-12, 1e-10])
def test_rounding_noise_on_clipped_heights_changes_nothing(cut, noise):
    """It makes a summit of every point of a plateau."""
    hm = surfaces.self_affine(
        (96, 128), (96.0, 128.0), hurst=0.8, rms_slope=0.1, cutoff=8.0, rolloff=32.0, seed=4
    )
    heights = np.minimum(hm.heights, cut * hm.heights.std())
    rough = noise * heights.std() * np.random.default_rng(0).normal(size=heights.shape)
    body = asperity.HalfSpace.from_modulus(1.0)
    loads = np.geomspace(1e-4, 1e-2, 4)
    exact, noisy = (
        asperity.contact_curve(hm.replace(heights=h), body, pressures=loads)
        for h in (heights, heights + rough)
    )
    np.testing.assert_allclose(noisy.separation, exact.separation, rtol=1e-4)
    np.testing.assert_allclose(noisy.contact_area, exact.contact_area, rtol=1e-3)
    for curve in (exact, noisy):
        assert any("in line" in text for text in curve.settings["warnings"])


def test_slopes_of_order_one_are_warned_of():
    hm = surfaces.self_affine((32, 48), (32.0, 48.0), hurst=0.8, rms_slope=1.0, cutoff=8.0)
    curve = asperity.contact_curve(hm, asperity.HalfSpace.from_modulus(1.0))
    assert any("small slopes" in text for text in curve.settings["warnings"])


def test_a_cliff_at_the_seam_is_warned_of_and_no_error_is_stated():
    whole = surfaces.self_affine((96, 96), (96.0, 96.0), hurst=0.8, rms_slope=0.1, cutoff=8.0)
    part = surfaces.HeightMap(whole.heights[:64, :64], (1.0, 1.0), periodic=True)
    body = asperity.HalfSpace.from_modulus(1.0)
    for hm, told in ((whole, 0), (part, 1), (surfaces.make_periodic(part, "smooth"), 0)):
        curve = asperity.contact_curve(hm, body)
        assert sum("sides of the map" in text for text in curve.settings["warnings"]) == told
        assert np.isnan(curve.error_estimate[curve.converged]).all() == bool(told)


def test_waves_of_two_pixels_are_left_to_boundary_elements():
    """A finer grid has nothing of them; the map was called constant."""
    y, x = np.indices((48, 64))
    hm = surfaces.HeightMap(0.1 * ((x + y) % 2), (1.0, 1.0), periodic=True)
    body = asperity.HalfSpace.from_modulus(1.0)
    loads = np.geomspace(1e-4, 1e-2, 5)
    with pytest.raises(asperity.ModelRangeError, match="waves of two pixels"):
        asperity.contact_curve(hm, body, pressures=loads)
    curve = asperity.solve(hm, body, pressures=loads, engine="anchored")
    assert curve.converged.all() and curve.settings["engine"] == "bem"


def test_a_contact_without_a_stiffness_ends_in_a_reason():
    """All contacts of a step are at the hardness from the first touch on."""
    heights = np.where(np.arange(5) < 3, -5e-10, 5e-10) * np.ones((13, 1))
    hm = surfaces.HeightMap(heights, (2.6e-4, 2.4e-5))
    body = asperity.HalfSpace.from_modulus(1.6e7, hardness=3.4e-3)
    curve = asperity.contact_curve(hm, body, pressures=[1.4e-9, 1.6e-8, 3.4e-3])
    assert all(curve.reasons[i] for i in np.flatnonzero(~curve.converged))
    assert np.isfinite(curve.separation[curve.converged]).all()


@pytest.mark.parametrize("seed", range(4))
def test_separations_that_cross_zero(seed):
    """A step that does not settle took the root of a separation below zero."""
    hm = surfaces.self_affine(
        (32, 128), (3.2e-4, 1.28e-3), hurst=0.8, rms_slope=0.1, cutoff=8e-5, seed=seed
    )
    heights = np.array(hm.heights)
    heights[10] = heights.mean()
    hm = surfaces.HeightMap(heights, hm.spacing)
    separations = heights.std() * np.array([1.0, 0.5, 0.0, -0.3, -1.0, -2.0])
    body = asperity.HalfSpace.from_modulus(1e11)
    curve = asperity.contact_curve(hm, body, separations=separations)
    assert curve.converged[:3].all() and (np.diff(curve.mean_pressure[curve.converged]) > 0).all()
