"""Interrupted runs: finished points are kept, and only the others are solved again."""

from __future__ import annotations

import numpy as np
import pytest

import asperity.results.resume
from asperity.errors import InputError
from asperity.results.curve import ContactCurve, read_results
from asperity.results.resume import run_resumably

REQUEST = {"input": "abc", "law": "paper"}
LOADS = np.array([3.0, 1.0, 2.0, 5.0])
MISS = 3e-4
"""A solved pressure misses the one asked for by this."""


def curve_of(pressure: np.ndarray) -> ContactCurve:
    zeros = np.zeros(len(pressure))
    return ContactCurve(
        separation=-np.log(pressure),
        mean_pressure=pressure * (1 + MISS),
        load=zeros,
        area_fraction=pressure / 10,
        contact_area=zeros,
        contacts=zeros.astype(np.int64),
        stiffness=zeros,
        converged=pressure != 5.0,
        residual=zeros,
        error_estimate=zeros,
        model="bem",
        seconds={"loads": 1.0},
        extra={"asked_pressure": pressure, "iterations": pressure},
        reasons=tuple("stopped" if p == 5.0 else "" for p in pressure),
    )


class Solver:
    """Finishes light loads first and can be interrupted after some of them."""

    def __init__(self, fails_after: int = 99) -> None:
        self.fails_after, self.solved = fails_after, []

    def __call__(self, values, keep, paths):
        for count, p in enumerate(np.sort(values), start=1):
            self.solved.append(float(p))
            keep(curve_of(np.sort(values)[:count]))
            if count == self.fails_after:
                raise KeyboardInterrupt
        return curve_of(values)


def run_all(solver, path, *, resume, request=REQUEST, loads=LOADS):
    return run_resumably(
        solver, loads, "pressure", path, model="bem", request=request, resume=resume
    )


@pytest.fixture(autouse=True)
def write_at_once(monkeypatch):
    monkeypatch.setattr(asperity.results.resume, "SECONDS_BETWEEN_WRITES", 0.0)


def test_an_interrupted_run_goes_on_where_it_stopped(tmp_path):
    path = tmp_path / "r.h5"
    with pytest.raises(KeyboardInterrupt):
        run_all(Solver(2), path, resume=False)
    again = Solver()
    whole = run_all(again, path, resume=True)
    assert again.solved == [3.0, 5.0]
    good = whole.converged
    assert np.isnan(whole.mean_pressure[~good]).all() and whole.asked["asked_pressure"][3] == 5.0
    np.testing.assert_allclose(whole.mean_pressure[good], LOADS[good], rtol=2 * MISS)
    np.testing.assert_array_equal(whole.extra["iterations"], LOADS)
    kept = ContactCurve.from_hdf5(path)
    np.testing.assert_array_equal(kept.mean_pressure, whole.mean_pressure)


def test_what_a_solver_keeps_is_given_back_until_its_loads_are_solved(tmp_path):
    given = []

    def solve(values, keep, paths):
        given.append({name: array.tolist() for name, array in paths.items()})
        paths["state 0"] = np.array([0.5, np.nan, 3.0])[: len(values)]
        return Solver(fails_after=5 - len(values))(values, keep, paths)

    path = tmp_path / "r.h5"
    with pytest.raises(KeyboardInterrupt):
        run_all(solve, path, resume=False, loads=LOADS[:3])
    assert list(read_results(path).tables) == ["path, state 0"]
    run_all(Solver(), path, resume=True, loads=LOADS[1:2])  # solved before, as in rounds of anchors
    run_all(solve, path, resume=True, loads=LOADS[:3])
    assert given == [{}, {"state 0": [0.5, pytest.approx(np.nan, nan_ok=True), 3.0]}]
    assert not read_results(path).tables


def test_points_that_did_not_converge_are_solved_again(tmp_path):
    path = tmp_path / "r.h5"
    run_all(Solver(), path, resume=True)
    again = Solver()
    run_all(again, path, resume=True)
    assert again.solved == [5.0]


def test_a_file_of_which_no_point_converged_is_solved_anew(tmp_path):
    for _ in range(2):
        again = Solver()
        run_all(again, tmp_path / "r.h5", resume=True, loads=LOADS[3:])
        assert again.solved == [5.0]


def test_load_points_that_lie_closer_than_a_solve_misses_are_all_solved(tmp_path):
    path = tmp_path / "r.h5"
    dense = np.array([1.0, 1.0 + 0.3 * MISS, 1.0 + 0.6 * MISS])
    for part in (dense[:1], dense):
        again = Solver()
        whole = run_all(again, path, resume=True, loads=part)
    assert again.solved == dense[1:].tolist()
    np.testing.assert_array_equal(whole.extra["asked_pressure"], dense)


def test_points_that_start_from_each_other_are_solved_together(tmp_path):
    for loads, solved in ((LOADS[1:3], [1.0, 2.0]), (LOADS[:3], [1.0, 2.0, 3.0]), (LOADS[:3], [])):
        again = Solver()
        run_resumably(
            again, loads, "pressure", tmp_path / "r.h5", model="bem", request=REQUEST,
            resume=True, chained=True,
        )  # fmt: skip
        assert again.solved == solved


def test_points_that_start_from_each_other_stay_in_the_file(tmp_path):
    """Those that were not asked for again were lost."""
    path = tmp_path / "r.h5"
    for loads in (LOADS[:2], LOADS[2:3]):
        found = run_resumably(
            Solver(), loads, "pressure", path, model="bem", request=REQUEST, resume=True,
            chained=True,
        )  # fmt: skip
        np.testing.assert_array_equal(found.extra["asked_pressure"], loads)
    held = read_results(path).curves["bem"].extra["asked_pressure"]
    np.testing.assert_array_equal(np.sort(held), np.sort(LOADS[:3]))


def test_an_interruption_takes_no_point_out_of_the_file(tmp_path):
    """Where one is missing, all points that start from each other are solved again."""
    path, how = tmp_path / "r.h5", {"model": "bem", "request": REQUEST, "chained": True}
    run_resumably(Solver(), LOADS[:2], "pressure", path, resume=False, **how)
    for count, held in ((1, LOADS[:2]), (2, LOADS[:2]), (3, LOADS[:3])):
        with pytest.raises(KeyboardInterrupt):
            run_resumably(Solver(count), LOADS, "pressure", path, resume=True, **how)
        kept = read_results(path).curves["bem"].extra["asked_pressure"]
        np.testing.assert_array_equal(np.sort(kept), np.sort(held))


def test_points_that_are_not_asked_for_stay_in_the_file(tmp_path):
    """Rounds of anchors ask for few points first, then for more: a run that goes on solves none."""
    path = tmp_path / "r.h5"
    run_all(Solver(), path, resume=True, loads=LOADS[:3])
    for loads in (LOADS[1:2], LOADS[:3]):
        again = Solver()
        assert len(run_all(again, path, resume=True, loads=loads)) == len(loads)
        assert not again.solved


def test_a_load_asked_for_twice_stays_twice_in_the_file(tmp_path):
    path, loads = tmp_path / "r.h5", np.array([3.0, 1.0, 3.0])
    for resume in (False, True, True):
        whole = run_all(Solver(), path, resume=resume, loads=loads)
        np.testing.assert_array_equal(whole.extra["iterations"], loads)
        np.testing.assert_array_equal(read_results(path).curves["bem"].extra["iterations"], loads)


def test_another_input_is_not_continued(tmp_path):
    path = tmp_path / "r.h5"
    run_all(Solver(), path, resume=False)
    with pytest.raises(InputError, match="cannot be continued: law changed"):
        run_all(Solver(), path, request={**REQUEST, "law": "hertz"}, resume=True)


def test_a_body_with_a_hardness_is_not_continued_without(tmp_path):
    """A fact that the new request lacks changed, too."""
    path = tmp_path / "r.h5"
    run_all(Solver(), path, resume=False, request={**REQUEST, "hardness": 3e7})
    with pytest.raises(InputError, match="cannot be continued: hardness changed"):
        run_all(Solver(), path, resume=True)
