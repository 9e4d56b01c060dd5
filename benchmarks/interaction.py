"""Error, convergence and cost of the coupled solve.

    python benchmarks/interaction.py               # all parts
    python benchmarks/interaction.py sum cost      # some of them

sum    the fast field against the dense sum over all pairs and images, random footprints
many   one field and one tangent product for up to 100 000 contacts, and the memory they take
large  a whole solve until 100 000 contacts are closed: time, residual and memory
walk   every separation from first touch to half contact: converged, refused with its reason, failed
steps  curves of ten loads at the tolerance of `contact_curve` against a fifty times smaller one
cost   milliseconds per separation at about 2000 and 14 000 closed contacts, 50 separations to a
       curve, without compilation and law tables; wall clock and processor time of all threads
"""

from __future__ import annotations

import resource
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from common import least, options, rough

import surfaces
from asperity import HalfSpace, Population
from asperity.curve import RESIDUAL_AT_SEPARATION, RESIDUAL_UNDER_LOAD
from asperity.halfspace.footprint import Footprints
from asperity.interaction.ewald.operator import Interaction
from asperity.interaction.ewald.tangent import Tangent
from asperity.interaction.population import PopulationState
from asperity.microcontact import tabulate
from asperity.microcontact.law_table import LawTable
from surfaces.numerics.parallel import threads

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from oracles import dense_matrix

MATERIAL = HalfSpace.from_modulus(1.0)
REPEATS = 7
FAMILIES = {
    "cut-off 4 px": {"cutoff": 4.0},
    "cut-off 8 px": {"cutoff": 8.0},
    "cut-off 16 px": {"cutoff": 16.0},
    "cut-off 32 px": {"cutoff": 32.0},
    "H = 0.5": {"cutoff": 8.0, "hurst": 0.5},
    "anisotropic 4:1": {"cutoff": 8.0, "anisotropy": 4.0},
}


PRODUCTS: Counter[str] = Counter()
"""Number of fields of the contacts, and of products with their tangent matrices."""


def counted(method: Callable[..., Any]) -> Callable[..., Any]:
    """The method, whose calls are counted in `PRODUCTS`."""

    def counting(*args: Any) -> Any:
        PRODUCTS[method.__qualname__] += 1
        return method(*args)

    return counting


def solved(contacts: Population, **asked: Any) -> tuple[PopulationState, tuple[float, float, int]]:
    """A state; and the seconds that its solve took by the wall clock and of all threads, and the
    number of products."""
    PRODUCTS.clear()
    wall, busy = time.perf_counter(), time.process_time()
    state = contacts.solve(**asked)
    return state, (time.perf_counter() - wall, time.process_time() - busy, PRODUCTS.total())


def population(n: int, law: str, seed: int = 1, **spectrum: float) -> tuple[Population, float]:
    """Population of a square map of unit pixels, and its rms height."""
    hm = rough((n, n), seed=seed, **{"cutoff": 4.0} | spectrum)
    profiles = surfaces.fit_profiles(hm, surfaces.segment(hm))
    made = Population(
        x=profiles.x,
        y=profiles.y,
        height=profiles.height - hm.heights.mean(),
        table=tabulate(profiles, MATERIAL, law=law),
        cell=hm.size,
        boundary="periodic",
        material=MATERIAL,
        # contacts by the law of Hertz are round
        curvature=None if law == "hertz" else profiles.curvature,
        angle=None if law == "hertz" else profiles.angle,
    )
    return made, hm.rms_height


def accuracy() -> None:
    """Error of the fast sum."""
    print("fast sum against the dense sum, 400 footprints, cell 1 x 1.7")
    print("boundary      m   filling   rms error / rms field   largest / sum of all |g|")
    rng = np.random.default_rng(0)
    cell, n = (1.0, 1.7), 400
    for boundary in ("periodic", "free"):
        for m in (-0.3, 0.0, 0.5):
            for filling in (0.2, 0.5):
                y, x = rng.uniform(0, cell[0], n), rng.uniform(0, cell[1], n)
                radius = rng.uniform(0.3, 1, n)
                radius *= np.sqrt(filling * cell[0] * cell[1] / (np.pi * np.sum(radius**2)))
                f = Footprints(1.0, m)
                v = f.variance(f.punch(radius))
                dense = dense_matrix(y, x, v, cell, boundary, f)
                np.fill_diagonal(dense, dense.diagonal() - f.self_factor * v ** (-(1 + m) / 2))
                force = rng.uniform(0, 1, n)
                plan = Interaction(y, x, cell, boundary, f, widest=float(v.max()))
                error = plan.field(force[plan.order], v[plan.order])[0]
                wanted = (dense @ force)[plan.order]
                error -= wanted
                rms = np.sqrt(np.mean(error**2) / np.mean(wanted**2))
                largest = np.abs(error).max() / np.abs(dense).sum(1).mean()
                print(f"{boundary:9s} {m:5.1f} {filling:9.1f} {rms:18.1e} {largest:24.1e}")


def many() -> None:
    """Growth of the cost with the number of contacts."""
    print(f"cost of one application, {threads()} threads, least of 5")
    print("contacts     pairs   plan [ms]   field [ms]   tangent product [ms]   memory [MB]")
    rng = np.random.default_rng(0)
    f = Footprints(1.0)
    for n in (2_000, 14_000, 100_000):
        y, x = rng.uniform(0, 1, (2, n))
        radius = np.full(n, 0.3 / np.sqrt(n))
        k, v = f.punch(radius), f.variance(f.punch(radius))
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        plan = Interaction(y, x, (1.0, 1.0), "periodic", f, widest=float(v.max()))
        planned = least(
            lambda: Interaction(y, x, (1.0, 1.0), "periodic", f, widest=float(v.max())),  # noqa: B023
            2,
        )
        field = least(lambda: plan.field(k, v))  # noqa: B023
        tangent = Tangent(plan, np.ones(n, bool), k)
        product = least(lambda: tangent(k))  # noqa: B023
        memory = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1e3
        print(
            f"{n:8d} {plan.pairs:9d} {1e3 * planned:11.1f} {1e3 * field:12.2f} "
            f"{1e3 * product:22.2f} {memory:13.0f}"
        )


def large() -> None:
    """Seven mean pressures until 100 000 of 200 000 spheres at random places are closed."""
    n, steps = 200_000, 16
    rng = np.random.default_rng(0)
    place, spacing = rng.uniform(0, 1, (2, n)), n**-0.5
    radius = 2 * spacing * rng.lognormal(0, 0.4, n)
    reach = (0.3 * spacing) ** 2 / radius
    u = np.linspace(0, 1, steps + 1)
    a = np.sqrt(radius * reach)[:, None] * u
    table = LawTable(
        reach=reach,
        force=4 / 3 * a**3 / radius[:, None],
        stiffness=2 * a,
        area=np.pi * a**2,
        flags=np.zeros((n, steps + 1), np.uint8),
        spread=np.zeros((n, steps + 1)),
    )
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    contacts = Population(
        x=place[0],
        y=place[1],
        height=0.05 * spacing * rng.normal(size=n),
        table=table,
        cell=(1.0, 1.0),
        boundary="periodic",
        material=MATERIAL,
    )
    print("one solve of many contacts, law hertz, with contact shift")
    print(
        "mean pressure   closed    area   residual   s wall   s processor   products   memory [MB]"
    )
    state = None
    for pressure in np.geomspace(1e-3, 1.2e-2, 7):
        state, (wall, busy, products) = solved(contacts, pressure=float(pressure), state=state)
        memory = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1e3
        end = f"{state.residual:10.1e}" if state.converged else state.reason
        print(
            f"{pressure:13.1e} {state.active:8d} {state.contact_area:7.3f} {end} "
            f"{wall:8.2f} {busy:13.2f} {products:10d} {memory:13.0f}"
        )


def walk() -> None:
    """Convergence at every separation of every family."""
    print("separations from first touch to half contact, 512^2, seeds 1-3, law ellipse, 40 each")
    print("family            converged   refused   failed   Newton steps, mean   largest")
    for family, spectrum in FAMILIES.items():
        ends: Counter[str] = Counter()
        steps = []
        for seed in (1, 2, 3):
            contacts, rms = population(512, "ellipse", seed, **spectrum)
            state, top = None, float(contacts.height.max())
            for separation in np.linspace(top, -0.2 * rms, 40):
                state = contacts.solve(separation=float(separation), state=state)
                steps.append(state.iterations)
                end = "converged" if state.converged else "failed"
                ends["refused" if "nominal area" in state.reason else end] += 1
        print(
            f"{family:17s} {ends['converged']:9d} {ends['refused']:9d} {ends['failed']:8d} "
            f"{np.mean(steps):20.1f} {max(steps):9d}"
        )


def tolerance() -> None:
    """What the default tolerance of a curve does to it."""
    default = RESIDUAL_UNDER_LOAD
    print(f"ten loads to about 10 % contact, 512^2, seeds 5 and 6, tolerance {default:g}:")
    print("largest relative differences from a fifty times smaller tolerance, percent")
    print("family            load at equal separation   area   stiffness   steps   products")
    for family, spectrum in FAMILIES.items():
        worst, spent = np.zeros(3), np.zeros(2)
        for seed in (5, 6):
            contacts, _ = population(512, "ellipse", seed, **spectrum)
            rough = exact = None
            for pressure in np.geomspace(5e-5, 5e-3, 10):
                at = {"pressure": float(pressure)}
                rough, (*_, products) = solved(contacts, **at, state=rough, tolerance=default)
                exact = contacts.solve(**at, state=exact, tolerance=0.02 * default)
                fall = (exact.separation - rough.separation) * exact.normal_stiffness
                missed = (
                    (rough.mean_pressure + fall) / exact.mean_pressure - 1,
                    rough.contact_area / exact.contact_area - 1,
                    rough.normal_stiffness / exact.normal_stiffness - 1,
                )
                worst = np.maximum(worst, np.abs(missed))
                spent += rough.iterations, products
        load, area, stiffness = 100 * worst
        print(
            f"{family:17s} {load:24.2f} {area:6.2f} {stiffness:11.1f} "
            f"{spent[0] / 20:7.1f} {spent[1] / 20:10.1f}"
        )


def cost() -> None:
    """Milliseconds per separation."""
    how = f"50 to a curve, least of {REPEATS} runs, law hertz"
    print(f"cost per separation, {threads()} threads, {how}")
    print("map           contact shift   closed    area   ms wall   ms processor   products")
    for n, cutoff, closed in ((1024, 8.0, 2000), (2048, 4.0, 14_000)):
        contacts, rms = population(n, "hertz", cutoff=cutoff)
        for shift in (False, True):
            contacts.contact_shift = shift
            top, state = float(np.sort(contacts.height)[-3]), None
            low = top
            while state is None or state.active < closed:
                low -= 0.1 * rms
                state = contacts.solve(separation=low, state=state)
            runs = []
            for _ in range(REPEATS):
                state, rows = None, []
                for separation in np.linspace(top, low, 50):
                    at = {"separation": float(separation), "tolerance": RESIDUAL_AT_SEPARATION}
                    state, spent = solved(contacts, **at, state=state)
                    rows.append(spent)
                runs.append(rows[-6:])
            # the mean of the last separations, lists rebuilt among them
            wall, busy, products = np.array(runs).mean(axis=1).min(axis=0)
            share = state.contact_area / contacts.nominal_area
            print(
                f"{n:5d}^2, {cutoff:.0f} px {shift!s:>14} {state.active:8d} {share:7.3f} "
                f"{1e3 * wall:9.1f} {1e3 * busy:14.1f} {products:10.1f}"
            )


PARTS = {
    "sum": accuracy,
    "many": many,
    "large": large,
    "walk": walk,
    "steps": tolerance,
    "cost": cost,
}


if __name__ == "__main__":
    parser = options(__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help="of " + ", ".join(PARTS))
    parts = parser.parse_args().parts
    if unknown := set(parts) - set(PARTS):
        parser.error(f"no part is called {', '.join(sorted(unknown))}")
    Interaction.field, Tangent.__call__ = counted(Interaction.field), counted(Tangent.__call__)
    for part in parts or PARTS:
        PARTS[part]()
        print()
