"""Runs in threads and in forked processes."""

from __future__ import annotations

import multiprocessing
import sys
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

import asperity
from surfaces import HeightMap

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
