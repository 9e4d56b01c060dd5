"""The stress table: what is fast of it has no failure, and a failure is shown as one."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

from asperity import bem_solve
from asperity.cli.main import main
from asperity.errors import InputError
from asperity.stress.case import Case
from asperity.stress.closed_forms import (
    elliptic_contact,
    free_displacement,
    periodic_displacement,
    power_law_contact,
    wave_contact,
)
from asperity.stress.judges import Question, alike, certificate, certified
from asperity.stress.maps import rough
from asperity.stress.table import FAILURE, REFUSED, RIGHT, cases, run, summary

THEMES = [
    "powers of a tip",
    "aspect ratios",
    "moduli",
    "lengths",
    "loads",
    "slopes",
    "same surface",
    "offset of heights",
    "Poisson ratios",
    "grading",
    "grids",
    "no answer",
]
"""Themes that take a few seconds each."""


@pytest.mark.parametrize("theme", THEMES)
def test_every_case_of_a_theme_is_right_or_refused(theme):
    chosen = [replace(case, seconds=60.0) for case in cases(theme)]
    rows = list(run(chosen))
    assert len(rows) == len(chosen) >= 10
    assert [row for row in rows if row.outcome == FAILURE] == []
    assert all(row.reason for row in rows if row.outcome == REFUSED)


def test_there_are_many_cases_of_all_engines():
    every = cases()
    assert len(every) >= 300
    assert len({(case.theme, case.name, case.engine, case.against) for case in every}) == len(every)
    for engine in ("law auto", "model", "boundary elements", "solve", "solve, anchored"):
        assert sum(case.engine == engine for case in every) >= 30, engine


def _wrong() -> float:
    return 1.5


def _no_number() -> float:
    return float("nan")


def _refused() -> float:
    raise InputError("there is none")


def _broken() -> float:
    raise ZeroDivisionError("by zero")


def _leaking() -> float:
    warnings.warn("overflow", RuntimeWarning, stacklevel=1)
    return 0.5


@pytest.mark.parametrize(
    ("judge", "outcome", "reason"),
    [
        (lambda: 0.5, RIGHT, ""),
        (_refused, REFUSED, "there is none"),
        (_wrong, FAILURE, "wrong without a word"),
        (_no_number, FAILURE, "no number"),
        (_broken, FAILURE, "ZeroDivisionError"),
        (_leaking, FAILURE, "RuntimeWarning: overflow"),
    ],
)
def test_outcomes(judge, outcome, reason):
    row = next(run([Case("theme", "name", "engine", "judge", judge)]))
    assert row.outcome == outcome and reason in row.reason


def test_an_answer_where_there_is_none_and_one_that_is_late_fail():
    late = Case("theme", "name", "engine", "judge", lambda: 0.5, seconds=0.0)
    wrong = Case("theme", "name", "engine", "judge", lambda: 0.5, must_refuse=True)
    assert [row.outcome for row in run([late, wrong])] == [FAILURE, FAILURE]
    assert summary(run([late, wrong]))[1][:6] == ("theme", "engine", "2", "0", "0", "0")


def test_closed_forms():
    """Against each other: a sphere, a cone, an ellipse that is round, a wave of no load."""
    assert power_law_contact(2.0, 0.5, 0.01, 1.0) == pytest.approx(elliptic_contact(1.0, 0.01, 1.0))
    assert elliptic_contact(1.001, 0.01, 1.0) == pytest.approx(
        elliptic_contact(1.0, 0.01, 1.0), rel=1e-3
    )
    force, area = power_law_contact(1.0, 1.0, 0.01, 1.0)  # Sneddon: F = 2 E* d a / pi ... a = 2d/pi
    radius = 2 * 0.01 / np.pi
    assert (force, area) == pytest.approx((0.01 * radius, np.pi * radius**2))
    fraction, gap = wave_contact(np.array([1e-12, 1.0]))
    assert fraction == pytest.approx([0.0, 1.0], abs=1e-6)
    assert gap == pytest.approx([1.0, 0.0], abs=1e-6)


def test_displacements_of_a_wave_and_of_a_pixel():
    x = 2 * np.pi * np.arange(32) / 32
    wave = np.tile(np.cos(3 * x), (8, 1))
    moved = periodic_displacement(wave, (0.5, 0.5), 2.0, 0.0)
    assert moved == pytest.approx(2.0 / (2.0 * 3 * 2 * np.pi / 16.0) * wave, abs=1e-12)
    pixel = np.zeros((5, 7))
    pixel[2, 3] = 1.0
    moved = free_displacement(pixel, (1.0, 1.0), 1.0)  # Love: in the middle of a square of side 1
    assert moved[2, 3] == pytest.approx(4.0 * np.log(1.0 + np.sqrt(2.0)) / np.pi)
    assert moved[0, 0] == pytest.approx(1.0 / (np.pi * np.hypot(2, 3)), rel=0.01)


def test_the_judges_notice():
    """A pressure that is wrong by a tenth of its mean, and a question in another unit."""
    question = Question.of(rough())
    load = float(question.pressures[2])
    found = bem_solve(question.hm, question.material, pressure=load)
    assert certificate(found, question, load) < 1.1e-6 and certified(question) < 1.1
    pressure = found.pressure.copy()
    pressure[found.contact] += 0.1 * load * np.cos(np.arange(found.contact.sum()))
    assert certificate(replace(found, pressure=np.abs(pressure)), question, load) > 1e-5
    other = Question.of(rough(pixel=1e-3))
    assert alike("boundary elements", question, other, length=1e3) < 1.0
    assert alike("boundary elements", question, other, length=1.01e3) > 1.0


def test_the_command(tmp_path, capsys):
    table = tmp_path / "rows.csv"
    assert main(["stress", "--theme", "Poisson ratios", "--output", str(table)]) == 0
    assert "30 cases, 0 failures" in capsys.readouterr().out
    assert len(table.read_text().splitlines()) == 31
    assert main(["stress", "--theme", "weather"]) == 2
    assert "there are powers of a tip" in capsys.readouterr().err
