"""Resumable runs: every finished load point is kept in the results file."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from asperity.errors import InputError
from surfaces.arrays import Array

from .curve import ContactCurve, read_results
from .storage import ResultFile, write_results

__all__ = ["Solve", "require_continuable", "run_resumably", "with_held"]

Solve = Callable[[Array, Callable[[ContactCurve], None], dict[str, Array]], ContactCurve]
"""Solves the given load points and calls back with the curve of the points finished so far; it may
keep arrays in the dict, with which it goes on where it was interrupted."""

_PATH = "path, "
"""Head of the names of such arrays in the results file."""

SECONDS_BETWEEN_WRITES = 1.0
"""Least time between two writes of the results file."""


def run_resumably(
    solve: Solve,
    values: Array,
    kind: str,
    path: str | os.PathLike[str],
    *,
    model: str,
    request: Mapping[str, Any],
    resume: bool,
    chained: bool = False,
) -> ContactCurve:
    """Solve load points, keeping every finished one in the results file, beside those it held.

    The `values`, shape (n,), are of the `kind` "pressure" or "separation"; `model` is the name of
    the curve in the file, and `request` holds the JSON-able facts that two runs must share for one
    to continue the other.

    With `resume` it continues from the file, if that exists, and refuses one of another request.
    Where the solution of a point depends on those solved before it (`chained`) and one is missing,
    all are solved again, those of the file too, so that the curve is that of a run without
    interruption. Returned are all points in the order of `values`.
    """
    done, asked, count = None, f"asked_{kind}", len(values)
    paths: dict[str, Array] = {}
    if resume and Path(path).exists():
        before = require_continuable(path, request)
        tables = before.tables.items()
        paths = {name.removeprefix(_PATH): t for name, t in tables if name.startswith(_PATH)}
        if chained:
            values = with_held(values, kind, before.curves.values())
        curve = before.curves.get(model)
        if curve is not None:
            known = curve.converged.any() and asked in curve.extra
            done = curve.select(curve.converged) if known else None
    held = np.zeros((len(values), 1), bool)
    if done is not None:
        held = np.isclose(values[:, None], done.extra[asked], rtol=1e-12, atol=0.0)
    new, place = ~held.any(axis=1), held.argmax(axis=1)
    again = np.empty(0)  # load points of the file that are solved anew
    if chained and new.any():
        again, done, new = values[~new], None, np.ones_like(new)
    earlier, next_write = done, time.monotonic() + SECONDS_BETWEEN_WRITES

    def with_earlier(fresh: ContactCurve) -> ContactCurve:
        return fresh if earlier is None else earlier.joined(fresh)

    def write(curve: ContactCurve) -> None:
        about = {"request": dict(request)}
        tables = {_PATH + name: array for name, array in paths.items()}
        write_results(path, ResultFile({curve.model: curve}, tables=tables, about=about))

    def keep(fresh: ContactCurve) -> None:
        nonlocal next_write
        lost = np.setdiff1d(again, fresh.extra[asked])
        if time.monotonic() >= next_write and not lost.size:
            write(with_earlier(fresh))
            next_write = time.monotonic() + SECONDS_BETWEEN_WRITES

    if done is None or new.any():
        done = with_earlier(solve(values[new], keep, paths))
        paths.clear()
        more = np.count_nonzero(new)
        place[new] = len(done) - more + np.arange(more)
    # a load asked for twice may be held twice: it is in the file as often as it is asked for
    others = np.setdiff1d(np.arange(len(done)), [*place, *np.flatnonzero(held.any(axis=0))])
    write(done.select(np.append(place, others)))
    return done.select(place[:count])


def with_held(values: Array, kind: str, curves: Iterable[ContactCurve]) -> Array:
    """Load points, shape (n,), followed by the others at which curves converged."""
    asked = f"asked_{kind}"
    held = [each.extra[asked][each.converged] for each in curves if asked in each.extra]
    others = np.unique(np.concatenate([*held, np.empty(0)]))
    known = np.isclose(others[:, None], values, rtol=1e-12, atol=0.0).any(axis=1)
    return np.append(values, others[~known])


def require_continuable(
    path: str | os.PathLike[str], request: Mapping[str, Any]
) -> ResultFile[ContactCurve]:
    """What the results file of an earlier run of the same request holds; refused if it is no
    results file, or of another request."""
    held = read_results(path)
    before = held.about.get("request", {})
    changed = [key for key in {**before, **request} if before.get(key) != request.get(key)]
    if changed:
        raise InputError(
            f"{path} cannot be continued: {', '.join(changed)} changed; give another -o or leave "
            "out --resume"
        )
    return held
