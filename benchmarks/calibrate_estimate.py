"""Weights of the error estimate: quantiles of the errors, fitted on one set, checked on others.

    python benchmarks/accuracy.py --points 256 --seeds 11 12 13 --out fit.csv
    python benchmarks/accuracy.py --points 256 --seeds 11 12 13 --measured-like --out fit_like.csv
    python benchmarks/accuracy.py --points 256 --seeds 14 15 16 --measured-like \
        --families "few summits" --out fit_few.csv
    python benchmarks/accuracy.py --drawn --seeds 1 2 11 12 13 14 15 16 --out fit_drawn.csv
    python benchmarks/accuracy.py --points 512 --seeds 21 22 31 32 --out check.csv
    python benchmarks/accuracy.py --drawn --seeds 101 102 103 104 --out check_drawn.csv
    python benchmarks/calibrate_estimate.py --fit fit.csv fit_like.csv fit_few.csv fit_drawn.csv \
        --check check.csv check_drawn.csv
    python benchmarks/calibrate_estimate.py --check check.csv check_drawn.csv \
        --csv docs/development/data/estimate_judged.csv    # table of the pages, a row per file

Minimizes the pinball loss of quantile regression over non-negative weights (a linear program), so
that a share QUANTILE of the errors lies inside the estimate. The error of a point is the larger of
those against boundary elements on the map's own grid and on the refined one.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import numpy as np
from scipy.optimize import linprog

from asperity.parameters import DEFAULTS
from asperity.results.storage import write_csv
from asperity.trust.error_estimate import TERMS, estimate

FITTED = DEFAULTS.error_estimate

QUANTILE = 0.965


def columns(path: str) -> dict[str, np.ndarray]:
    """Converged rows of a file of ``accuracy.py``."""
    with open(path, newline="") as handle:
        rows = [row for row in csv.DictReader(handle) if row["converged"] == "True"]
    return {
        name: np.array([row[name] for row in rows])
        if name in ("family", "converged")
        else np.array([float(row[name]) for row in rows])
        for name in rows[0]
    }


def error(data: dict[str, np.ndarray], kind: str) -> np.ndarray:
    """Larger of the errors against the refined map and against the map's own grid."""
    refined = data[f"{kind}_error"]
    own = (1 + refined) / (1 + data[f"grid_{kind}"]) - 1
    return np.maximum(np.abs(refined), np.abs(own))


def fit(terms: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Non-negative weights w that minimize the pinball loss of errors - terms @ w."""
    n, k = terms.shape
    cost = np.concatenate([np.zeros(k), np.full(n, QUANTILE), np.full(n, 1 - QUANTILE)])
    equality = np.hstack([terms, np.eye(n), -np.eye(n)])
    found = linprog(cost, A_eq=equality, b_eq=errors, bounds=(0, None), method="highs")
    return found.x[:k]


def matrix(data: dict[str, np.ndarray]) -> np.ndarray:
    """Terms of the points, shape (n, terms)."""
    return np.column_stack([data[term] for term in TERMS])


def main() -> None:
    """Print the weights and the share of errors inside, set by set and family by family."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fit", nargs="+", default=[], help="files to fit the weights on")
    parser.add_argument("--check", nargs="+", default=[], help="files to judge them on")
    parser.add_argument("--csv", type=Path, help="the table of the pages")
    args = parser.parse_args()
    sets = {path: columns(path) for path in (*args.fit, *args.check)}
    table: dict[str, list] = {
        "set": [Path(path).stem for path in sets],
        "points": [len(data["family"]) for data in sets.values()],
    }
    for kind, present in (("load", FITTED.load_weights), ("area", FITTED.area_weights)):
        weights = np.array(present)
        if args.fit:
            weights = fit(
                np.vstack([matrix(sets[path]) for path in args.fit]),
                np.concatenate([error(sets[path], kind) for path in args.fit]),
            )
            print(kind, "weights", tuple(round(float(w), 4) for w in weights))
        figures: list[tuple[str, str, str]] = []
        for path, data in sets.items():
            true, terms = error(data, kind), matrix(data)
            stated = estimate(dict(zip(TERMS, terms.T, strict=True)), tuple(weights), FITTED)
            shares = (np.mean(true <= stated), np.median(stated), np.median(true))
            figures.append(tuple(f"{100 * share:.1f}" for share in shares))
            print(
                f"  {path}: {np.mean(true <= stated):.3f} of {len(true)} inside, "
                f"median stated {np.median(stated):.3f}, median error {np.median(true):.3f}"
            )
            for family in np.unique(data["family"]):
                of = data["family"] == family
                print(
                    f"    {family:32s} {np.mean(true[of] <= stated[of]):.2f}   "
                    f"stated {np.median(stated[of]):.3f}   error {np.median(true[of]):.3f}"
                )
        for name, column in zip(("inside", "stated", "true"), np.transpose(figures), strict=True):
            table[f"{kind}: {name}, %"] = column.tolist()
    if args.csv:
        write_csv(args.csv, table)


if __name__ == "__main__":
    main()
