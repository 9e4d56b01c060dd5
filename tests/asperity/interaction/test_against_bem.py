"""The coupled sum against boundary elements: two spheres, and a rough map to 45 % contact."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import HertzTable

import asperity
import surfaces
from asperity.halfspace.material import HalfSpace
from asperity.interaction.population import Population
from asperity.model.decomposition import Decomposition
from asperity.model.plan import make_plan


@pytest.mark.parametrize("m", [0.0, 0.3])
@pytest.mark.parametrize("distance", [2.3, 4.0])
def test_two_spheres(distance, m):
    """Nearly touching and apart: load within 0.7 %, on cells that are not square."""
    n, radius, depth = (96, 160), 60.0, 0.6
    material = HalfSpace.from_modulus(1.0, m)
    a = np.sqrt((1 + m) * radius * depth)
    dy, dx = 8 * a / n[0], 10 * a / n[1]
    y = (np.arange(n[0]) - n[0] / 2 + 0.5)[:, None] * dy
    x = (np.arange(n[1]) - n[1] / 2 + 0.5)[None, :] * dx
    places = np.array([-0.5, 0.5]) * distance * a
    heights = np.max([-(y**2 + (x - c) ** 2) / (2 * radius) for c in places], axis=0)
    hm = surfaces.HeightMap(heights, (dy, dx))
    mean = float(heights.mean())
    exact = asperity.bem_solve(hm, material, separation=-mean - depth, boundary="free")
    population = Population(
        x=places, y=np.zeros(2), height=np.full(2, -mean),
        table=HertzTable(np.full(2, radius), np.full(2, 10.0), 1.0, m),
        cell=hm.size, boundary="free", material=material,
    )  # fmt: skip
    state = population.solve(separation=-mean - depth, tolerance=1e-6)
    assert state.converged
    load = state.mean_pressure * population.nominal_area
    assert load == pytest.approx(exact.load, rel=7e-3)


def test_every_separation_to_half_contact_converges():
    """A self-affine map, cut off at 4 pixels, from first touch to 45 % contact."""
    hm = surfaces.self_affine(
        (192, 256), (1.92e-4, 2.56e-4), hurst=0.8, rms_slope=0.1, rolloff=4e-5, cutoff=4e-6, seed=3
    )
    material = HalfSpace(70e9, 0.3)
    decomposition = Decomposition.of(hm, material, make_plan(hm, material))
    state, area = None, []
    top, width = decomposition.population.height.max(), hm.rms_height
    for separation in np.arange(top, -2.5 * width, -0.2 * width):
        state = decomposition.population.solve(separation=float(separation), state=state)
        if state.contact_area > 0.45 * hm.area:
            break
        assert state.converged and state.residual <= 2e-3, state.reason
        area.append(state.contact_area / hm.area)
    assert area[-1] > 0.3
    assert (np.diff(area) >= 0).all()


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.3])
def test_a_rough_graded_map(m):
    """Load at equal separation within 3 %, area at equal load within 6 %, at a few % contact."""
    hm = surfaces.self_affine(
        (160, 128), (160.0, 128.0), hurst=0.8, rms_slope=0.1, rolloff=32.0, cutoff=8.0, seed=5
    )
    material = HalfSpace.from_modulus(1.0, m)
    pressure = 2e-3 * 8.0**m
    exact = asperity.bem_solve(hm, material, pressure=pressure, tolerance=1e-5)
    ours = asperity.contact_curve(hm, material, separations=exact.separation)
    same = asperity.contact_curve(hm, material, pressures=pressure)
    assert ours.converged.all() and same.converged.all()
    assert ours.mean_pressure[0] == pytest.approx(pressure, rel=0.03)
    assert same.area_fraction[0] == pytest.approx(exact.area_fraction, rel=0.06)
