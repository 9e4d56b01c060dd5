"""The contact solution: closed forms, certificates, limits, refusals."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import periodic_displacement, polonsky_keer
from scipy.integrate import trapezoid
from strategies import rough

from asperity import HalfSpace, bem_curve, bem_solve, errors
from surfaces import HeightMap

BODY = HalfSpace.from_modulus(1.0)


def certificate_by_hand(solution, hm, m=0.0, modulus=1.0):
    """Certificate of a periodic pressure, with nothing of the solver's code."""
    p, h = solution.pressure, hm.heights
    gap = periodic_displacement(p, hm.spacing, modulus, m) - h
    work = (p * (gap - gap.min())).sum() / p.sum() / h.std()
    return max(work, (gap[p > 0].mean() - gap.min()) / h.std())


@pytest.mark.parametrize("axis", [0, 1])
def test_westergaard_wave(axis):
    """Strip contact of a wave: width and pressure converge to the closed form."""
    errors_found = []
    for n in (64, 256):
        shape, spacing = ((n, 6), (1.0 / n, 0.1)) if axis == 0 else ((6, n), (0.1, 1.0 / n))
        place = (np.arange(n) + 0.5) / n
        wave = 0.01 * np.cos(2 * np.pi * place)
        heights = np.broadcast_to(np.expand_dims(wave, 1 - axis), shape)
        hm = HeightMap(heights, spacing, periodic=True)
        full = np.pi * 0.01
        mean = 0.3 * full
        solution = bem_solve(hm, BODY, pressure=mean, tolerance=1e-9)
        s = np.sin(np.pi * np.minimum(place, 1 - place))
        exact = (
            2
            * mean
            * np.cos(np.pi * np.minimum(place, 1 - place))
            / 0.3
            * np.sqrt(np.maximum(0.3 - s**2, 0.0))
        )
        found = solution.pressure.mean(axis=1 - axis)
        errors_found.append(np.abs(found - exact).sum() / exact.sum())
        assert solution.converged
    assert errors_found[1] < 0.008
    assert errors_found[1] < 0.3 * errors_found[0]


@pytest.mark.parametrize("m", [-0.4, 0.0, 0.5, 0.8])
@pytest.mark.parametrize("shape", [(60, 84), (45, 63)])
def test_agrees_with_the_textbook_solver(m, shape):
    """The pressure is that of Polonsky and Keer's iteration, for every grading and odd grids."""
    hm = rough(shape)
    mean = 0.05 * 1.0
    body = HalfSpace.from_modulus(3.0, m)
    solution = bem_solve(hm, body, pressure=mean, tolerance=1e-9)
    assert solution.converged
    assert solution.mean_pressure == pytest.approx(mean, rel=1e-12)
    assert certificate_by_hand(solution, hm, m, 3.0) < 1.1e-9
    expected = polonsky_keer(hm.heights, hm.spacing, mean, modulus=3.0, m=m, tolerance=1e-9)
    assert np.abs(solution.pressure - expected).max() < 2e-4 * expected.max()


@pytest.mark.parametrize("mean", [1e-4, 0.02, 0.3, 1.0])
def test_gap_and_separation(mean):
    """The gap is zero in the contact and positive outside; separation is its mean."""
    hm = rough(seed=3)
    solution = bem_solve(hm, BODY, pressure=mean, tolerance=1e-7)
    assert solution.converged
    contact = solution.contact
    scale = hm.rms_height
    assert np.abs(solution.gap[contact].mean()) < 1e-12 * scale
    assert solution.gap.min() > -1e-6 * scale
    assert solution.separation == pytest.approx(solution.mean_gap, abs=1e-9 * scale)
    assert 0 < solution.area_fraction <= solution.contact_area_raw / hm.area


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("mean", [3e-3, 0.1])
def test_separation_is_the_inverse_of_pressure(boundary, mean):
    """Solving at the separation found returns the pressure."""
    hm = rough((40, 52), slope=0.5, seed=4)
    loaded = bem_solve(hm, BODY, pressure=mean, boundary=boundary, tolerance=1e-8)
    back = bem_solve(hm, BODY, separation=loaded.separation, boundary=boundary, tolerance=1e-8)
    assert back.converged
    assert back.mean_pressure == pytest.approx(mean, rel=1e-4)
    assert np.abs(back.pressure - loaded.pressure).max() < 1e-3 * loaded.pressure.max()


def test_full_contact():
    """Beyond closure the pressure is the inverse symbol of the heights, for any grading."""
    hm = rough((40, 52), seed=5)
    for m in (-0.3, 0.0, 0.6):
        body = HalfSpace.from_modulus(2.0, m)
        solution = bem_solve(hm, body, pressure=50.0, tolerance=1e-9)
        assert solution.converged
        assert solution.contact_area == pytest.approx(hm.area, rel=1e-12)
        assert solution.contacts == 1
        assert abs(solution.separation) < 1e-8 * hm.rms_height
        displaced = periodic_displacement(solution.pressure, hm.spacing, 2.0, m)
        relative = displaced - hm.heights + hm.heights.mean()
        assert np.abs(relative).max() < 1e-7 * hm.rms_height


def test_zero_load():
    """No load: no pressure, and the flat touches the highest point."""
    hm = rough(seed=6)
    solution = bem_solve(hm, BODY, pressure=0.0)
    assert solution.converged
    assert not solution.pressure.any()
    assert solution.contacts == 0 and solution.contact_area == 0.0
    assert solution.separation == pytest.approx(hm.heights.max() - hm.heights.mean(), rel=1e-12)
    assert solution.gap.min() == pytest.approx(0.0, abs=1e-15)
    apart = bem_solve(hm, BODY, separation=2 * solution.separation)
    assert apart.separation == pytest.approx(2 * solution.separation, rel=1e-12)
    assert apart.converged and apart.load == 0.0
    assert apart.gap.min() == pytest.approx(solution.separation, rel=1e-12)


@pytest.mark.parametrize(
    ("shape", "load", "tolerance"),
    [((24, 36), 3.0, 1e-8), ((33, 47), 3.0, 1e-8), ((33, 47), 3e-9, 1e-6), ((128, 96), 3e-9, 1e-6)],
)
@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_flat_map(boundary, shape, load, tolerance):
    """A flat map: uniform pressure in a periodic cell, a punch in free space."""
    hm = HeightMap(np.full(shape, 2.5e-6), (1e-3, 2e-3))
    solution = bem_solve(hm, BODY, pressure=load, boundary=boundary, tolerance=tolerance)
    assert solution.converged
    assert solution.area_fraction == pytest.approx(1.0, rel=0.05)
    if boundary == "periodic":
        np.testing.assert_allclose(solution.pressure, load, rtol=1e-12)
        assert solution.separation == pytest.approx(0.0, abs=1e-12)
    else:
        assert solution.pressure[0, 0] > 2 * solution.pressure[12, 18] > 0
        again = bem_solve(hm, BODY, separation=solution.separation, boundary=boundary)
        assert again.converged and again.load == pytest.approx(solution.load, rel=1e-5)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_single_pixel_contact(boundary):
    """A needle carries the whole load on its pixel, with the influence of one cell."""
    heights = np.zeros((20, 26))
    heights[7, 0] = 10.0
    hm = HeightMap(heights, (0.1, 0.2))
    solution = bem_solve(hm, BODY, pressure=1e-3, boundary=boundary)
    assert solution.converged
    assert np.flatnonzero(solution.pressure).tolist() == [7 * 26]
    assert solution.pressure[7, 0] == pytest.approx(1e-3 * heights.size, rel=1e-12)
    assert solution.contacts == 1
    back = bem_solve(hm, BODY, separation=solution.separation, boundary=boundary)
    assert back.load == pytest.approx(solution.load, rel=1e-4)


def test_contact_across_the_seam():
    """A periodic shift of the map shifts the solution, and patches join across the seam."""
    ny, nx = 40, 60
    y, x = np.meshgrid((np.arange(ny) + 0.5) / ny, (np.arange(nx) + 0.5) / nx, indexing="ij")
    cap = -((x - 0.5) ** 2 + (y - 0.5) ** 2)
    hm = HeightMap(cap, (1 / ny, 1 / nx), periodic=True)
    moved = HeightMap(np.roll(cap, (20, 30), (0, 1)), (1 / ny, 1 / nx), periodic=True)
    a = bem_solve(hm, BODY, pressure=0.02, tolerance=1e-9)
    b = bem_solve(moved, BODY, pressure=0.02, tolerance=1e-9)
    assert a.contacts == b.contacts == 1
    assert b.contact_area == a.contact_area
    np.testing.assert_allclose(
        np.roll(b.pressure, (20, 30), (0, 1)), a.pressure, atol=1e-5 * a.pressure.max()
    )


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_an_offset_takes_no_digits(boundary):
    """1 nm of roughness on 1000 km: what its rounding leaves of it is solved and warned of."""
    base = rough((60, 84), size=(1e-7, 1.4e-7), slope=0.1)
    far = base.replace(heights=base.heights + 1e6)
    near = base.replace(heights=far.heights - 1e6)  # exact
    solved, known = (bem_solve(hm, BODY, pressure=2e-3, boundary=boundary) for hm in (far, near))
    assert solved.converged and solved.area_fraction < 0.1
    np.testing.assert_allclose(solved.area_fraction, known.area_fraction, rtol=1e-9)
    np.testing.assert_allclose(solved.separation, known.separation, rtol=1e-6)
    if boundary == "periodic":
        assert certificate_by_hand(solved, near) < 2e-6
    (warning,) = [text for text in solved.settings["warnings"] if "rounded" in text]
    assert "rounded to 1.2e-10 m" in warning and warning in str(solved)
    assert not any("rounded" in text for text in known.settings["warnings"])


def test_scaling_of_lengths_and_modulus():
    """Heights and spacing times s, modulus times c: pressure times c s^-m, in any units."""
    hm = rough((40, 52), slope=0.3, seed=8)
    for m in (-0.3, 0.4):
        one = bem_solve(hm, HalfSpace.from_modulus(1.0, m), pressure=0.01, tolerance=1e-9)
        s, c = 1e-7, 7e10
        small = HeightMap(hm.heights * s, tuple(s * d for d in hm.spacing), periodic=True)
        body = HalfSpace.from_modulus(c, m)
        two = bem_solve(small, body, pressure=0.01 * c * s**m, tolerance=1e-9)
        np.testing.assert_allclose(
            two.pressure / (c * s**m), one.pressure, atol=1e-5 * one.pressure.max()
        )
        assert two.separation == pytest.approx(one.separation * s, rel=1e-7)


def test_warm_start_and_guess():
    """A guess changes the cost, not the answer; a wrong one is refused."""
    hm = rough(seed=9)
    cold = bem_solve(hm, BODY, pressure=0.05, tolerance=1e-8)
    warm = bem_solve(hm, BODY, pressure=0.05, tolerance=1e-8, guess=cold)
    assert warm.fft_pairs == 1
    np.testing.assert_array_equal(warm.pressure > 0, cold.pressure > 0)
    near = bem_solve(hm, BODY, pressure=0.06, tolerance=1e-8, guess=cold.pressure)
    far = bem_solve(hm, BODY, pressure=0.06, tolerance=1e-8)
    np.testing.assert_allclose(near.pressure, far.pressure, atol=1e-4 * far.pressure.max())
    with pytest.raises(errors.InputError, match="guess has shape"):
        bem_solve(hm, BODY, pressure=0.06, guess=np.zeros((3, 3)))
    for scale in (1e25, 1e300):  # a pressure of this size hides the map in single precision
        load = {"separation": cold.separation, "boundary": "periodic"}
        again = bem_solve(hm, BODY, **load, guess=scale * cold.pressure)
        assert again.converged and again.load == pytest.approx(cold.load, rel=1e-4)


def test_monotony():
    """More load: more area, less separation, more energy."""
    hm = rough(seed=10)
    found = [bem_solve(hm, BODY, pressure=p) for p in (0.003, 0.01, 0.03, 0.1, 0.3)]
    assert all(np.diff([s.contact_area for s in found]) > 0)
    assert all(np.diff([s.separation for s in found]) < 0)
    assert all(np.diff([s.elastic_energy for s in found]) > 0)


def test_energy_is_the_work_of_the_load():
    """Elastic energy differs between two loads by the integral of load over separation."""
    hm = rough(seed=11)
    loads = np.linspace(0.04, 0.05, 9)
    found = [bem_solve(hm, BODY, pressure=p, tolerance=1e-9) for p in loads]
    separation = np.array([s.separation for s in found])
    work = -trapezoid(loads, separation) * hm.area
    assert found[-1].elastic_energy - found[0].elastic_energy == pytest.approx(work, rel=1e-4)


def test_stagnation_is_not_convergence(monkeypatch):
    """A solve that cannot reach its tolerance says so."""
    from asperity.bem import projected_gradients

    monkeypatch.setattr(projected_gradients, "_MAX_ITERATIONS", 1)
    solution = bem_solve(rough(seed=12), BODY, pressure=0.02, tolerance=1e-9)
    assert not solution.converged
    assert solution.status == "stagnated"
    assert "stopped falling" in solution.reason
    assert "not converged" in str(solution)


@pytest.mark.parametrize(
    "arguments, words",
    [
        ({}, "exactly one of pressure and separation"),
        ({"pressure": 1.0, "separation": 1.0}, "exactly one of pressure and separation"),
        ({"pressure": [1.0, 2.0]}, "give one number, or all of them to bem_curve"),
        ({"separation": np.ones(2)}, "give one number, or all of them to bem_curve"),
        ({"pressure": 10**400}, "must be a number"),
        ({"pressure": -1.0}, "is negative"),
        ({"pressure": np.nan}, "finite mean pressure"),
        ({"pressure": "much"}, "must be a number"),
        ({"separation": 0.0}, "prescribe a pressure instead"),
        ({"separation": np.inf}, "finite distance"),
        ({"pressure": 1.0, "tolerance": 1e-14}, "tolerance is"),
        ({"pressure": 1.0, "tolerance": "loose"}, "tolerance is"),
        ({"pressure": 1.0, "guess": "none"}, "guess has shape"),
        ({"pressure": 1.0, "boundary": "open"}, "boundary is 'open'"),
    ],
)
def test_refusals(arguments, words):
    """Each wrong argument gives one sentence."""
    with pytest.raises(errors.InputError, match=words):
        bem_solve(rough((20, 26)), BODY, **arguments)


def test_missing_points_are_refused():
    """A map with holes is refused with the option that fills them."""
    heights = rough((20, 26)).heights.copy()
    heights[3, 4] = np.nan
    with pytest.raises(errors.SurfaceError, match=r"is missing \(1 of 520 points\).*fill"):
        bem_solve(HeightMap(heights, 0.1), BODY, pressure=1.0)


def test_no_separation_is_left_in_full_contact():
    """Rounding was, of either sign: -1e-17 m of heights of 0.1 m."""
    hm = rough((24, 32))
    low, full = (bem_solve(hm, BODY, pressure=p).separation for p in (1e-3, 10.0))
    assert low > 0.0 and full == 0.0
    curve = bem_curve(hm, BODY, pressures=[1e-3, 10.0, 20.0])
    assert curve.separation[1:].tolist() == [0.0, 0.0] and np.isinf(curve.stiffness[1:]).all()


@pytest.mark.parametrize("size", [1e-30, 1e-12, 1e12])
@pytest.mark.parametrize("kind", ["pressure", "separation"])
def test_heights_of_any_size(size, kind):
    """Loops in single precision stagnated on heights of 1e-18 m and less."""
    hm = rough((40, 48), size=(0.8, 1.0), slope=0.1, seed=4)
    small = hm.replace(heights=hm.heights * size)
    asked = {"pressure": 1e-3, "separation": 1.5 * hm.rms_height}[kind]
    one = bem_solve(hm, HalfSpace.from_modulus(1.0), **{kind: asked})
    other = bem_solve(small, HalfSpace.from_modulus(1.0), **{kind: asked * size})
    assert one.converged and other.converged
    assert other.separation == pytest.approx(size * one.separation, rel=1e-5)
    assert other.mean_pressure == pytest.approx(size * one.mean_pressure, rel=1e-4)
    assert other.elastic_energy == pytest.approx(size**2 * one.elastic_energy, rel=1e-4)
    assert other.gap == pytest.approx(size * one.gap, abs=1e-5 * small.rms_height)


@pytest.mark.parametrize("shape", [(120, 108), (97, 128)])
def test_a_map_that_is_moved_or_mirrored_takes_the_same_path(shape):
    """The coarser grids that a solve starts from belong to the surface, not to its first pixel: so
    far from the solution as a rough tolerance leaves it, the pressure is the same, too."""
    hm = rough(shape)
    ways = [
        (lambda z: z[::-1], lambda z: z[::-1]),
        (lambda z: z[:, ::-1], lambda z: z[:, ::-1]),
        (lambda z: np.roll(z, (7, 13), (0, 1)), lambda z: np.roll(z, (-7, -13), (0, 1))),
    ]
    for pressure in (2e-3, 4e-2):
        found = bem_solve(hm, BODY, pressure=pressure, tolerance=0.05)
        for there, back in ways:
            other = hm.replace(heights=np.ascontiguousarray(there(hm.heights)))
            again = bem_solve(other, BODY, pressure=pressure, tolerance=0.05)
            np.testing.assert_allclose(
                back(again.pressure), found.pressure, atol=1e-6 * found.pressure.max()
            )


@pytest.mark.parametrize("value", [1e-320, 1e308, 1.0])
def test_a_guess_of_any_size(value):
    """Its mean was rounded to nothing, or beyond all numbers."""
    hm = rough()
    found = bem_solve(hm, BODY, pressure=0.05, guess=np.full(hm.shape, value))
    assert found.converged


@pytest.mark.parametrize("points", [256, 400])
def test_a_flat_punch_of_any_size_converges(points):
    """The error allowed was that of the transforms."""
    flat = HeightMap(np.zeros((points, points)), (1e-6, 1e-6))
    found = bem_solve(flat, HalfSpace.from_modulus(1e9), separation=-1e-7)
    assert found.converged and np.isfinite(found.stiffness)
