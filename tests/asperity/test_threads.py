"""Runs in threads and in forked processes."""

from __future__ import annotations

import multiprocessing
import pickle
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import asperity
from asperity.model.decomposition import Decomposition
from surfaces import HeightMap, self_affine

BODY = asperity.HalfSpace.from_modulus(1e11)


def load(model: str) -> float:
    """Load [N] of one hill by a model, at a fixed separation."""
    y, x = np.mgrid[:640, :512]
    heights = 1e-8 * (np.cos(2 * np.pi * y / 640) + np.cos(2 * np.pi * x / 512))
    hm = HeightMap(heights, (1e-6, 1.5e-6), periodic=True)
    solve = asperity.bem_curve if model == "bem" else asperity.contact_curve
    return float(solve(hm, BODY, separations=[1e-8]).load[0])


@pytest.mark.skipif(sys.platform != "linux", reason="processes are forked on Linux only")
@pytest.mark.parametrize("model", ["bem", "asperity"])
def test_a_process_forked_after_a_run_on_threads_gives_the_same_load(model):
    """The threads are not there after the fork; a `multiprocessing.Pool` must not wait for them."""
    here = load(model)
    assert here > 0
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("fork")) as pool:
        assert pool.submit(load, model).result(timeout=60) == here


def test_threads_that_solve_one_population_find_what_one_finds():
    """Each makes the laws that it lacks, in the tables that all read."""
    hm = self_affine((150, 170), (1.5e-4, 1.7e-4), hurst=0.8, rms_slope=0.1, cutoff=5e-6, seed=1)
    plan = asperity.make_plan(hm, BODY, pressures=[1e9])
    population, loads = Decomposition.of(hm, BODY, plan).population, [1e9, 5e7, 5e8, 1e9, 5e7, 5e8]
    alone = pickle.loads(pickle.dumps(population))
    with ThreadPoolExecutor(len(loads)) as pool:
        together = list(pool.map(lambda load: population.solve(pressure=load), loads))
    for load, found in zip(loads, together, strict=True):
        expected = alone.solve(pressure=load)
        assert found.separation == pytest.approx(expected.separation, rel=1e-9)
        assert found.contact_area == pytest.approx(expected.contact_area, rel=1e-9)
