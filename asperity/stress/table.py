"""Run stress cases one after the other, and tell how each ended."""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from asperity.compilation import CURVE, HARD, compile_ahead
from asperity.errors import AsperityError, ContactWarning

from .case import Case
from .conditioning import conditioning_cases
from .contacts import contact_cases
from .judges import Doubted
from .refusals import refusal_cases
from .rough_maps import map_cases

__all__ = ["FAILURE", "Row", "cases", "run", "summary"]

OUTCOMES = RIGHT, REFUSED, WARNED, FAILURE = "right", "refused", "warned", "FAILURE"


@dataclass(frozen=True)
class Row:
    """How one case ended.

    The outcome is "right"; "refused"; "warned": farther off than it states, for a reason that the
    engine warns of; or "FAILURE". The error over the allowance is what the judge gives, NaN of a
    refusal; the reason says why it was refused, or what is wrong, else "".
    """

    theme: str
    case: str
    engine: str
    against: str
    outcome: str
    error_over_allowance: float
    seconds: float
    reason: str


def cases(theme: str | None = None) -> list[Case]:
    """All stress cases, or those of one theme."""
    every = (*contact_cases(), *map_cases(), *conditioning_cases(), *refusal_cases())
    return [case for case in every if theme in (None, case.theme)]


def run(chosen: Iterable[Case]) -> Iterator[Row]:
    """Rows of some cases, in their order; loops are compiled before the first."""
    compile_ahead(*CURVE, *HARD, "bem")
    return map(_row, chosen)


def _row(case: Case) -> Row:
    begun = time.perf_counter()
    ratio, reason, outcome = float("nan"), "", FAILURE
    with warnings.catch_warnings(record=True) as leaked:
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", ContactWarning)
        try:
            ratio = float(case.judge())
        except Doubted as error:
            outcome, reason = WARNED, str(error)
        except AsperityError as error:
            outcome, reason = REFUSED, " ".join(str(error).split())
        except Exception as error:  # whatever else an engine raises is what the table looks for
            reason = f"{type(error).__name__}: {error}"
    seconds = time.perf_counter() - begun
    if reason == "" and ratio != ratio:
        reason = "no number"
    elif reason == "":
        outcome = RIGHT
        if case.must_refuse:
            outcome, reason = FAILURE, "an answer where there is none"
        elif not ratio <= 1.0:
            outcome, reason = FAILURE, "wrong without a word"
    if leaked:
        outcome, reason = FAILURE, f"{leaked[0].category.__name__}: {leaked[0].message}"
    if seconds > case.seconds:
        outcome, reason = FAILURE, f"more than {case.seconds:g} s"
    told = case.theme, case.name, case.engine, case.against
    return Row(*told, outcome, ratio, seconds, reason)


def summary(rows: Iterable[Row]) -> list[tuple[str, ...]]:
    """Heading and rows of the table by theme and engine: counts, worst error, longest time."""
    groups: dict[str, dict[str, list[Row]]] = {}
    for row in rows:
        engine = "laws" if row.engine.startswith("law ") else row.engine
        groups.setdefault(row.theme, {}).setdefault(engine, []).append(row)
    head = "theme", "engine", "cases", *OUTCOMES, "worst error/allowed", "longest [s]"
    return [
        head,
        *(
            _counted(theme, engine, found)
            for theme, engines in groups.items()
            for engine, found in engines.items()
        ),
    ]


def _counted(theme: str, engine: str, rows: list[Row]) -> tuple[str, ...]:
    counts = (str(sum(row.outcome == outcome for row in rows)) for outcome in OUTCOMES)
    ratios = [row.error_over_allowance for row in rows if row.outcome == RIGHT]
    worst = f"{max(ratios):.2g}" if ratios else ""
    longest = max(row.seconds for row in rows)
    return theme, engine, str(len(rows)), *counts, worst, f"{longest:.1f}"
