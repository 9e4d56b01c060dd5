"""The stated error: it grows with each weakness, and true errors of other surfaces lie inside."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
from asperity.error_estimate import AREA_WEIGHTS, LOAD_WEIGHTS, TERMS, estimate
from asperity.loadpoints import default_pressures
from surfaces import self_affine


@pytest.mark.parametrize("weights", [LOAD_WEIGHTS, AREA_WEIGHTS])
def test_every_weakness_only_adds(weights):
    assert len(weights) == len(TERMS)
    assert min(weights) >= 0
    calm = dict.fromkeys(TERMS, 0.1)
    for name in TERMS:
        assert estimate({**calm, name: 0.2}, weights) >= estimate(calm, weights)


def test_true_errors_lie_inside_the_statement_on_surfaces_it_was_not_fitted_on():
    inside, stated = [], []
    for seed in (101, 102, 103):
        hm = self_affine(
            (144, 192),
            (1.44e-3, 1.92e-3),
            hurst=0.8,
            rms_slope=0.1,
            rolloff=4e-4,
            cutoff=8e-5,
            seed=seed,
        )
        steel = asperity.HalfSpace(210e9, 0.3)
        loads = default_pressures(hm, steel, count=4)
        reference = asperity.bem_curve(hm, steel, pressures=loads)
        model = asperity.contact_curve(hm, steel, separations=reference.separation)
        error = np.abs(model.mean_pressure / reference.mean_pressure - 1)
        inside += (error <= model.error_estimate).tolist()
        stated += model.error_estimate.tolist()
    assert np.mean(inside) >= 0.8
    assert max(stated) < 0.15
