"""Ensembles: the mean curve of many members, its scatter, and how well the mean is known."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import surfaces
from asperity.errors import ConvergenceError, InputError
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import default_pressures
from asperity.progress import Progress, reported
from surfaces.arrays import Array
from surfaces.errors import as_count, as_number, as_numbers, as_path, as_truth
from surfaces.heightmap import HeightMap

from .bands import DECIDES, QUANTITIES, Ensemble, relative_half_width
from .index import Sweep, require_own
from .jobs import Job, Jobs
from .pool import Workers
from .sweep import row_of, run
from .work import JobResult, prepared

__all__ = ["enough", "ensemble", "seeded", "windows_of"]

LEAST_MEMBERS = 10
"""Least members before the band is narrow enough: fewer tell too little of their scatter."""

FURTHER = 4
"""Members after the first with which the band is narrow enough: of normal members the band asked
for then holds the mean in 95 % of ensembles or more, with none in 94 %, with 8 in up to 99 %."""


def ensemble(
    members: Any,
    material: HalfSpace | Mapping[str, Any],
    settings: Mapping[str, Any] | None = None,
    *,
    folder: str | os.PathLike[str],
    seeds: int | Sequence[int] | None = None,
    windows: int | tuple[int, int] | None = None,
    until: float | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    threads: int = 1,
    force: bool = False,
    progress: Progress = None,
) -> Ensemble:
    """Mean contact curve of many members, with its scatter and confidence.

    Members are seeds of a synthetic surface, windows of a large map, or repeats of a measurement.
    Their curves, at common pressures, are jobs of a `sweep`, with its folder and its workers.

    Parameters
    ----------
    members
        With `seeds` a function of ``seed`` that makes a `HeightMap`, such as
        ``partial(surfaces.self_affine, shape, size, hurst=0.8, rms_slope=0.1)``; with `windows` an
        HDF5 file with a map; else surfaces as in `sweep`.
    material, settings, folder, workers, scheduler, threads, force, progress
        As in `sweep`, of one material and one set of settings. Loads are ``pressures`` [Pa]; by
        default those of the first member.
    seeds
        Their number, counted from 0, or the seeds.
    windows
        Points (ny, nx) of a window, or of its side. The map is cut without overlap, and read window
        by window; the windows come in an order drawn at random, once for all.
    until
        Relative half width of the confidence interval of the mean contact area, at every pressure,
        at which no further member is added [-]; None takes all.

    Returns
    -------
    Ensemble
        Mean curve, bands and convergence.

    Raises
    ------
    InputError
        If an argument is not usable.
    ConvergenceError
        If fewer than two members have a curve.

    Notes
    -----
    Whether the band is narrow enough is asked in the order of the members, from the tenth on:
    which of them are taken does not depend on the workers. A band that is looked at again with each
    member is narrow too early where the scatter is small by chance; as many members more as no
    scatter changes make up for it (Simons 1968), here four.

    References
    ----------
    G. Simons, Ann. Math. Stat. 39 (1968) 1946-1952.

    Examples
    --------
    >>> import tempfile
    >>> from functools import partial
    >>> import asperity, surfaces
    >>> make = partial(
    ...     surfaces.self_affine, (32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6
    ... )
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = asperity.ensemble(
    ...         make, steel, {"pressures": [1e8, 1e9]}, folder=folder, seeds=4, workers=1
    ...     )
    >>> len(found), bool(found.table["area_fraction"][0] < found.table["area_fraction"][1])
    (4, True)
    """
    for name, given in (("material", material), ("settings", settings or {})):
        if not isinstance(given, HalfSpace | Mapping):
            raise InputError(f"{name} is {given!r}; an ensemble is of one, or of its keywords")
    if seeds is not None and windows is not None:
        raise InputError("members are seeds or windows; give one of them")
    if seeds is not None:
        members = seeded(members, seeds)
    elif windows is not None:
        members = _windows(members, windows)
    maker, on = Jobs(as_path(folder)), Workers(workers, scheduler, threads)
    if not as_truth("force", force):
        require_own(maker.folder, "ensemble.csv", "ensemble.h5", "convergence.csv")
    chosen = list(maker.surfaces(members))
    if until is not None and not as_number("until", until) > 0.0:
        raise InputError(f"until is {until}; give a relative half width above 0, such as 0.02")
    (first, *_) = maker.product(chosen, material, settings)
    pressures = _common(first)
    jobs = maker.product(chosen, material, {**first.settings, "pressures": pressures})
    distinct = list({job.file: job for job in jobs}.values())
    rows, curves, widths = list[Any](), list[Any](), list[float]()
    stream = run(distinct, maker.folder, on, force, columns=True)
    with reported(progress, len(distinct), "members") as tell, closing(stream):
        for job, result in _in_order(distinct, stream):
            rows.append(row_of(job, result))
            if tell is not None:
                tell(rows[-1])
            if "values" in result:
                curves.append([result["values"][name] for name in QUANTITIES])
                widths.append(relative_half_width(np.array(curves)[:, QUANTITIES.index(DECIDES)]))
                if until is not None and enough(widths, until):
                    break
    index = Sweep.of_rows(maker.folder, rows)
    index.write()
    if len(curves) < 2:
        why = next(iter(index.table["reason"][index.failed]), "give more of them")
        raise ConvergenceError(f"{len(curves)} of {len(rows)} members have a curve: {why}")
    values = dict(zip(QUANTITIES, np.array(curves).transpose(1, 0, 2), strict=True))
    whole = Ensemble(index, pressures, values, np.array(widths), until)
    whole.write()
    return whole


def enough(widths: Sequence[float], until: float) -> bool:
    """Whether no further member is added, from the widths of the band with one and more members."""
    narrow = widths[-1] <= until
    return narrow and sum(width <= until for width in widths[LEAST_MEMBERS - 1 :]) > FURTHER


def seeded(make: Any, seeds: int | Sequence[int]) -> list[Callable[[], HeightMap]]:
    """Functions that make a surface of each seed. The first is made here: they differ by the seed
    alone, and what cannot be made is refused before workers start."""
    if not callable(make):
        raise InputError(f"seeds need a function of seed, not a {type(make).__name__}")
    drawn = seeds if isinstance(seeds, Iterable) else range(as_count("seeds", seeds, 1))
    members: list[Callable[[], HeightMap]] = [partial(make, seed=seed) for seed in drawn]
    for first in members[:1]:
        first()
    return members


def windows_of(
    shape: tuple[int, int], window: int | tuple[int, int]
) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Rows and columns, first and one past last, of the windows of a map, in a random order;
    refused if no window fits into it."""
    sides = as_numbers("windows", window)
    if sides.shape not in ((), (1,), (2,)):
        raise InputError(f"windows is {window}; give their side, or rows and columns, in points")
    ny, nx = (as_count("windows", side, 3) for side in np.broadcast_to(sides, 2).tolist())
    if ny > shape[0] or nx > shape[1]:
        raise InputError(f"windows of {ny} x {nx} points do not fit into {shape[0]} x {shape[1]}")
    places = [
        ((top, top + ny), (left, left + nx))
        for top in range(0, shape[0] - ny + 1, ny)
        for left in range(0, shape[1] - nx + 1, nx)
    ]
    return [places[i] for i in np.random.default_rng(0).permutation(len(places))]


def _windows(path: Any, window: int | tuple[int, int]) -> list[Callable[[], HeightMap]]:
    """Functions that read the windows of a map."""
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"windows are of an HDF5 file with a map, not of a {type(path).__name__}")
    with surfaces.open(path) as file:
        places = windows_of(file.shape, window)
    read = partial(surfaces.read, os.path.abspath(path))
    return [partial(read, rows=rows, columns=columns) for rows, columns in places]


def _common(first: Job) -> Array:
    """Pressures at which the members are compared."""
    other = {"separations", "loads"} & first.settings.keys()
    if other:
        raise InputError(f"members are compared at common pressures; leave out {', '.join(other)}")
    given: ArrayLike | None = first.settings.get("pressures")
    if given is None:
        given = default_pressures(prepared(first.surface.load(), first), first.material)
    pressures = as_numbers("pressures", given).ravel()
    if not (pressures > 0.0).all():
        raise InputError("the pressures of an ensemble must be positive")
    return pressures[np.sort(np.unique(pressures, return_index=True)[1])]


def _in_order(
    jobs: Sequence[Job], stream: Iterator[tuple[Job, JobResult]]
) -> Iterator[tuple[Job, JobResult]]:
    """Jobs and results in the order of the jobs, each as soon as those before it are there."""
    found: dict[str, JobResult] = {}
    left = iter(jobs)
    job = next(left, None)
    for done, result in stream:
        found[done.file] = result
        while job is not None and job.file in found:
            yield job, found.pop(job.file)
            job = next(left, None)
