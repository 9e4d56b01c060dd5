r"""What each correction of the microcontact model is worth: errors and time with and without it.

    python benchmarks/ablation.py --references folder --maps measured --out rows.csv
    python benchmarks/ablation.py --rows docs/development/ablation.csv \
        --csv docs/development/data/ablation.csv

Maps, reference and errors are those of judged_maps.py.

A correction is switched off at one place (`CORRECTIONS`), most by `asperity.parameters`. A family
is one kind of map; families of one group are related. `decisive` groups are those in which the
worst error of some family rises by half a percent of load or area without the correction, `harmed`
those in which it falls by so much.
"""

from __future__ import annotations

import argparse
import csv
import inspect
import types
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np
from judged_maps import errors, reference, scenes
from numba import njit
from numpy.typing import NDArray

from asperity.model import law_factory
from asperity.parameters import (
    DEFAULTS,
    ContactShift,
    Corrections,
    LawChoice,
    Parameters,
    PressedBasins,
)
from asperity.results.storage import write_csv

MATTERS = 0.005

Array = NDArray[np.float64]


class Correction(NamedTuple):
    """How a correction is switched off, and the objects whose lines are its own.

    By its switch or several of them (`asperity.parameters.Corrections`), by other constants, or
    from outside.
    """

    off: str | tuple[str, ...] | Parameters | Callable[[ExitStack], object]
    objects: tuple[str, ...]


def replaced(name: str, value: Any) -> Callable[[ExitStack], object]:
    """Switch that puts another value in the place of a dotted name."""
    return lambda stack: stack.enter_context(patch(name, value))


def found(name: str) -> Any:
    """Object of a dotted name."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            thing = import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            thing = inspect.getattr_static(thing, part)
            thing = getattr(thing, "fget", None) or getattr(thing, "func", None) or thing
        return thing
    raise ModuleNotFoundError(name)


def lines_of(objects: tuple[str, ...]) -> int:
    """Lines of modules, classes and functions."""
    total = 0
    for name in objects:
        thing = found(name)
        thing = getattr(thing, "py_func", thing)
        total += len(inspect.getsource(thing).splitlines())
    return total


def _no_shift(_: Any, law: Any, approach: Array, *__: Any) -> tuple[Array, Array, Array]:
    """`contact_shifts` of contacts that stay where they are."""
    return np.zeros(len(approach)), np.zeros((len(approach), 2)), np.zeros((len(approach), 2))


def _no_powers(stack: ExitStack) -> None:
    """Every tip is a paraboloid in the kernel that knows other powers."""
    name = "asperity.microcontact.law_kernels.tabulate"
    kernel = found(name).py_func
    known = kernel.__globals__ | {"BLUNT_TIP": np.inf}
    plain = types.FunctionType(kernel.__code__, known, kernel.__name__)
    stack.enter_context(patch(name, njit(error_model="numpy")(plain)))
    stack.enter_context(patch(f"{PRESS}.press.BLUNT_TIP", np.inf))


NEWTON = "asperity.interaction.newton"
PRESS = "asperity.microcontact.basin_bem"
POPULATION = "asperity.interaction.contact_system.ContactSystem"
CANDIDATES = "asperity.interaction.candidates.CandidateList"
SPLIT = "asperity.multiscale.wave_split"
LAWS = "asperity.model.corrections"
TABLES = "asperity.microcontact.laws"
RAYS = "asperity.microcontact.ray_laws"

CORRECTIONS = {
    **{
        switch.replace("_", " "): Correction(switch, (correct.__module__,))
        for switch, correct in law_factory.CORRECTIONS.items()
    },
    "contact shift": Correction(
        replaced(f"{NEWTON}.state.contact_shifts", _no_shift),
        (
            f"{NEWTON}.contact_shift.contact_shifts",
            f"{NEWTON}._newton_kernels.shift_contacts",
            f"{NEWTON}.state.State.lag",
        ),
    ),
    "centers of contacts": Correction(
        replaced(f"{POPULATION}.has_centres", False),
        (f"{CANDIDATES}.recentred", f"{CANDIDATES}._strayed", f"{POPULATION}.has_centres"),
    ),
    "widening": Correction(
        replace(DEFAULTS, contact_shift=ContactShift(growth=0.0)),
        (f"{NEWTON}.contact_shift.widened",),
    ),
    "elongated footprints": Correction(
        "elongation",
        ("asperity.interaction.elongation",),
    ),
    "pressed basins": Correction(
        ("pressed_basins", "joined_pairs"),
        (
            "asperity.model.law_rows",
            f"{LAWS}.pressed_basins",
            f"{LAWS}.joined_pairs",
            f"{PRESS}.press",
            f"{PRESS}._element_kernels",
            f"{PRESS}._closing_kernels",
        ),
    ),
    "pairs pressed as one": Correction(
        "joined_pairs",
        (
            f"{LAWS}.joined_pairs",
            f"{PRESS}.press._second",
            "surfaces.peaks.summits.Summits.joined",
        ),
    ),
    "flat tops pressed": Correction(
        replace(DEFAULTS, pressed_basins=PressedBasins(plateau_share=10.0)),
        ("asperity.model.law_rows._weight",),
    ),
    "guard of the ellipse law": Correction(
        replace(DEFAULTS, law_choice=LawChoice(gross_difference=np.inf)),
        (
            *(
                f"{TABLES}.{name}"
                for name in ("tabulate_auto", "_without_pull", "_worst_ratio", "_replace")
            ),
            *(f"{RAYS}.{name}" for name in ("tabulate_ritz", "ritz_forces", "_march")),
            "asperity.microcontact._ray_kernels",
        ),
    ),
    "tilted basins": Correction(
        "tilted_basins",
        (
            f"{LAWS}.tilted_basins",
            "surfaces.peaks.summits.Summits.tilted",
            "surfaces.peaks._climb.uphill",
        ),
    ),
    "tips of other powers": Correction(
        _no_powers, ("asperity.microcontact.law_kernels._tip_exponents",)
    ),
    "split of the waves": Correction(
        "wave_split",
        (
            *(f"{SPLIT}.{name}" for name in ("Split", "split_scales", "_law", "_breadth")),
            "asperity.multiscale.sub_contact_law",
            "asperity.multiscale.spectrum_shells",
        ),
    ),
    "half the pixel": Correction("finer_grid", (f"{SPLIT}.refined_map",)),
    "fewer points": Correction(
        "coarser_grid",
        tuple(
            f"surfaces.preparation.resampling.{name}"
            for name in ("coarse_map", "shortest_wave", "_holds", "_highest", "_divisor")
        ),
    ),
}
"""The corrections by name; those of laws that need no entry of their own come first."""


@contextmanager
def without(name: str) -> Iterator[Parameters]:
    """The model without a correction; as it is for an empty name."""
    with ExitStack() as stack:
        off = CORRECTIONS[name].off if name else ()
        if isinstance(off, Parameters):
            yield off
        elif callable(off):
            off(stack)
            yield DEFAULTS
        else:
            names = (off,) if isinstance(off, str) else off
            yield replace(DEFAULTS, corrections=Corrections(**dict.fromkeys(names, False)))


Found = dict[tuple[str, str], list[tuple[Array, Array, float]]]


def measure(args: argparse.Namespace) -> list[dict[str, Any]]:
    """Rows of the table: each correction on each family."""
    groups: dict[str, str] = {}
    found_: Found = {}
    names = [n for n in CORRECTIONS if not args.only or any(part in n for part in args.only)]
    if not names:
        raise SystemExit(f"no correction is called {args.only}; there are {[*CORRECTIONS]}")
    warm, others = True, set()
    for scene in scenes(args.maps):
        if args.families and not any(part in scene.family for part in args.families):
            others.add(scene.family)
            continue
        exact = reference(scene, args.references)
        groups[scene.family] = scene.group
        for name in ("", *names):
            with without(name) as parameters:
                if warm:
                    errors(scene, exact, parameters)
                result = errors(scene, exact, parameters)
            found_.setdefault((name, scene.family), []).append(result)
        warm = False
        load, area, seconds = found_["", scene.family][-1]
        print(
            f"{scene.group:16s} {scene.family:40s} {scene.seed:4d}  {seconds:.3f} s  load "
            f"{100 * worst(load):.2f} area {100 * worst(area):.2f} %",
            flush=True,
        )
    if not groups:
        raise SystemExit(f"no family is called {args.families}; there are {sorted(others)}")
    return [
        row(name, family, group, found_[name, family], found_["", family])
        for name in names
        for family, group in groups.items()
    ]


def worst(values: Array) -> float:
    """Largest error; 0 of none."""
    return float(np.nanmax(np.abs(values))) if np.isfinite(values).any() else 0.0


def row(name: str, family: str, group: str, off: list[Any], on: list[Any]) -> dict[str, Any]:
    """One row of the table: a correction on a family."""
    made: dict[str, Any] = {"correction": name, "lines": lines_of(CORRECTIONS[name].objects)}
    made |= {"group": group, "family": family}
    for column, kind in enumerate(("load", "area")):
        for label, runs in (("with", on), ("without", off)):
            values = np.concatenate([run[column] for run in runs])
            median = float(np.nanmedian(np.abs(values))) if np.isfinite(values).any() else 0.0
            made[f"{kind}_median_{label}"] = round(median, 5)
            made[f"{kind}_worst_{label}"] = round(worst(values), 5)
            made[f"{kind}_refused_{label}"] = int(np.count_nonzero(np.isnan(values)))
    for label, runs in (("with", on), ("without", off)):
        made[f"seconds_{label}"] = round(sum(run[2] for run in runs), 4)
    made["points"] = int(sum(run[0].size for run in off))
    return made


def summary(rows: list[dict[str, Any]]) -> list[dict[str, str]]:
    """The table of the pages: one row per correction."""
    table = []
    for name in dict.fromkeys(row["correction"] for row in rows):
        own = [row for row in rows if row["correction"] == name]
        gains: dict[str, tuple[float, str]] = {}
        losses: dict[str, tuple[float, str]] = {}
        for one in own:
            for kind in ("load", "area"):
                gain = float(one[f"{kind}_worst_without"]) - float(one[f"{kind}_worst_with"])
                into = gains if gain > 0 else losses
                if abs(gain) >= MATTERS and abs(gain) > into.get(one["group"], (0.0, ""))[0]:
                    change = (
                        f"{kind} {100 * float(one[f'{kind}_worst_with']):.1f} → "
                        f"{100 * float(one[f'{kind}_worst_without']):.1f} ({one['family']})"
                    )
                    into[one["group"]] = abs(gain), change
        spent = [float(one["seconds_with"]) / float(one["seconds_without"]) for one in own]
        line = {
            "correction": name,
            "lines": str(own[0]["lines"]),
            "decisive in": _told(gains) or "-",
            "harmful in": _told(losses) or "-",
        }
        for kind in ("load", "area"):
            line[f"median {kind} error: with → without, %"] = " → ".join(
                f"{100 * np.mean([float(o[f'{kind}_median_{way}']) for o in own]):.2f}"
                for way in ("with", "without")
            )
        line["time, %"] = f"{100 * (np.median(spent) - 1):+.0f}"
        table.append(line)
    return table


def _told(changes: dict[str, tuple[float, str]]) -> str:
    """The three groups that change most, and how many more change."""
    largest = sorted(changes.items(), key=lambda item: -item[1][0])
    told = [f"**{group}** {text}" for group, (_, text) in largest[:3]]
    return "; ".join(told + [f"{len(largest) - 3} more"] * (len(largest) > 3))


def main() -> None:
    """Measure, write and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--references", type=Path, help="folder that keeps the reference curves")
    parser.add_argument("--maps", type=Path, help="folder of measured maps")
    parser.add_argument("--only", nargs="*", default=[], help="parts of names of corrections")
    parser.add_argument("--families", nargs="*", default=[], help="parts of family names")
    parser.add_argument("--out", type=Path, help="CSV that takes all rows")
    parser.add_argument("--rows", type=Path, help="CSV of all rows, made before: measure nothing")
    parser.add_argument("--csv", type=Path, help="CSV that takes the table of the pages")
    args = parser.parse_args()
    if args.rows:
        with args.rows.open() as file:
            rows: list[dict[str, Any]] = list(csv.DictReader(file))
    else:
        if args.references:
            args.references.mkdir(parents=True, exist_ok=True)
        rows = measure(args)
    if args.out:
        write_csv(args.out, {name: [row[name] for row in rows] for name in rows[0]})
    table = summary(rows)
    if args.csv:
        write_csv(args.csv, {name: [line[name] for line in table] for name in table[0]})
    for line in table:
        print(" | ".join(line.values()))


if __name__ == "__main__":
    main()
