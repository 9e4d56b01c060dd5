"""The misfit of the model on parts of a map: how many are solved, and what they leave open."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from strategies import broad

import asperity
from asperity.engine import part_misfit
from asperity.engine.parts import _load_shares
from asperity.halfspace.scene import default_pressures

BODY = asperity.HalfSpace.from_modulus(1.0)


class Counted:
    """In place of `PartMisfit`: one misfit on all parts, and how many loads were solved on each."""

    def __init__(self, misfit=0.0):
        self.solved = []
        self.misfit = misfit

    def __call__(self, part, plan, pressures, **told):
        self.solved.append(len(pressures))
        return np.array([*np.full((4, len(pressures)), self.misfit), pressures * np.nan])


def test_no_part_is_solved_at_a_load_whose_bound_would_be_too_wide():
    """One part carries the lightest load: how few there are tells that before any is solved; it is
    told otherwise meanwhile."""
    hm = broad((512, 512))
    loads = default_pressures(hm, BODY, 4)
    plan = asperity.make_plan(hm, BODY, pressures=loads)
    run = asperity.solve_contacts(hm, BODY, plan, pressures=loads)
    shares = _load_shares(run, 4)
    larger, found = part_misfit._on_floor(part_misfit._fewer(shares)), {}
    floor = np.outer(part_misfit.PARTS.floor, larger)
    assert (floor[:, 0] > floor[:, -1]).all()
    between = 0.5 * (floor[:, :1] + floor[:, -1:]) / part_misfit.PARTS.enough
    scene = hm, plan, run.curve, np.arange(4), shares, between
    asked: list[np.ndarray] = []
    for otherwise in (asked.append, None):
        judged = Counted()
        bounds = part_misfit.misfit_on_parts(judged, *scene, otherwise)[1]
        found[otherwise is None] = sum(judged.solved)
        untold = np.isnan(bounds).all(axis=0)
        assert untold[0] == (otherwise is not None)
        assert not untold[-1]
        assert otherwise is None or np.array_equal(asked, [untold])
    assert found[False] < found[True]


@pytest.mark.parametrize("allowed, solved", [(1.3, 5), (1.0, 8)])
def test_no_more_parts_are_solved_than_the_bounds_need(allowed, solved, monkeypatch):
    """Of 64 that carry alike five, with bounds near the floor, and no more than eight."""
    monkeypatch.setattr(part_misfit, "PARTS", replace(part_misfit.PARTS, long_waves=1.0))
    hm = broad((512, 512))
    loads = default_pressures(hm, BODY, 4)
    plan = asperity.make_plan(hm, BODY, pressures=loads, scales="all")
    run = asperity.solve_contacts(hm, BODY, plan, pressures=loads)
    shares, floor = np.full((64, 4), 1 / 64), np.array(part_misfit.PARTS.floor)[:, None]
    judged = Counted()
    scene = hm, plan, run.curve, np.arange(4), shares, allowed * floor, None
    bounds = part_misfit.misfit_on_parts(judged, *scene)[1]
    assert judged.solved == [4] * solved
    np.testing.assert_allclose(bounds, floor * np.sqrt(0.5 + 2.0 / solved) * np.ones(4))
    # where the model has no answer on any part, each is tried once
    silent = Counted(np.nan)
    assert np.isnan(part_misfit.misfit_on_parts(silent, *scene)[1]).all()
    assert silent.solved == [4] * 8


@pytest.mark.parametrize("solved, least", [(8, 0.88), (16, 0.9), (48, 0.9), (64, 1.0)])
def test_the_bound_holds_the_mean_over_all_parts(solved, least):
    """Of 64 parts of random misfits and shares some are solved, in 1000 draws."""
    rng = np.random.default_rng(5)
    shares = rng.lognormal(0.0, 0.5, (64, 1000))
    shares /= shares.sum(axis=0)
    found = rng.normal(0.0, 0.1, (64, 1000, 4))
    whole = (shares[..., None] * found).sum(axis=0).T[:2]
    found[solved:] = np.nan
    mean, bounds, _ = part_misfit._pooled(found, shares, np.ones(1000), np.zeros((2, 1000)))
    held = np.abs(mean[:2] - whole) <= bounds + 1e-12
    assert least <= held.mean() <= max(least, 0.99)


def test_two_parts_that_carry_all_of_the_load_do_not_know_the_whole():
    """They were cut out: misfits 0.17 apart, the whole 0.13 from their mean, 0.07 stated."""
    shares, found = np.zeros((16, 1)), np.full((16, 1, 4), np.nan)
    shares[:2, 0], found[:2, 0] = (0.61, 0.39), np.array([[0.05], [0.22]])
    floor = np.array(part_misfit.PARTS.floor)[:, None]
    _, bounds, number = part_misfit._pooled(found, shares, np.ones(1), floor)
    assert number == 2 and bounds[1] > 0.14


def test_fine_waves_that_change_much_of_the_load_leave_more_open():
    """Where the long ones are solved alone, a tenth of that."""
    hm = broad((512, 512))
    loads = default_pressures(hm, BODY, 4)
    plan = asperity.make_plan(hm, BODY, pressures=loads)
    run = asperity.solve_contacts(hm, BODY, plan, pressures=loads)
    model, shares = run.curve, np.full((16, 4), 1 / 16)
    lower = 0.5 * model.mean_pressure / model.stiffness  # half of the load

    def judged(part, plan, pressures, **told):
        found = np.zeros((5, len(pressures)))
        found[-1] = (model.separation - lower)[-len(pressures) :]
        return found

    scene = hm, plan, model, np.arange(4), shares, np.ones((2, 1)), None
    assert part_misfit.long_waves(hm, plan, 4) is not None
    bounds = part_misfit.misfit_on_parts(judged, *scene)[1]
    load, area = part_misfit.PARTS.floor
    of_three = np.sqrt(0.5 + 0.5 * (4.0 / 3.0) ** 2)
    np.testing.assert_allclose(bounds.T / of_three, [[np.hypot(load, 0.05), area]] * 4)
