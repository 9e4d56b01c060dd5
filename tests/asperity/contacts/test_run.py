"""Maps and tables of the load points of a run: what they share, and those that have none."""

from __future__ import annotations

import numpy as np
import pytest
from strategies import rough

import asperity
from asperity.contacts.run import solve_contacts
from asperity.contacts.table import microcontacts
from asperity.errors import ConvergenceError, InputError
from asperity.halfspace.scene import default_pressures
from surfaces import HeightMap, self_affine

STEEL = asperity.HalfSpace(210e9, 0.3)


def test_map_and_table_hold_the_same_area():
    hm = rough(slope=0.1)
    run = solve_contacts(hm, STEEL, pressures=default_pressures(hm, STEEL)[-3:])
    for number, point in enumerate(run.points):
        table, area = microcontacts(run.decomposition, point), point.state.contact_area
        pixels = np.count_nonzero(run.contact_map(number))
        assert table["area"].sum() == pytest.approx(area, rel=1e-9)
        assert pixels * hm.area / hm.heights.size == pytest.approx(area, rel=0.15)


@pytest.mark.parametrize("m", [-0.3, 0.0])
def test_contacts_smaller_than_a_pixel_are_in_the_maps_too(m):
    """Seen at light load on a map that is rough to the pixel, where most of them are."""
    hm = self_affine((60, 80), (0.6e-3, 1.2e-3), hurst=0.8, rms_slope=0.1, seed=3)
    body = asperity.HalfSpace.from_modulus(2e11, m=m)
    loads = default_pressures(hm, body)[0] * np.array([1e-3, 0.1, 1.0])
    run = solve_contacts(hm, body, pressures=loads)
    for point, load in enumerate(run.curve.mean_pressure):
        pressure = run.pressure_map(point)
        assert pressure.mean() == pytest.approx(load, rel=1e-9)
        np.testing.assert_array_equal(run.contact_map(point), pressure > 0)


def test_a_load_point_that_did_not_converge_has_no_tables():
    run = solve_contacts(rough(slope=0.1), STEEL, pressures=[1e7, 1e12])
    for ask in (run.microcontacts, run.spots, run.contact_map, run.pressure_map):
        with pytest.raises(ConvergenceError, match="-1 cannot be used: beside the contacts"):
            ask()
        assert len(ask(0))


def test_a_load_point_that_is_none():
    run = solve_contacts(rough(slope=0.1), STEEL, pressures=[1e7, 2e7])
    for ask in (run.microcontacts, run.spots, run.contact_map, run.pressure_map):
        for none in (2, slice(0, 1), 1.0):
            with pytest.raises(InputError, match="numbered 0 to 1"):
                ask(none)
    assert len(run.microcontacts(1)) == len(run.microcontacts(-1))


def test_pressures_of_both_models_are_drawn_as_maps_are():
    figure = pytest.importorskip("matplotlib.figure").Figure()
    hm = self_affine((24, 32), (24e-6, 32e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6, seed=1)
    body = asperity.HalfSpace.from_modulus(1e9)
    run = solve_contacts(hm, body, pressures=[1e6, 3e6])
    solution = asperity.bem_solve(hm, body, pressure=3e6)
    for axes, plot, pressure in (
        (figure.add_subplot(1, 2, 1), run.plot, run.pressure_map()),
        (figure.add_subplot(1, 2, 2), solution.plot, solution.pressure),
    ):
        (drawn,) = plot(ax=axes, cmap="gray").images
        np.testing.assert_allclose(drawn.get_array(), pressure / 1e6)
        assert axes.child_axes[0].get_ylabel() == "pressure [MPa]"


def test_a_spot_across_the_seam_has_its_centre_on_the_hill():
    """Its pixels lie in all four corners of the map."""
    y, x = (2.0 * np.pi * np.arange(n) / n for n in (48, 60))
    hm = HeightMap(0.01 * (np.cos(y)[:, None] + np.cos(x)), (1.5e-2, 1e-2), periodic=True)
    body = asperity.HalfSpace.from_modulus(1.0)
    run = solve_contacts(hm, body, separations=[0.8 * float(hm.heights.max())])
    (spot,) = run.spots()
    assert spot["pixels"] > 20
    for place, step, size in zip("yx", hm.spacing, hm.size, strict=True):
        away = np.mod(spot[place] - 0.5 * step + 0.5 * size, size) - 0.5 * size
        assert abs(away) < 0.05 * step
