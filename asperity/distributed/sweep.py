"""Sweeps: many surfaces, materials and settings, each a job with a results file of its own."""

from __future__ import annotations

import functools
import math
import os
import time
from collections.abc import Generator, Mapping, Sequence
from pathlib import Path
from typing import Any

from asperity.compilation import HARD, compile_ahead
from asperity.halfspace.material import HalfSpace
from asperity.progress import Progress, reported
from surfaces.errors import as_path, as_truth
from surfaces.files.atomic import make_folder

from .index import Sweep, require_own
from .jobs import METHODS, Job, Jobs
from .pool import Workers, opened, run_in_batches
from .work import JobResult, finished, run_jobs

__all__ = ["row_of", "run", "run_sweep", "sweep"]

RESULTS = "results"
"""Folder of the results files, inside that of the sweep."""

SECONDS_BETWEEN_WRITES = 5.0
"""Least time between two writes of the index; writing takes at most a fiftieth of the time."""


def sweep(
    surfaces: Any,
    materials: HalfSpace | Mapping[str, Any] | Sequence[Any] | None = None,
    settings: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None = None,
    *,
    folder: str | os.PathLike[str],
    workers: int | None = None,
    scheduler: str | None = None,
    threads: int = 1,
    force: bool = False,
    progress: Progress = None,
) -> Sweep:
    """Contact curves of all surfaces with all materials and all settings, on many workers.

    Jobs run on Dask, or in a pool of processes where it is not installed. Each writes a results
    file; only a row for the index comes back. Called again with the same folder it runs what is
    not finished, and what changed: the content of a file, a material, a setting, the version.

    Parameters
    ----------
    surfaces
        Path, glob, `HeightMap` or function that makes one (of a module, or a `functools.partial` of
        one, such as ``partial(surfaces.read, "scan.txt", unit="um", spacing=1e-6)``); or several.
        Without `materials` a table with a row for each job, such as a pandas frame or a list of
        mappings: column ``surface``, columns ``E``, ``nu``, ``m``, ``hardness`` or ``modulus`` of
        the body, and those of settings.
    materials
        A `HalfSpace` or its keywords, or several.
    settings
        Keyword arguments of the method, or several sets of them: ``method`` is "curve" (default,
        `contact_curve`), "bem" (`bem_curve`) or "solve"; ``loads`` [N] may be given in place of
        ``pressures``, and ``prepare`` holds keywords of `surfaces.prepare`.
    folder
        Where the index and the results are; made if need be.
    workers
        Number of processes; as many as there are processors, over `threads`, if None.
    scheduler
        Address of a Dask scheduler, such as "tcp://node:8786", in place of workers here. Its
        workers must see the same files under the same names; start them with one thread each.
    threads
        Threads of each job. Results depend on it in their last digits, and not on the workers.
    force
        Whether finished jobs are run again, and an ``index.csv`` that is of no sweep is replaced.
    progress
        True for a progress bar with the time left, or a function called with each row as it comes.

    Returns
    -------
    Sweep
        The index: a row for each job, in their order. A job that failed is a row with its reason.

    Raises
    ------
    InputError
        If an argument is not usable, or no scheduler answers.
    AsperityError
        If the scheduler was lost.

    Notes
    -----
    Worker processes import the program that calls this: guard it by ``if __name__ == "__main__":``.

    Examples
    --------
    >>> import tempfile
    >>> from functools import partial
    >>> import asperity, surfaces
    >>> make = partial(surfaces.self_affine, (32, 48), (32e-6, 48e-6), hurst=0.8, cutoff=8e-6)
    >>> maps = [partial(make, rms_slope=slope) for slope in (0.1, 0.2)]
    >>> bodies = [asperity.HalfSpace(E, 0.3) for E in (210e9, 70e9)]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = asperity.sweep(maps, bodies, {"pressures": 1e8}, folder=folder, workers=1)
    >>> len(found), bool(found.table["area_fraction"][1] > found.table["area_fraction"][0])
    (4, True)
    """
    place = as_path(folder)
    on = Workers(workers, scheduler, threads)
    jobs = Jobs(place).product(surfaces, materials, settings)
    again = as_truth("force", force)
    return run_sweep(jobs, place, on, force=again, progress=progress)


def run(
    jobs: Sequence[Job], folder: Path, on: Workers, force: bool = False, columns: bool = False
) -> Generator[tuple[Job, JobResult]]:
    """Tell of each job as it ends, those that an earlier run finished first; see `run_jobs`."""
    results = Path(os.path.abspath(folder)) / RESULTS
    make_folder(results)
    left = []
    for job in jobs:
        known = None if force else finished(job, results, columns)
        if known is None:
            left.append(job)
        else:
            yield job, known
    if left:
        parts = [
            part for name in {job.settings["method"] for job in left} for part in METHODS[name][1]
        ]
        if any(job.material.hardness < math.inf for job in left):
            parts += HARD
        compile_ahead(*dict.fromkeys(parts))
        work = functools.partial(
            run_jobs, folder=results, threads=on.threads, force=force, columns=columns
        )
        with opened(on, len(left)) as pool:
            yield from run_in_batches(left, work, pool)


def run_sweep(
    jobs: Sequence[Job],
    folder: Path,
    on: Workers,
    *,
    force: bool = False,
    progress: Progress = None,
) -> Sweep:
    """Run jobs that were made before, see `sweep`; what it returns is written to the folder."""
    found: dict[str, JobResult] = {}
    if not force:
        require_own(folder)
    make_folder(folder)  # before the index is written there, whatever else happens

    def index() -> Sweep:
        return Sweep.of_rows(folder, [row_of(job, found.get(job.file)) for job in jobs])

    distinct = {job.file: job for job in jobs}
    next_write = time.monotonic() + SECONDS_BETWEEN_WRITES
    with reported(progress, len(distinct), "jobs") as tell:
        try:
            for job, result in run(list(distinct.values()), folder, on, force):
                found[job.file] = result
                if tell is not None:
                    tell(row_of(job, result))
                if (begun := time.monotonic()) > next_write:
                    index().write()
                    spent = time.monotonic() - begun
                    next_write = begun + max(SECONDS_BETWEEN_WRITES, 50.0 * spent)
        finally:
            whole = index()
            whole.write()
    return whole


def row_of(job: Job, result: JobResult | None) -> dict[str, str | float]:
    """What the index tells of a job."""
    found = {"state": "waiting", "reason": ""} if result is None else result
    told = {"state": found["state"], "reason": found["reason"], **found}
    told.pop("values", None)
    kept = found["state"] in ("done", "not converged")
    return {**job.row, **told, "file": f"{RESULTS}/{job.file}" if kept else ""}
