"""What a worker does: jobs one after the other, each to its results file."""

from __future__ import annotations

import math
import threading
import time
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import surfaces
from asperity.errors import AsperityError, ContactWarning
from asperity.results.headline import at_heaviest
from asperity.results.storage import ResultFile, read_about, write_results
from asperity.threads import set_threads

from .jobs import Job, method

__all__ = ["Outcome", "failure", "finished", "run_jobs"]

Outcome = Mapping[str, Any]
"""What the index tells of a job that was run: ``state``, ``reason`` and numbers."""

_one_at_a_time = threading.Lock()


def run_jobs(jobs: Sequence[Job], folder: Path, threads: int, force: bool) -> list[Outcome]:
    """Run jobs in this process; what has its results file already is read from there.

    Parameters
    ----------
    jobs
        Jobs, run in turn. A process runs one at a time.
    folder
        Folder of the results files.
    threads
        Threads of each job. The number changes the order of some sums, and so the last digits.
    force
        Whether finished jobs are run again.
    """
    with _one_at_a_time, warnings.catch_warnings():
        warnings.simplefilter("ignore", ContactWarning)  # results hold them
        set_threads(threads)
        try:
            return [(not force and finished(job, folder)) or _run(job, folder) for job in jobs]
        finally:
            set_threads(None)


def finished(job: Job, folder: Path) -> Outcome | None:
    """What an earlier run found, None if it did not finish the job."""
    try:
        found = read_about(folder / job.file)
    except AsperityError:
        return None
    return found["outcome"] if found.get("job") == job.digest else None


def failure(error: BaseException) -> Outcome:
    """Outcome of a job without a result."""
    return {"state": "failed", "reason": " ".join(str(error).split()) or type(error).__name__}


def _run(job: Job, folder: Path) -> Outcome:
    """Solve one job and write its results file."""
    begun = time.perf_counter()
    settings = dict(job.settings)
    solve, preparation = method(settings.pop("method")), settings.pop("prepare", None)
    try:
        hm = job.surface.load()
        if preparation is not None:
            hm = surfaces.prepare(hm, **preparation)
        if "loads" in settings:
            settings["pressures"] = settings.pop("loads") / math.prod(hm.size)
        curve = solve(hm, job.material, **settings)
        outcome = _outcome(at_heaviest(curve), curve.settings)
        outcome["seconds"] = time.perf_counter() - begun
        content = ResultFile(
            curves={curve.model: curve.to_record()},
            about={"job": job.digest, "surface": job.surface.name, "outcome": outcome},
        )
        write_results(folder / job.file, content)
    except (AsperityError, MemoryError) as error:
        return failure(error)
    return outcome


def _outcome(found: dict[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
    """What the index tells of a curve, as plain numbers and texts."""
    state = "done" if found.pop("converged") else "not converged"
    rough = {name: settings["map"][name] for name in ("rms_height", "rms_slope")}
    numbers = {
        name: value if isinstance(value, str) else float(value) for name, value in found.items()
    }
    return {"state": state, **numbers, **rough, "warnings": float(len(settings["warnings"]))}
