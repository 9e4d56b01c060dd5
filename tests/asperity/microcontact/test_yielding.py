"""The law of a contact under a hardness against rings, and its limits."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from scipy.special import hyp2f1

from asperity import HalfSpace
from asperity.microcontact.yielding import capped

MODULUS = 3.0


@lru_cache(maxsize=8)
def rings(m, count=160, grading=2.5):
    """Rings on a disc of radius 1: their middles, displacements and areas, and the edge's ratio.

    Displacement of a disc under unit pressure at unit modulus, from the potential r^-(1+m). The
    pressures of the last two rings are those of a root (1 - r)^((1+m)/2).
    """
    t = np.linspace(0, 1, count + 1)
    edge, rest = (x**grading / (t**grading + (1 - t) ** grading) for x in (t, 1 - t))
    r, away = ((x[1:] + x[:-1]) / 2 for x in (edge, rest))
    outer = edge[1:]
    near = np.minimum(r[:, None] / outer, 1) ** 2
    far = np.minimum(outer / r[:, None], 1) ** 2
    inside = 2 / (1 - m) * outer ** (1 - m) * hyp2f1((m - 1) / 2, (m + 1) / 2, 1, near)
    outside = outer**2 * r[:, None] ** (-1 - m) * hyp2f1((1 + m) / 2, (1 + m) / 2, 2, far)
    disc = np.cos(m * np.pi / 2) * np.where(rest[1:] < away[:, None], inside, outside)
    root = np.diff(rest ** ((3 + m) / 2)) / np.diff(rest)
    effect = np.diff(disc, axis=1, prepend=0.0)
    return r, effect, np.pi * np.diff(edge**2), root[-1] / root[-2]


def pressed(gap, a, m, hardness=np.inf):
    """Force, approach and saturated share of the contact of radius a by rings."""
    r, effect, area, last = rings(m)
    effect = effect / MODULUS * a ** (1 - m)
    n = r.size
    full = np.zeros(n, bool)
    for _ in range(60):
        system = np.zeros((n + 1, n + 1))
        system[:n, :n], system[:n, n] = effect, -1
        goal = np.append(-gap(a * r), 0.0)
        system[:n][full] = np.eye(n + 1)[:n][full]
        goal[:n][full] = hardness
        system[n, n - 2 : n] = -last, 1
        found = np.linalg.solve(system, goal)
        p, d = found[:n], found[n]
        sunk = effect @ p - d + gap(a * r)
        new = np.where(full, sunk <= 1e-13, p > hardness)
        new[-2:] = False
        if np.array_equal(new, full):
            return a * a * p @ area, d, area[full].sum() / np.pi
        full = new
    raise AssertionError("the rings do not settle")


def elastic(gap, a, m):
    """Approach, force, area and stiffness of the elastic contact of radius a."""
    force, d, _ = pressed(gap, a, m)
    return d, force, np.pi * a * a, 2 * MODULUS * a ** (1 + m) / (1 + m)


PROFILES = {
    "r^0.7": lambda r: r**0.7,
    "cone": lambda r: r,
    "r^1.5": lambda r: r**1.5,
    "paraboloid": lambda r: r * r / 2,
    "r^3": lambda r: r**3,
    "r^4": lambda r: r**4,
    "r^6": lambda r: r**6,
    "hyperboloid": lambda r: np.sqrt(1 + r * r) - 1,
    "steepening": lambda r: r * r / 2 + r**4 / 8,
    "rounded cone": lambda r: np.where(r < 0.5, r * r, r - 0.25),
    "cone and paraboloid": lambda r: r + r * r,
}


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.3])
@pytest.mark.parametrize("name", PROFILES)
def test_rings(name, m):
    """Force at equal approach, area at equal force within 2 % of rings (graded 3 %, r^6 5 %)."""
    gap = PROFILES[name]
    radii = np.geomspace(0.6, 1.6, 33)
    rows = np.array([elastic(gap, a, m) for a in radii])
    hardness = float(np.median(rows[:, 1] / rows[:, 2]))
    body = HalfSpace.from_modulus(MODULUS, m, hardness=hardness)
    found = capped(*rows.T, body)
    exact = np.array([pressed(gap, a, m, hardness) for a in radii])
    part = (exact[:, 2] < 0.9999) & (exact[:, 2] > 0)
    assert part.sum() > 1
    worst = 0.02 if m == 0 else 0.05 if name == "r^6" else 0.03
    force = np.interp(np.log(exact[:, 1]), np.log(found.approach), np.log(found.force))
    inside = part & (np.abs(np.log(radii)) < 0.4)
    np.testing.assert_allclose(np.exp(force)[inside], exact[inside, 0], rtol=worst)
    area = np.interp(np.log(exact[:, 0]), np.log(found.force), np.log(rows[:, 2]))
    np.testing.assert_allclose(np.exp(area)[inside], rows[inside, 2], rtol=worst)


def paraboloid(a, hardness):
    """The paraboloid r^2/2 at m = 0 and contact radii a."""
    rows = a**2, 4 / 3 * MODULUS * a**3, np.pi * a**2, 2 * MODULUS * a
    return capped(*rows, HalfSpace.from_modulus(MODULUS, hardness=hardness))


@pytest.mark.parametrize(
    ("depth", "force", "area", "share"),
    [
        (1.1, 1.1532, 1.1004, 0.136),
        (1.5, 1.8153, 1.514, 0.488),
        (2.2, 3.1004, 2.301, 0.768),
        (3, 4.6962, 3.293, 0.893),
        (4, 6.816, 4.641, 0.955),
        (7, 13.66, 9.13, 0.996),
    ],
)
def test_recorded_paraboloid(depth, force, area, share):
    """700 rings: approach, force and area over those at first yield, and the saturated share."""
    hardness = 0.5
    start = np.pi * hardness / (2 * MODULUS)
    a = start * np.linspace(1, 4, 3001)
    found = paraboloid(a, hardness)
    at = np.interp(depth, found.approach / start**2, np.arange(a.size))
    value = [np.interp(at, np.arange(a.size), x) for x in (found.force, a**2, found.saturated)]
    assert value[0] / (2 / 3 * np.pi * hardness * start**2) == pytest.approx(force, rel=2e-3)
    assert value[1] / start**2 == pytest.approx(area, rel=3e-3)
    assert value[2] == pytest.approx(share, abs=0.02)


def test_limits():
    """Elastic to the last digit up to first yield; H A and the level of the edge far beyond."""
    hardness = 0.5
    start = np.pi * hardness / (2 * MODULUS)
    early = start * np.array([0.1, 0.999999])
    found = paraboloid(early, hardness)
    np.testing.assert_array_equal(found.force, 4 / 3 * MODULUS * early**3)
    np.testing.assert_array_equal(found.approach, early**2)
    late = start * np.array([6.0, 40.0])
    found = paraboloid(late, hardness)
    np.testing.assert_allclose(found.force, hardness * np.pi * late**2, rtol=1e-5)
    edge = late**2 / 2 + 4 * hardness * late / (np.pi * MODULUS)
    np.testing.assert_allclose(found.approach, edge, rtol=1e-5)


@pytest.mark.parametrize("m", [-0.6, -0.2, 0.0, 1e-7, 0.2, 0.6])
@pytest.mark.parametrize("k", [0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 12.0])
def test_bounded_growing_and_continuous(k, m):
    """0 <= F <= min(elastic, H A); force and share grow, approach has no jump."""
    mean = np.geomspace(1e-2, 30, 4000)
    rows = 1.0, mean, 1.0, (1 + (1 + m) / k) * mean
    found = capped(*rows, HalfSpace.from_modulus(1.0, m, hardness=1.0))
    assert np.all(found.force <= np.minimum(mean, 1))
    assert np.all(np.diff(found.force) >= -1e-12) and np.all(np.diff(found.force) < 0.01)
    assert np.all(np.diff(found.saturated) >= -1e-9)
    assert np.all((found.approach > 0) & (found.approach <= 1.001))
    assert np.max(np.abs(np.diff(found.approach))) < 0.01


def test_gradings_pass_through_the_homogeneous_body():
    rows = 0.5, 1.0, 1.2, 3.1
    near, at = (capped(*rows, HalfSpace.from_modulus(1.0, m, hardness=0.6)) for m in (1e-5, 0.0))
    np.testing.assert_allclose(near, at, rtol=1e-4)


def test_scaling():
    """Lengths times s, pressures times t."""
    s, t = 1e-6, 1e9
    rows = np.array([0.5, 1.0, 1.2, 3.1])
    one = capped(*rows, HalfSpace.from_modulus(1.0, hardness=0.6), level=0.3)
    units = np.array([s, t * s**2, s**2, t * s])
    other = capped(*(rows * units), HalfSpace.from_modulus(t, hardness=0.6 * t), level=0.3 * s)
    np.testing.assert_allclose(
        [other.approach / s, other.force / (t * s * s), other.saturated],
        [one.approach, one.force, one.saturated],
    )


def test_rows_without_contact_or_solution():
    body = HalfSpace.from_modulus(1.0, hardness=0.1)
    found = capped([0.0, -1.0, np.nan, 0.5], [0.0, 0.0, np.nan, 1.0], [0, 0, 1, 1.2],
                   [0, 0, 1, np.nan], body)  # fmt: skip
    np.testing.assert_array_equal(found.force, [0, 0, np.nan, np.nan])
    elastic_body = capped([0.5], [1.0], [1.2], [np.nan], body.elastic)
    assert elastic_body.force[0] == 1.0
