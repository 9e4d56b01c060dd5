"""Tables that grow: the same answers, and only the rows that are needed."""

from __future__ import annotations

import numpy as np
import pytest
from strategies import random_population

from asperity.halfspace.footprint import Footprints
from asperity.halfspace.material import HalfSpace
from asperity.interaction.newton.laws import Laws
from asperity.interaction.population import Population
from asperity.microcontact import law_table
from asperity.microcontact.law_table import LawTable, LazyTable

CELL = (1.0, 1.4)


def tables(n, seed=0):
    y, x, height, hertz = random_population(n, CELL, seed)
    zeros = np.zeros(hertz.force.shape)
    whole = LawTable(
        hertz.reach, hertz.force, hertz.stiffness, hertz.area, zeros.astype(np.uint8), zeros
    )
    asked = []

    def make(rows):
        asked.append(rows)
        arrays = (getattr(whole, k)[rows] for k in ("reach", "force", "stiffness", "area"))
        return LawTable(*arrays, whole.flags[rows], whole.spread[rows])

    return y, x, height, whole, LazyTable(n, make), asked


def test_rows_are_made_once_and_in_place():
    *_, whole, lazy, asked = tables(50)
    for rows in np.array([7, 3]), np.array([3, 9]), np.array([9, 7]):
        for part, laws in lazy.blocks(rows):
            np.testing.assert_array_equal(part, rows)
            for name, values in laws.columns.items():
                np.testing.assert_array_equal(values, getattr(whole, name)[rows])
    np.testing.assert_array_equal(np.concatenate(asked), [7, 3, 9])
    assert lazy.ready.sum() == 3 and len(lazy) == 50


def test_what_load_points_read_is_kept():
    """Of contacts without a law it is nothing."""
    whole = tables(50)[3]
    whole.centre = np.random.default_rng(1).normal(size=(*whole.force.shape, 2))
    whole.spread[:], whole.flags[:] = whole.centre[..., 0], 7
    lazy = LazyTable(50, whole.rows)
    for rows in np.array([7, 3]), np.array([12]):
        assert [len(laws) for _, laws in lazy.blocks(rows)] == [len(rows)]
    made, deep = np.array([12, 3, 7]), np.array([0.2, 0.7, 1.3]) * whole.reach[[12, 3, 7]]
    complete = LazyTable.of(whole)
    for read in ("spread_at", "flags_at", "centre_at"):
        np.testing.assert_array_equal(
            getattr(lazy, read)(made, deep), getattr(complete, read)(made, deep)
        )
    assert not lazy.flags_at(np.array([0, 49]), np.ones(2)).any()


def test_laws_on_disk_are_those_in_memory(monkeypatch):
    """Kept columns and those of solvers, which are read in parts, in any order."""
    monkeypatch.setattr(law_table, "MAPPED_LAWS", 30)
    *_, whole, _, _ = tables(500)
    whole.centre = np.random.default_rng(1).normal(size=(*whole.force.shape, 2))
    whole.spread[:] = whole.centre[..., 0]
    some = np.random.default_rng(2).permutation(500)[:311]
    deep = 0.8 * whole.reach[some]
    found = []
    for stored in (False, True):
        lazy = LazyTable(500, whole.rows, near=np.argsort, stored=stored)
        laws = Laws(lazy, Footprints(1.0)).rows(some)
        laws.make()
        values = [getattr(lazy, read)(some, deep) for read in ("spread_at", "flags_at")]
        law = laws(deep)
        found.append([*values, lazy.centre_at(some, deep), law.force, law.area, law.moment])
    for known, value in zip(*found, strict=True):
        np.testing.assert_allclose(value, known, rtol=1e-13)
    assert lazy.together(311) == 30 * 311 / 500


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("interaction", [True, False])
def test_a_lazy_table_gives_the_same_curve(boundary, interaction):
    y, x, height, whole, lazy, _ = tables(900)
    curves, counts = [], []
    for table in (whole, lazy):
        population = Population(
            x=x, y=y, height=height, table=table, cell=CELL, boundary=boundary,
            material=HalfSpace.from_modulus(1.0), interaction=interaction,
        )  # fmt: skip
        state, pressures = None, []
        for separation in (0.03, 0.02, 0.01):
            state = population.solve(separation=separation, state=state)
            assert state.converged
            pressures.append(state.mean_pressure)
            counts.append(lazy.ready.sum())
        state = population.solve(pressure=pressures[-1] * 1.2, state=state)
        curves.append([*pressures, state.separation])
    np.testing.assert_allclose(curves[0], curves[1], rtol=2e-3)
    assert 0 < counts[3] < 700


def test_laws_for_loads_to_come_are_made_in_few_blocks():
    pressures, found = np.geomspace(3e-4, 3e-2, 10), []
    for heaviest in (None, pressures[-1]):
        y, x, height, _, table, asked = tables(12000)
        population = Population(
            x=x, y=y, height=height, table=table, cell=CELL, boundary="periodic",
            material=HalfSpace.from_modulus(1.0),
        )  # fmt: skip
        state, curve = None, []
        for pressure in pressures:
            state = population.solve(pressure=pressure, state=state, heaviest=heaviest)
            assert state.converged
            curve.append(state.separation)
        found.append((curve, len(asked), table.ready.sum(), state.active))
    (plain, blocks, *_), (curve, fewer, made, active) = found
    np.testing.assert_allclose(curve, plain, rtol=1e-9)
    assert 2 * fewer < blocks and made < 1.5 * active


def test_areas_never_fall():
    """Of a punch, whose area jumps at the first touch, nor where nodes scatter."""
    u = np.arange(13.0) / 12
    area = np.where(u > 0, 0.3, 0.0) * (1 + 0.02 * np.cos(9 * np.arange(13)))
    nothing = np.zeros((1, 13))
    table = LawTable(
        np.ones(1), (u**2)[None], np.ones((1, 13)), area[None], nothing.astype(np.uint8), nothing
    )
    found = table.evaluate(0, np.linspace(0.0, 1.2, 500))[2]
    assert np.all(np.diff(found) >= -1e-15) and found[-1] == pytest.approx(area.max(), rel=1e-15)


def test_summits_without_a_law_stay_open():
    y, x, height, whole, _, _ = tables(100)
    dead = np.argsort(-height)[:10]

    def make(rows):
        arrays = {k: getattr(whole, k)[rows] for k in ("reach", "force", "stiffness", "area")}
        arrays["reach"] = np.where(np.isin(rows, dead), 0.0, arrays["reach"])
        return LawTable(*arrays.values(), whole.flags[rows], whole.spread[rows])

    population = Population(
        x=x, y=y, height=height, table=LazyTable(100, make), cell=CELL, boundary="periodic",
        material=HalfSpace.from_modulus(1.0),
    )  # fmt: skip
    state = population.solve(separation=0.0)
    assert state.converged and state.active > 0
    assert not state.force[dead].any() and not state.approach[dead].any()
