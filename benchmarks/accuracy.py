"""Error of the microcontact model against certified boundary elements, family by family.

    python benchmarks/accuracy.py --points 512 --seeds 11 12 --out rows.csv

Families: isotropic with the cut-off at 4, 8, 16, 32 pixels and Hurst exponents 0.5, 0.8, 0.9,
anisotropic 4:1, plateau-honed, and graded m = +-0.3.  Ten mean pressures from about 0.1 % to 15 %
of contact.  Columns: family, seed, area_fraction (boundary elements, corrected), load_error at
equal separation, area_error at equal load, separation_error in rms heights, the model's own
estimate, and the quantities that the estimate is made of.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

import asperity
import surfaces
from asperity.curve import solve_contacts
from asperity.loadpoints import pressure_scale
from asperity.plan import make_plan
from asperity.storage import write_csv

TOLERANCE = 1e-6
LOADS = np.geomspace(5e-4, 8e-2, 10)


def families(points: int) -> dict[str, dict]:
    """Recipes of the surfaces, pixel size 1."""
    size = (float(points), float(points))

    def rough(hurst: float, cutoff: float, **more: float) -> dict:
        return dict(
            size=size, hurst=hurst, rms_slope=0.1, rolloff=points / 8, cutoff=cutoff, **more
        )

    recipes = {
        f"isotropic H {hurst} cut-off {cutoff} px": rough(hurst, cutoff)
        for hurst, cutoff in ((0.8, 4), (0.8, 8), (0.8, 16), (0.8, 32), (0.5, 8), (0.9, 8))
    }
    recipes["anisotropic 4:1 cut-off 8 px"] = rough(0.8, 8, anisotropy=4.0)
    recipes["plateau-honed"] = dict(plateau=True)
    recipes["graded m = 0.3"] = dict(m=0.3, **rough(0.8, 8))
    recipes["graded m = -0.3"] = dict(m=-0.3, **rough(0.8, 8))
    return recipes


def surface(points: int, seed: int, recipe: dict) -> surfaces.HeightMap:
    """One map of a family."""
    recipe = {k: v for k, v in recipe.items() if k != "m"}
    if recipe.pop("plateau", False):
        return surfaces.plateau_honed(
            (points, points), (float(points),) * 2, rms_slope=0.1, cutoff=8.0, seed=seed
        )
    return surfaces.self_affine((points, points), seed=seed, **recipe)


def rows_of(name: str, recipe: dict, points: int, seed: int) -> dict[str, list]:
    """Errors of one surface at all loads."""
    hm = surface(points, seed, recipe)
    body = asperity.HalfSpace.from_modulus(1.0, m=recipe.get("m", 0.0))
    reference = asperity.bem_curve(
        hm, body, pressures=LOADS * pressure_scale(hm, body), tolerance=TOLERANCE
    )
    start = time.perf_counter()
    plan = make_plan(hm, body, pressures=reference.mean_pressure)
    model = solve_contacts(hm, body, plan, pressures=reference.mean_pressure).curve
    seconds = time.perf_counter() - start
    same = asperity.contact_curve(hm, body, separations=reference.separation)
    n = len(reference)
    table = {
        "family": [name] * n,
        "seed": [seed] * n,
        "points": [points] * n,
        "area_fraction": reference.area_fraction.tolist(),
        "load_error": (same.mean_pressure / reference.mean_pressure - 1).tolist(),
        "area_error": (model.contact_area / reference.contact_area - 1).tolist(),
        "separation_error": ((model.separation - reference.separation) / hm.rms_height).tolist(),
        "estimate": same.error_estimate.tolist(),
        "contacts": same.contacts.tolist(),
        "converged": (same.converged & model.converged).tolist(),
        "certificate": reference.residual.tolist(),
        "seconds": [seconds] * n,
    }
    return table | {name: np.asarray(v).tolist() for name, v in same.extra.items()}


def main() -> None:
    """Run the families and print one line per surface."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=512)
    parser.add_argument("--seeds", type=int, nargs="+", default=[11, 12])
    parser.add_argument("--families", nargs="*", default=[], help="parts of family names")
    parser.add_argument("--out", type=Path)
    args = parser.parse_args()
    collected: dict[str, list] = {}
    for name, recipe in families(args.points).items():
        if args.families and not any(part in name for part in args.families):
            continue
        for seed in args.seeds:
            table = rows_of(name, recipe, args.points, seed)
            for column, values in table.items():
                collected.setdefault(column, []).extend(values)
            area = np.array(table["area_fraction"])
            light = area < 0.08
            worst = [
                100 * np.abs(np.array(table[column])[light]).max()
                for column in ("load_error", "area_error")
            ]
            print(
                f"{name:32s} seed {seed:3d}  load "
                + " ".join(f"{100 * e:+5.1f}" for e in table["load_error"])
                + "  area "
                + " ".join(f"{100 * e:+5.1f}" for e in table["area_error"])
                + f"  worst to 8 %: {worst[0]:.1f} {worst[1]:.1f}  {table['seconds'][0]:.2f} s",
                flush=True,
            )
    if args.out:
        write_csv(args.out, collected)


if __name__ == "__main__":
    main()
