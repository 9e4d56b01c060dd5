"""Error of the microcontact model against certified boundary elements, family by family.

    python benchmarks/accuracy.py --points 512 --seeds 11 12 --out rows.csv
    python benchmarks/accuracy.py --points 256 --seeds 11 12 --measured-like --out like.csv
    python benchmarks/accuracy.py --drawn --seeds 101 102 --out drawn.csv
    python benchmarks/accuracy.py --made --seeds 3 4 --out made.csv
    python benchmarks/accuracy.py --textures --points 256 --seeds 3 4 --out textures.csv
    python benchmarks/accuracy.py --to-the-pixel --scales all --seeds 51 52
    python benchmarks/accuracy.py --maps folder --border smooth --out maps.csv
    python benchmarks/accuracy.py --hardness 0.02 0.1 0.5 --points 256 --seeds 41 42 --out hard.csv
    python benchmarks/accuracy.py --seeds 21 22 --csv docs/development/data/families_512.csv

Families: isotropic with the cut-off at 4, 8, 16, 32 pixels and Hurst exponents 0.5, 0.8, 0.9,
anisotropic 4:1, plateau-honed, and graded m = +-0.3. Those with --measured-like resemble measured
maps: spectra to the pixel, noise, spikes, lay on a form, steps, few summits (smooth, steep, blunt),
tapered borders. Ten mean pressures from about 0.1 % to 15 % of contact. Those with --drawn are
drawn at random (drawn.py), those with --textures and --made are textures (textures.py,
made_surfaces.py): eight mean pressures to about 30 % of contact, reference to 1e-4. Those with
--to-the-pixel are isotropic, graded m = +-0.3, and of lay 2:1 and 4:1: six mean pressures to about
25 %, reference to 1e-4. With --hardness each map is pressed with these hardnesses over E* times its
rms slope, to the same contact areas.

The reference is solved on the map refined twice by its own Fourier series: the surface that the
model sees, too. Columns: family, seed, area_fraction (reference, corrected), load_error at equal
separation, area_error at equal load, grid_load and grid_area (boundary elements on the map's own
grid against the reference), separation_error in rms heights, the model's own estimates, and the
quantities that they are made of. --out keeps these rows, one per load point; --csv keeps the table
that the pages show (tables.py): medians and worst errors family by family, or the errors at every
load map by map (--to-the-pixel, --maps).
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from accuracy_tables import LIGHT, families_table, hardness_table, maps_table, plasticity_table
from common import Scene, rough, scenes
from made_surfaces import made_surfaces
from numpy.typing import NDArray
from textures import textures

import asperity
import surfaces
from asperity.contacts.run import solve_contacts
from asperity.halfspace.scene import AREA_OVER_LOAD, area_over_pressure, pressure_scale
from asperity.model.plan import SCALES, make_plan
from asperity.results.storage import write_csv

TOLERANCE = 1e-6
LOADS = np.geomspace(5e-4, 8e-2, 10)
TOLERANCE_MANY = 1e-4
LOADS_MANY = np.geomspace(2.5e-4, 0.16, 8)
LOADS_PIXEL = np.array([2e-3, 8e-3, 1.6e-2, 3.5e-2, 7e-2, 0.13])

RECIPES = {
    f"isotropic H {hurst} cut-off {cutoff} px": {"hurst": hurst, "cutoff": cutoff}
    for hurst, cutoff in ((0.8, 4), (0.8, 8), (0.8, 16), (0.8, 32), (0.5, 8), (0.9, 8))
} | {
    "anisotropic 4:1 cut-off 8 px": {"cutoff": 8, "anisotropy": 4.0},
    "plateau-honed": {},
    "graded m = 0.3": {"cutoff": 8, "m": 0.3},
    "graded m = -0.3": {"cutoff": 8, "m": -0.3},
}
"""The families that the bars are set for, each by what it has of its own."""

TO_THE_PIXEL = {
    "to the pixel H 0.8": {"cutoff": None},
    "to the pixel H 0.5": {"cutoff": None, "hurst": 0.5},
    "to the pixel, graded m = 0.3": {"cutoff": None, "m": 0.3},
    "to the pixel, graded m = -0.3": {"cutoff": None, "m": -0.3},
    "to the pixel, lay 2:1": {"cutoff": None, "anisotropy": 2.0},
    "to the pixel, lay 4:1": {"cutoff": None, "anisotropy": 4.0},
}
"""Families whose waves reach the pixel."""


def surface(points: int, seed: int, recipe: dict[str, float]) -> surfaces.HeightMap:
    """One map of a family, pixel size 1."""
    shape, recipe = (points, points), {k: v for k, v in recipe.items() if k != "m"}
    if not recipe:
        size = (float(points), float(points))
        return surfaces.plateau_honed(shape, size, rms_slope=0.1, cutoff=8.0, seed=seed)
    return rough(shape, seed=seed, **recipe)


def measured_like(points: int, seed: int) -> dict[str, surfaces.HeightMap]:
    """Maps that resemble measured ones, of one seed, pixel size 1."""
    rng = np.random.default_rng(seed)
    shape, size = (points, points + points // 4), (float(points), 1.25 * points)

    def rough(cutoff: float | None, rolloff: float, hurst: float = 0.8) -> surfaces.HeightMap:
        return surfaces.self_affine(
            shape, size, hurst=hurst, rms_slope=0.1, rolloff=rolloff, cutoff=cutoff, seed=seed
        )

    def periodic(heights: NDArray[np.float64]) -> surfaces.HeightMap:
        return surfaces.HeightMap(heights, (1.0, 1.0), periodic=True)

    def tapered(heights: NDArray[np.float64]) -> surfaces.HeightMap:
        return surfaces.prepare(surfaces.HeightMap(heights, (1.0, 1.0)), periodic="taper")

    base = rough(8.0, points / 8)
    rms = base.rms_height
    noise = rng.normal(size=shape)
    spikes = np.where(rng.random(shape) < 3e-4, rng.uniform(0.3, 2.0, shape) * rms, 0.0)
    spikes += 0.5 * sum(np.roll(spikes, 1, axis) + np.roll(spikes, -1, axis) for axis in (0, 1))
    ground = surfaces.ground(shape, size, rms_slope=0.1, cutoff=5.0, seed=seed)
    y, x = (np.linspace(-1, 1, n) for n in shape)
    form = -ground.rms_height * (y[:, None] ** 2 + 0.5 * x**2)
    step = 0.25 * rms
    terraces = step * (np.round(base.heights / step) + 0.2 * noise)
    near = (terraces, *(np.roll(terraces, s, axis) for axis in (0, 1) for s in (1, -1)))
    return {
        "to the pixel H 0.8": rough(None, points / 8),
        "to the pixel H 0.5": rough(None, points / 8, 0.5),
        "cut-off 3 px": rough(3.0, points / 4),
        "noise": periodic(base.heights + rng.uniform(0.01, 0.04) * noise),
        "spikes": periodic(base.heights + spikes),
        "lay on a form, noise": tapered(ground.heights + form + 0.01 * noise),
        "steps": tapered(np.mean(near, axis=0)),
        "few summits": tapered(rough(12.0, float(points)).heights),
        "few summits, fine": tapered(rough(5.0, float(points)).heights),
        "few summits, smooth": tapered(rough(24.0, float(points)).heights),
        "few summits, steep": tapered(_steepened(rough(10.0, float(points)))),
        "few summits, blunt": tapered(-_steepened(rough(10.0, float(points)))),
    }


def _steepened(hm: surfaces.HeightMap) -> NDArray[np.float64]:
    """Heights of a map whose high parts are drawn out and whose low ones are pressed together."""
    return hm.rms_height * np.exp((hm.heights - hm.heights.mean()) / hm.rms_height)


def curves(
    hm: surfaces.HeightMap, body: asperity.HalfSpace, boundary: str | None, args: argparse.Namespace
) -> tuple[asperity.ContactCurve, asperity.ContactCurve]:
    """Boundary elements on the refined map and on the map itself; kept and read back."""
    loads, tolerance = LOADS, TOLERANCE
    if args.to_the_pixel:
        loads, tolerance = LOADS_PIXEL, TOLERANCE_MANY
    elif args.drawn or args.textures or args.made:
        loads, tolerance = LOADS_MANY, TOLERANCE_MANY
    kept = args.references
    fine = surfaces.resample(hm, np.asarray(hm.spacing) / 2)
    out = []
    for grid in (fine, hm):
        path = kept and kept / f"{grid.digest}_{body.m:g}_{body.hardness:.6g}.h5"
        if path and path.exists():
            out.append(asperity.ContactCurve.from_hdf5(path))
            continue
        pressures = AREA_OVER_LOAD * loads / area_over_pressure(hm, body)
        solved = {"pressures": pressures, "tolerance": tolerance, "boundary": boundary}
        out.append(asperity.bem_curve(grid, body, **solved))
        if path:
            out[-1].to_hdf5(path)
    return out[0], out[1]


def rows_of(
    name: str,
    seed: int,
    hm: surfaces.HeightMap,
    body: asperity.HalfSpace,
    boundary: str | None,
    args: argparse.Namespace,
) -> dict[str, list]:
    """Errors of one surface at all loads."""
    reference, own = curves(hm, body, boundary, args)
    start = time.perf_counter()
    ways = {"boundary": boundary, "scales": args.scales}
    plan = make_plan(hm, body, pressures=reference.mean_pressure, **ways)
    model = solve_contacts(hm, body, plan, pressures=reference.mean_pressure).curve
    seconds = time.perf_counter() - start
    same = asperity.contact_curve(hm, body, separations=reference.separation, **ways)
    slope = np.gradient(np.log(reference.mean_pressure), reference.separation)
    n = len(reference)
    table = {
        "family": [name] * n,
        "seed": [seed] * n,
        "points": [hm.shape[0]] * n,
        "area_fraction": reference.area_fraction.tolist(),
        "load_error": (same.mean_pressure / reference.mean_pressure - 1).tolist(),
        "area_error": (model.contact_area / reference.contact_area - 1).tolist(),
        "grid_load": np.expm1(-(own.separation - reference.separation) * slope).tolist(),
        "grid_area": (own.contact_area / reference.contact_area - 1).tolist(),
        "separation_error": ((model.separation - reference.separation) / hm.rms_height).tolist(),
        "estimate": same.error_estimate.tolist(),
        "contacts": same.contacts.tolist(),
        "converged": (same.converged & model.converged).tolist(),
        "certificate": reference.residual.tolist(),
        "seconds": [seconds] * n,
        "plastic_share_found": reference.extra.get("plastic_share", np.zeros(n)).tolist(),
        "filling": (reference.mean_pressure / reference.area_fraction / body.hardness).tolist(),
    }
    return table | {name: np.asarray(v).tolist() for name, v in same.extra.items()}


def extend(table: dict[str, list], more: dict[str, list]) -> None:
    """Add rows to a table; columns that one of them lacks (plastic shares of an elastic body, say)
    are NaN there."""
    held, new = (len(columns.get("seed", [])) for columns in (table, more))
    for column in table | more:
        table[column] = table.get(column, [np.nan] * held) + more.get(column, [np.nan] * new)


def families(seed: int, args: argparse.Namespace) -> dict[str, Callable[[], Scene]]:
    """The families or textures of one seed, or the maps that resemble measured ones."""
    if args.textures:
        return textures(seed, [args.points])
    if args.made:
        return made_surfaces(seed)
    if args.measured_like:
        maps = measured_like(args.points, seed)
        return {name: partial(tuple, (hm, 0.0, None)) for name, hm in maps.items()}

    def scene(recipe: dict[str, float]) -> Scene:
        return surface(args.points, seed, recipe), recipe.get("m", 0.0), None

    recipes = TO_THE_PIXEL if args.to_the_pixel else RECIPES
    return {name: partial(scene, recipe) for name, recipe in recipes.items()}


def main() -> None:
    """Run the families and print one line per surface."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=512)
    parser.add_argument("--seeds", type=int, nargs="+", default=[11, 12])
    parser.add_argument("--families", nargs="*", default=[], help="parts of family names")
    source = parser.add_mutually_exclusive_group()
    source.add_argument("--measured-like", action="store_true", help="maps like measured ones")
    source.add_argument("--drawn", action="store_true", help="maps drawn at random")
    source.add_argument("--textures", action="store_true", help="textures of textures.py")
    source.add_argument("--made", action="store_true", help="made_surfaces.py, on its own grids")
    source.add_argument("--to-the-pixel", action="store_true", help="maps rough to the pixel")
    source.add_argument("--maps", type=Path, help="folder of measured maps, in place of families")
    parser.add_argument(
        "--border", choices=["taper", "smooth", "mirror"], default="taper", help="of measured maps"
    )
    parser.add_argument("--scales", choices=SCALES, default="auto", help="as of asperity curve")
    parser.add_argument(
        "--hardness", type=float, nargs="+", default=[np.inf], help="over E* times rms slope"
    )
    parser.add_argument("--references", type=Path, help="folder that keeps the reference curves")
    parser.add_argument("--out", type=Path, help="one row per load point")
    parser.add_argument("--csv", type=Path, help="the table of the pages")
    parser.add_argument("--plasticity", type=Path, help="what boundary elements find, by hardness")
    args = parser.parse_args()
    collected: dict[str, list] = {}
    for name, seed, hm, m, boundary in scenes(args, partial(families, args=args), args.border):
        table: dict[str, list] = {}
        for hardness in args.hardness:
            body = asperity.HalfSpace.from_modulus(1.0, m=m)
            if hardness < np.inf:
                hard = hardness * pressure_scale(hm, body)
                body = asperity.HalfSpace.from_modulus(1.0, m=m, hardness=hard)
            found = rows_of(name, seed, hm, body, boundary, args)
            found["hardness"] = [hardness] * len(found["seed"])
            extend(table, found)
        extend(collected, table)
        light = np.array(table["area_fraction"]) < LIGHT
        lines = {
            column: np.array(table[column])
            for column in ("load_error", "area_error", "grid_load", "grid_area")
        }
        worst = [100 * np.abs(lines[column][light]).max() for column in lines]
        errors = "  ".join(
            column.replace("_", " ") + " " + " ".join(f"{100 * e:+5.1f}" for e in values)
            for column, values in list(lines.items())[:2]
        )
        print(
            f"{name:32s} seed {seed:3d}  {errors}  worst to 8 %: {worst[0]:.1f} {worst[1]:.1f}  "
            f"(grid {worst[2]:.1f} {worst[3]:.1f})  converged {sum(table['converged'])}  "
            f"{table['seconds'][0]:.2f} s",
            flush=True,
        )
        if args.out:
            write_csv(args.out, collected)
    if args.csv and collected:
        map_by_map = args.to_the_pixel or args.maps
        rows = maps_table(collected, args.scales) if map_by_map else families_table(collected)
        if len(args.hardness) > 1:
            rows = hardness_table(collected)
        if args.plasticity:
            write_csv(args.plasticity, plasticity_table(collected))
        write_csv(args.csv, rows)


if __name__ == "__main__":
    main()
