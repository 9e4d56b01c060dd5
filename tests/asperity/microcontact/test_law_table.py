"""Tables that grow: the same answers, and only the rows that are needed."""

from __future__ import annotations

import numpy as np
import pytest
from strategies import random_population

from asperity.halfspace.material import HalfSpace
from asperity.interaction.population import Population
from asperity.microcontact.law_table import LawTable

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

    return y, x, height, whole, LawTable.lazy(n, make), asked


def test_rows_are_made_once_and_in_place():
    *_, whole, lazy, asked = tables(50)
    lazy.ensure(np.array([7, 3, 7]))
    lazy.ensure(np.array([3, 9]))
    np.testing.assert_array_equal(np.concatenate(asked), [3, 7, 9])
    assert lazy.ready.sum() == 3 and len(lazy) == 50
    np.testing.assert_array_equal(lazy.force[[3, 7, 9]], whole.force[[3, 7, 9]])
    assert not lazy.reach[[0, 49]].any()


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


def test_summits_without_a_law_stay_open():
    y, x, height, whole, _, _ = tables(100)
    dead = np.argsort(-height)[:10]

    def make(rows):
        arrays = {k: getattr(whole, k)[rows] for k in ("reach", "force", "stiffness", "area")}
        arrays["reach"] = np.where(np.isin(rows, dead), 0.0, arrays["reach"])
        return LawTable(*arrays.values(), whole.flags[rows], whole.spread[rows])

    population = Population(
        x=x, y=y, height=height, table=LawTable.lazy(100, make), cell=CELL, boundary="periodic",
        material=HalfSpace.from_modulus(1.0),
    )  # fmt: skip
    state = population.solve(separation=0.0)
    assert state.converged and state.active > 0
    assert not state.force[dead].any() and not state.approach[dead].any()
