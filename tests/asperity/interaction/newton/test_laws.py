"""Laws of the contacts: Hertz exactly, energy, footprint moments, filled basins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from oracles import HertzTable

from asperity.errors import InputError
from asperity.halfspace.footprint import Footprints
from asperity.interaction.newton.laws import FILLED_SHARE, LARGEST_STIFFNESS, Laws
from asperity.microcontact.law_table import LawTable

EXPONENTS = (-0.3, 0.0, 0.5)
TABLE = HertzTable(np.array([1.0, 3.0]), np.array([0.2, 0.5]))


@pytest.mark.parametrize("m", EXPONENTS)
def test_hertz_and_filled_basin_are_reproduced(m):
    table = replace(TABLE, m=m, modulus=2.0, nodes=16)
    laws = Laws(table, Footprints(2.0, m))
    for d in (1e-6, 0.03, 0.17, 0.6, 2.0):
        law = laws(np.full(2, d))
        force, stiffness, area = table.evaluate(np.arange(2), np.full(2, d))
        np.testing.assert_allclose(law.force, force, rtol=1e-7)
        np.testing.assert_allclose(law.stiffness, stiffness, rtol=1e-7)
        np.testing.assert_allclose(law.area, area, rtol=1e-7)
        assert (
            laws.filled(law) == (area > FILLED_SHARE * np.pi * (1 + m) * table.radius * table.reach)
        ).all()


def law_table(reach, force, stiffness, area, exponent=3.0):
    rest = np.zeros(force.shape, np.uint8), np.zeros(force.shape)
    return LawTable(reach, force, stiffness, area, *rest, exponent)


def tip(power, m):
    """Law of f = r^power: force and area as powers of the approach, to a reach of 2."""
    grid = 2.0 * (np.arange(13) / 12)[None] ** 2
    rise = 1.0 + (1.0 + m) / power
    one = np.full(1, 2.0)
    force, stiffness = 3.0 * grid**rise, 3.0 * rise * grid ** (rise - 1.0)
    area = 500.0 * grid ** (2.0 / power)
    return law_table(one, force, stiffness, area, 3.0 + m), rise


@pytest.mark.parametrize("m", EXPONENTS)
@pytest.mark.parametrize("power", [1.0, 1.5, 4.0, 12.0])
def test_a_tip_that_is_no_paraboloid_keeps_its_powers_below_the_first_node(power, m):
    table, rise = tip(power, m)
    f = Footprints(1.0, m)
    laws = Laws(table, f)
    d = table.approach()[0, 1] * np.array([1e-4, 0.01, 0.5, 0.999])
    for depth in d:
        law, own = laws(np.full(1, depth)), table.evaluate(0, depth)
        force, stiffness = 3.0 * depth**rise, 3.0 * rise * depth ** (rise - 1.0)
        for found, exact in (
            (law.force, force), (law.stiffness, stiffness), (law.area, 500 * depth ** (2 / power)),
            (law.energy, force * depth / (rise + 1.0)), (law.moment + law.growth,
            f.variance(stiffness)), (own[0], force), (own[1], stiffness), (own[2], law.area[0]),
        ):  # fmt: skip
            np.testing.assert_allclose(found, exact, rtol=1e-9)
        h = 1e-4 * depth
        up, down = laws(np.full(1, depth + h)), laws(np.full(1, depth - h))
        growth = law.force * (up.moment - down.moment) / (up.force - down.force)
        np.testing.assert_allclose(growth, law.growth, rtol=1e-4, atol=1e-9 * law.moment[0])
    below, above = (laws(np.full(1, table.approach()[0, 1] * (1 + e))) for e in (-1e-9, 1e-9))
    for name in ("force", "stiffness", "area", "energy", "moment"):
        np.testing.assert_allclose(getattr(below, name), getattr(above, name), rtol=1e-6)


def test_open_contacts_carry_nothing():
    law = Laws(TABLE, Footprints(1.0))(np.array([0.0, -1.0]))
    assert not law.force.any() and not law.stiffness.any() and not law.moment.any()


@pytest.mark.parametrize("m", EXPONENTS)
@pytest.mark.parametrize("d", [0.01, 0.1, 0.45, 0.8])
def test_derivatives(m, d):
    """dU/dd = F, dF/dd = k, F dm/dF = growth."""
    laws = Laws(replace(TABLE, m=m), Footprints(1.0, m))
    h = 1e-6
    at, up, down = (laws(np.full(2, d + e)) for e in (0, h, -h))
    np.testing.assert_allclose((up.energy - down.energy) / (2 * h), at.force, rtol=1e-7)
    np.testing.assert_allclose((up.force - down.force) / (2 * h), at.stiffness, rtol=1e-6)
    growth = at.force * (up.moment - down.moment) / (up.force - down.force)
    np.testing.assert_allclose(growth, at.growth, rtol=1e-5)


def test_moment_of_hertz_is_three_fifths_of_the_footprint():
    f = Footprints(1.0)
    law = Laws(TABLE, f)(np.full(2, 0.15))
    np.testing.assert_allclose(law.moment, 0.6 * f.variance(law.stiffness), rtol=1e-6)
    np.testing.assert_allclose(law.moment + law.growth, f.variance(law.stiffness), rtol=1e-6)


@pytest.mark.parametrize("m", EXPONENTS)
def test_footprint_of_a_filled_basin_is_that_of_its_punch(m):
    """Growth of the whole-force footprint ends at the punch's."""
    f = Footprints(1.0, m)
    laws = Laws(replace(TABLE, m=m), f)
    law = laws(np.full(2, 50.0))
    np.testing.assert_allclose(law.moment, f.variance(law.stiffness), rtol=0.05)


def test_a_broken_table_is_mended_into_a_growing_law():
    rng = np.random.default_rng(4)

    force = np.cumsum(rng.uniform(-0.2, 1, (20, 13)), axis=1) - 0.1
    stiffness, area = rng.uniform(-1, 20, (20, 13)), rng.uniform(1, 2, (20, 13))
    laws = Laws(law_table(np.ones(20), force, stiffness, area), Footprints(1.0))
    force = np.array([laws(np.full(20, (j / 12) ** 2)).force for j in range(15)])
    assert (np.diff(force, axis=0) > 0).all()
    for d in np.linspace(0.01, 1.5, 50):
        law = laws(np.full(20, d))
        assert (law.stiffness > 0).all() and (law.force > 0).all()
    cap = LARGEST_STIFFNESS * 2 * np.sqrt(area.max(axis=1) / np.pi)
    assert (laws(np.full(20, 2.0)).stiffness <= cap * (1 + 1e-9)).all()


@pytest.mark.parametrize("m", EXPONENTS)
def test_a_sound_table_is_left_alone(m):
    table = replace(TABLE, m=m)
    laws, last = Laws(table, Footprints(1.0, m)), table.force.shape[1] - 1
    for node in range(1, last + 1):
        law = laws(table.reach * (node / last) ** 2)
        np.testing.assert_allclose(law.force, table.force[:, node], rtol=1e-12)
        np.testing.assert_allclose(law.stiffness, table.stiffness[:, node], rtol=1e-12)


@pytest.mark.parametrize("m", EXPONENTS)
def test_mending_a_hertz_table_loses_little(m):
    """A dent in one nodal stiffness: the force stays within a percent."""
    table = replace(TABLE, m=m)
    dented = law_table(table.reach, table.force, table.stiffness, table.area, 3.0 + m)
    dented.stiffness[:, 7] = 0.99 * dented.stiffness[:, 6]
    f = Footprints(1.0, m)
    mended, sound = Laws(dented, f), Laws(table, f)
    last = table.force.shape[1] - 1
    before, dent = (mended(table.reach * (node / last) ** 2).stiffness for node in (6, 7))
    assert (dent >= before).all()
    for d in (0.01, 0.1, 0.3):
        np.testing.assert_allclose(
            mended(np.full(2, d)).force, sound(np.full(2, d)).force, rtol=0.01
        )


@pytest.mark.parametrize("field", ["reach", "force", "stiffness", "area"])
def test_a_table_with_nan_is_refused(field):
    table = law_table(np.ones(2), *np.ones((3, 2, 5)))
    getattr(table, field)[:] = np.nan
    with pytest.raises(InputError, match=field):
        Laws(table, Footprints(1.0))


@pytest.mark.parametrize("seed", range(20))
def test_the_footprint_of_an_increment_is_no_less_than_a_point(seed):
    """Also of laws that a hardness makes stand nearly still, and rise again."""
    rng = np.random.default_rng(seed)
    grid = 2.0 * (np.arange(13) / 12)[None] ** 2
    force = np.cumsum(rng.exponential(size=(1, 13)) ** 4, axis=1) * grid
    stiffness = rng.exponential(size=(1, 13)) ** 4 * force / np.maximum(grid, 1e-9)
    area = 50.0 * grid + 1e-9
    table = replace(law_table(np.full(1, 2.0), force, stiffness, area), hardness=10.0)
    laws = Laws(table, Footprints(1.0, 0.0))
    for depth in np.linspace(0.01, 2.5, 300):
        law = laws(np.full(1, depth))
        assert law.moment[0] >= 0.0 and law.moment[0] + law.growth[0] >= 0.0


@pytest.mark.parametrize("hardness", [np.inf, 10.0])
def test_a_law_that_stands_still_at_first_carries_next_to_nothing(hardness):
    """As that of a plateau, whose rays rise before they fall."""
    grid = 2.0 * (np.arange(13) / 12)[None] ** 2
    force = np.maximum(grid - grid[:, 4:5], 0.0)
    table = law_table(np.full(1, 2.0), force, np.sign(force), 50.0 * grid)
    laws = Laws(replace(table, hardness=hardness), Footprints(1.0, 0.0))
    for depth in np.linspace(0.01, 2.5, 300):
        law = laws(np.full(1, depth))
        assert all(np.isfinite(getattr(law, name)).all() for name in law.__slots__)
        assert law.force[0] > 0.0 and (depth > grid[0, 4] or law.force[0] < 2e-3)
