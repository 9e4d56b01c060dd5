"""Weights of the error estimate: quantiles of the errors, fitted on one set, checked on another.

    python benchmarks/accuracy.py --points 256 --seeds 11 12 13 --out fit.csv
    python benchmarks/accuracy.py --points 512 --seeds 21 22 --out check.csv
    python benchmarks/calibrate_estimate.py fit.csv check.csv

Minimizes the pinball loss of quantile regression over non-negative weights (a linear program), so
that a share QUANTILE of the errors lies inside the estimate.
"""

from __future__ import annotations

import csv
import sys

import numpy as np
from scipy.optimize import linprog

from asperity.error_estimate import TERMS

QUANTILE = 0.95


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


def fit(terms: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Non-negative weights w that minimize the pinball loss of error - terms @ w."""
    n, k = terms.shape
    cost = np.concatenate([np.zeros(k), np.full(n, QUANTILE), np.full(n, 1 - QUANTILE)])
    equality = np.hstack([terms, np.eye(n), -np.eye(n)])
    found = linprog(cost, A_eq=equality, b_eq=error, bounds=(0, None), method="highs")
    return found.x[:k]


def main() -> None:
    """Print the weights and the share of errors inside, on both sets."""
    sets = [columns(path) for path in sys.argv[1:3]]
    for name in ("load_error", "area_error"):
        weights = None
        for label, data in zip(("fit", "check"), sets, strict=False):
            terms = np.column_stack([data[term] for term in TERMS])
            error = np.abs(data[name])
            if weights is None:
                weights = fit(terms, error)
                print(name, "weights", tuple(round(float(w), 4) for w in weights))
            stated = terms @ weights
            print(
                f"  {label}: {np.mean(error <= stated):.3f} of {len(error)} inside, "
                f"median stated {np.median(stated):.3f}, median error {np.median(error):.3f}"
            )
            for family in np.unique(data["family"]):
                of = data["family"] == family
                print(f"    {family:32s} {np.mean(error[of] <= stated[of]):.2f}")


if __name__ == "__main__":
    main()
