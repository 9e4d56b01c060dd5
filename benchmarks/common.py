"""What the benchmarks share: maps, a clock, the name of the machine, the options."""

from __future__ import annotations

import argparse
import platform
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numba
import numpy as np
from drawn import FAMILIES, drawn
from grids import Heights
from numpy.typing import ArrayLike, NDArray

import asperity
import surfaces


def rough(
    shape: tuple[int, int], cutoff: float | None, seed: int, **more: float | None
) -> surfaces.HeightMap:
    """Self-affine map of unit pixels; H 0.8, rms slope 0.1 and a roll-off at an eighth of the
    shorter side unless `more` says otherwise."""
    size = (float(shape[0]), float(shape[1]))
    recipe = {"hurst": 0.8, "rms_slope": 0.1, "rolloff": min(shape) / 8} | more
    return surfaces.self_affine(shape, size, cutoff=cutoff, seed=seed, **recipe)


def rough_heights(shape: tuple[int, int], seed: int, **recipe: float | None) -> Heights:
    """Heights of a `rough` map, cut off at six pixels and without roll-off unless `recipe` says
    otherwise."""
    return rough(shape, seed=seed, **({"cutoff": 6.0, "rolloff": None} | recipe)).heights


Scene = tuple[surfaces.HeightMap, float, str | None]
"""A map, the exponent of the grading, and the boundary."""


def measured(path: Path, border: str = "taper") -> surfaces.HeightMap:
    """A measured map, filled, and made periodic this way, or "free"."""
    periodic = None if border == "free" else border
    return surfaces.prepare(surfaces.read(path), fill="harmonic", periodic=periodic)


def pressures_at(curve: asperity.ContactCurve, fractions: ArrayLike) -> NDArray[np.float64]:
    """Mean pressures [Pa] at which a curve has these area fractions; beyond it those of its ends,
    which `curve.at` refuses."""
    known = np.log([curve.area_fraction, curve.mean_pressure])[:, curve.converged]
    return np.asarray(np.exp(np.interp(np.log(fractions), *known)))


def errors(
    hm: surfaces.HeightMap, body: asperity.HalfSpace, exact: asperity.ContactCurve
) -> tuple[NDArray[np.float64], asperity.ContactCurve, asperity.ContactCurve]:
    """Errors [-] of the model in load at equal separation and in area at equal load, shape (2, n),
    against a curve of boundary elements; and the two curves that tell them."""
    same = asperity.contact_curve(hm, body, separations=exact.separation)
    model = asperity.contact_curve(hm, body, pressures=exact.mean_pressure)
    load, area = same.mean_pressure / exact.mean_pressure, model.contact_area / exact.contact_area
    return np.array([load, area]) - 1.0, same, model


def scenes(
    args: argparse.Namespace,
    families: Callable[[int], dict[str, Callable[[], Scene]]],
    border: str = "taper",
) -> Iterator[tuple[str, int, surfaces.HeightMap, float, str | None]]:
    """Name, seed, map, exponent of the grading and boundary of everything asked for: the measured
    `maps`, made periodic by their `border`, or of all `seeds` the `drawn` ones or those of
    `families`, a function of the seed."""

    def wanted(name: str) -> bool:
        return not args.families or any(part in name for part in args.families)

    if args.maps:
        for path in sorted(args.maps.glob("*.h5")):
            if wanted(path.stem):
                yield path.stem, 0, measured(path, border), 0.0, None
        return
    for seed in args.seeds:
        random = {name: partial(drawn, name, seed) for name in FAMILIES}
        for name, make in (random if args.drawn else families(seed)).items():
            if wanted(name):
                yield name, seed, *make()


def least(call: Callable[[], object], repeats: int = 7) -> float:
    """Least seconds of several calls, after one that compiles."""
    call()
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def machine() -> str:
    """Processor, and the threads that compiled loops run on."""
    processor = platform.processor() or platform.machine()
    return f"{processor}, {numba.get_num_threads()} threads"


def options(page: str | None, **settings: Any) -> argparse.ArgumentParser:
    """Parser whose help is the docstring of the script."""
    form = argparse.RawDescriptionHelpFormatter
    return argparse.ArgumentParser(description=page, formatter_class=form, **settings)
