"""Contacts on the flanks of loaded hills have the areas of their tilted basins."""

from dataclasses import replace

import numpy as np
import pytest
from strategies import sampled

import asperity
import surfaces
from asperity.halfspace.scene import pressure_scale
from asperity.microcontact import tabulate
from asperity.model.corrections import tilted_basins
from asperity.model.corrections.tilted_basins import area_under
from asperity.parameters import DEFAULTS


@pytest.mark.parametrize(
    ("hardness", "within", "level_share"), [(np.inf, 0.06, 0.88), (0.5, 0.03, 0.95)]
)
def test_on_the_flank_of_a_loaded_hill_the_area_is_nearer_and_forces_are_the_same(
    hardness, within, level_share
):
    """The basins of the level surface, none joined, lack 12 % of the area, 6 % where most of it has
    yielded."""
    hm = surfaces.self_affine(
        (96, 120), (96.0, 120.0), hurst=1.0, rms_slope=0.1, rolloff=None, cutoff=8.0, seed=12
    )
    fine = surfaces.resample(hm, np.asarray(hm.spacing) / 2)
    scale = pressure_scale(hm, asperity.HalfSpace.from_modulus(1.0))
    body = asperity.HalfSpace.from_modulus(1.0, hardness=hardness * scale)
    pressure = 0.03 * scale
    exact = asperity.bem_solve(fine, body, pressure=pressure, tolerance=1e-4)
    states = []
    for switch in (True, False):
        apart = replace(DEFAULTS.corrections, joined_pairs=False, tilted_basins=switch)
        chosen = replace(DEFAULTS, corrections=apart)
        plan = asperity.make_plan(hm, body, pressures=[pressure], parameters=chosen)
        states.append(asperity.solve_contacts(hm, body, plan, pressures=[pressure]).points[0].state)
    tilted, level = states
    np.testing.assert_array_equal(tilted.force, level.force)
    assert tilted.contact_area == pytest.approx(tilted.area.sum(), rel=1e-12)
    assert tilted.contact_area == pytest.approx(exact.contact_area, rel=within)
    assert level.contact_area < level_share * exact.contact_area


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_area_under_a_force_is_that_at_its_approach(m):
    body = asperity.HalfSpace.from_modulus(3.0, m)
    profiles = [
        lambda r, phi, k=k: r**2 / 2 * (k * np.cos(phi) ** 2 + np.sin(phi) ** 2) for k in (1.0, 2.0)
    ]
    table = tabulate(sampled(profiles, [0.7, 0.5]), body, law="harmonic")
    for share in (1e-6, 1e-3, 0.03, 0.2, 0.95, 1.0, 3.0):
        force, _, area = table.evaluate(np.arange(2), table.reach * share)
        np.testing.assert_allclose(area_under(table, force), area, rtol=2e-3)
    assert (area_under(table, np.zeros(2)) == 0.0).all()


def test_an_elastic_law_that_falls_tilts_no_basin(monkeypatch):
    """Of steep gradings the law of a single contact may, here and there."""
    hm = surfaces.self_affine(
        (96, 120), (96.0, 120.0), hurst=0.8, rms_slope=0.1, cutoff=4.0, seed=12
    )
    scale = pressure_scale(hm, asperity.HalfSpace.from_modulus(1.0))
    body = asperity.HalfSpace.from_modulus(1.0, 0.3, hardness=0.5 * scale)
    run = asperity.solve_contacts(hm, body, pressures=[0.03 * scale])
    population, state = run.decomposition.population, run.points[0].state
    falling = staticmethod(lambda rows, approach: tuple(np.full((2, len(rows)), [[0.5], [-1.0]])))
    monkeypatch.setattr(type(population.table), "elastic_at", falling)
    fitted = DEFAULTS.tilted_basins
    found = tilted_basins.correct(population, run.decomposition.summits, state, fitted)
    assert found.contact_area == pytest.approx(state.contact_area, rel=0.1)
