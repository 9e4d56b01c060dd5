"""Write the golden curves: ``PYTHONPATH=tests python -m golden.make [name ...]``.

Run it only where an answer has to change, and say in the commit by how much and why; the script
prints the largest relative change of every column that moved.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numba
import numpy as np
import scipy
from golden.maps import CASES, LOADS, Case, height_map, material
from llvmlite import binding

import asperity
from asperity.halfspace.scene import pressure_scale
from surfaces.numerics.parallel import set_threads, threads

FILE = Path(__file__).with_name("curves.json")

COLUMNS = (
    "separation",
    "mean_pressure",
    "contact_area",
    "contacts",
    "stiffness",
    "converged",
    "error_estimate",
)


def machine() -> dict[str, str]:
    """What the rounding depends on: the processor, and the libraries that compile and transform."""
    versions = {module.__name__: module.__version__ for module in (np, scipy, numba)}
    return {"processor": binding.get_host_cpu_name(), **versions}


def model(case: Case) -> asperity.ContactCurve:
    """The curve of the microcontact model."""
    hm, body = height_map(case), material(case)
    pressures = LOADS * pressure_scale(hm, body)
    return asperity.contact_curve(
        hm, body, pressures=pressures, boundary=case.boundary, **case.model
    )


def elements(case: Case) -> asperity.ContactCurve:
    """The curve of the boundary elements, on at most 128 points along the shorter side."""
    hm, body = height_map(case, 128 / max(case.points[0], 256)), material(case)
    pressures = LOADS * pressure_scale(hm, body)
    return asperity.bem_curve(hm, body, pressures=pressures, boundary=case.boundary, tolerance=1e-6)


ENGINES = {"model": model, "bem": elements}


def solved(engine: str, name: str) -> dict[str, Any]:
    """Columns of one curve, on one thread."""
    before = threads()
    set_threads(1)
    try:
        curve = ENGINES[engine](CASES[name])
    finally:
        set_threads(before)
    columns = {column: getattr(curve, column).tolist() for column in COLUMNS}
    if engine == "model":
        columns["area_error_estimate"] = curve.extra["area_error_estimate"].tolist()
    return columns


def solved_apart(names: Iterable[str]) -> dict[str, Any]:
    """Columns of the curves of both engines, solved in a process of their own.

    Machine code from the disk and code compiled a moment ago round differently: functions that
    several kernels share take the flags of the first that compiles them, and calls go to the first
    copy in memory. The first process compiles what the disk lacks, the second solves without it.
    """
    tests = Path(__file__).parents[1]
    paths = os.pathsep.join((str(tests.parent), str(tests)))
    environment = {**os.environ, "PYTHONPATH": paths}
    command = [sys.executable, "-m", "golden.make", "--print", *names]
    for _ in range(2):
        found = subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True)
    return json.loads(found.stdout)


def main(names: list[str]) -> None:
    """Solve the named cases, or all, and print what changed."""
    kept = json.loads(FILE.read_text()) if FILE.exists() else {"curves": {}}
    for key, new in solved_apart(names or CASES).items():
        old = kept["curves"].get(key, {})
        for column in new:
            was, now = (np.array(c.get(column, new[column]), float) for c in (old, new))
            size = np.maximum(np.abs(was), np.finfo(float).tiny)
            change = np.nanmax(np.abs(now - was) / size, initial=0.0)
            if change > 1e-9 or not np.array_equal(np.isnan(was), np.isnan(now)):
                print(f"{key}: {column} by {change:.2e}")
        kept["curves"][key] = new
    kept["machine"] = machine()
    kept["command"] = "PYTHONPATH=tests python -m golden.make"
    FILE.write_text(json.dumps(kept, indent=0))


if __name__ == "__main__":
    if sys.argv[1:2] == ["--print"]:
        curves = {f"{e} {name}": solved(e, name) for e in ENGINES for name in sys.argv[2:]}
        print(json.dumps(curves))
    else:
        main(sys.argv[1:])
