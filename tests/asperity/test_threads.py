"""Runs in threads and in forked processes."""

from __future__ import annotations

import multiprocessing
import sys
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

import asperity
from asperity.errors import AsperityError
from surfaces import HeightMap

BODY = asperity.HalfSpace.from_modulus(1e11)


def load(model: str) -> float:
    """Load [N] of one hill by a model, at a fixed separation."""
    y, x = np.mgrid[:12, :16]
    heights = 1e-8 * (np.cos(2 * np.pi * y / 12) + np.cos(2 * np.pi * x / 16))
    hm = HeightMap(heights, (1e-6, 1.5e-6), periodic=True)
    solve = asperity.bem_curve if model == "bem" else asperity.contact_curve
    return float(solve(hm, BODY, separations=[1e-8]).load[0])


@pytest.mark.skipif(sys.platform != "linux", reason="GNU OpenMP is that of Linux")
def test_a_process_forked_after_boundary_elements_ran_refuses_them_and_runs_the_model():
    """GNU OpenMP ends such a process, and a `multiprocessing.Pool` waits for it forever."""
    here = load("bem"), load("asperity")
    assert here[0] > 0
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("fork")) as pool:
        assert pool.submit(load, "asperity").result(timeout=60) == here[1]
        with pytest.raises(AsperityError, match="spawn"):
            pool.submit(load, "bem").result(timeout=60)
