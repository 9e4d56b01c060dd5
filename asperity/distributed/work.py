"""What a worker does: jobs one after the other, each to its results file."""

from __future__ import annotations

import functools
import threading
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import surfaces
from asperity.errors import AsperityError, ContactWarning
from asperity.results.curve import ContactCurve, at_heaviest
from asperity.results.storage import ResultFile, read_about, write_results
from surfaces.heightmap import HeightMap
from surfaces.numerics.memory import set_memory
from surfaces.numerics.parallel import set_threads

from .bands import QUANTITIES
from .jobs import Job, Surface, method

__all__ = ["JobResult", "failure", "finished", "prepared", "run_jobs"]

JobResult = Mapping[str, Any]
"""What the index tells of a job that was run: ``state``, ``reason`` and numbers."""

_one_at_a_time = threading.Lock()


def run_jobs(
    jobs: Sequence[Job], folder: Path, threads: int, force: bool, columns: bool = False
) -> list[JobResult]:
    """Run jobs in this process, in turn; what has its results file in the folder already is read
    from there, unless by `force` it is run again.

    The number of threads of each job changes the order of some sums, and so the last digits. With
    `columns` the result holds the ``values`` of the curve at its load points, too.
    """
    with _one_at_a_time, warnings.catch_warnings():
        warnings.simplefilter("ignore", ContactWarning)  # results hold them
        set_threads(threads)
        try:
            # the jobs of one surface share its map
            load = functools.lru_cache(maxsize=1)(lambda surface: surface.load())
            return [
                (not force and finished(job, folder, columns)) or _run(job, folder, columns, load)
                for job in jobs
            ]
        finally:
            set_threads(None)
            set_memory(None)  # which the loading of a map may have set


def finished(job: Job, folder: Path, columns: bool = False) -> JobResult | None:
    """What an earlier run found, None if it did not finish the job."""
    path = folder / job.file
    try:
        found = read_about(path)
        if found.get("job") != job.digest:
            return None
        result: dict[str, Any] = found["outcome"]
        return result | _values(ContactCurve.from_hdf5(path)) if columns else result
    except AsperityError:
        return None


def prepared(hm: HeightMap, job: Job) -> HeightMap:
    """The map of a job, prepared as its settings ask."""
    preparation = job.settings.get("prepare")
    return hm if preparation is None else surfaces.prepare(hm, **preparation)


def failure(error: BaseException) -> JobResult:
    """Result of a job that has no curve."""
    return {"state": "failed", "reason": " ".join(str(error).split()) or type(error).__name__}


def _run(job: Job, folder: Path, columns: bool, load: Callable[[Surface], HeightMap]) -> JobResult:
    """Solve one job and write its results file."""
    begun = time.perf_counter()
    settings = {k: v for k, v in job.settings.items() if k not in ("method", "prepare")}
    try:
        hm = prepared(load(job.surface), job)
        if "loads" in settings:
            settings["pressures"] = np.asarray(settings.pop("loads"), float) / hm.area
        curve = method(job.settings["method"])(hm, job.material, **settings)
        result = _result(at_heaviest(curve), curve.settings)
        result["seconds"] = time.perf_counter() - begun
        content = ResultFile(
            curves={curve.model: curve},
            about={"job": job.digest, "surface": job.surface.name, "outcome": result},
        )
        write_results(folder / job.file, content)
        return result | _values(curve) if columns else result
    except (AsperityError, MemoryError) as error:
        return failure(error)


def _values(curve: ContactCurve) -> dict[str, Any]:
    """Columns of a curve, NaN where a point did not converge."""
    return {"values": {name: getattr(curve, name) for name in QUANTITIES}}


def _result(found: dict[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
    """What the index tells of a curve, as plain numbers and texts."""
    state = "done" if found.pop("converged") else "not converged"
    rough = {name: settings["map"][name] for name in ("rms_height", "rms_slope")}
    numbers = {
        name: value if isinstance(value, str) else float(value) for name, value in found.items()
    }
    return {"state": state, **numbers, **rough, "warnings": float(len(settings["warnings"]))}
