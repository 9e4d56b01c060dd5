"""Tables that the pages show, made from the rows of accuracy.py: by family, by map, by hardness."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

LIGHT = 0.08
"""Area fraction up to which the errors of families are stated apart."""
METAL = 0.0045, 0.11
"""Area fractions between which errors with a hardness are stated."""


def families_table(rows: dict[str, list]) -> dict[str, list]:
    """Errors family by family [%] of the points that both solved: median and worst to LIGHT of
    contact, worst beyond."""
    families, light = np.array(rows["family"]), np.array(rows["area_fraction"]) < LIGHT
    table: dict[str, list] = {"family": list(dict.fromkeys(rows["family"]))}
    errors = {name: 100 * np.abs(rows[f"{name}_error"]) for name in ("load", "area")}

    def column(error: NDArray[np.float64], part: NDArray[np.bool_], statistic: Callable) -> list:
        chosen = (error[(families == name) & part] for name in table["family"])
        return [f"{statistic(values):.1f}" if len(values) else "" for values in chosen]

    for name, error in errors.items():
        table[f"{name} error: median, %"] = column(error, light, np.nanmedian)
        table[f"{name} error: worst, %"] = column(error, light, np.nanmax)
    for name, error in errors.items():
        table[f"{name} error beyond 8 %: worst, %"] = column(error, ~light, np.nanmax)
    return table


def maps_table(rows: dict[str, list], scales: str) -> dict[str, list]:
    """Errors map by map [%], at every load."""
    maps = list(dict.fromkeys(zip(rows["family"], rows["seed"], strict=True)))
    table: dict[str, list] = {"map": [name for name, _ in maps]}
    if any(seed for _, seed in maps):
        table["seed"] = [seed for _, seed in maps]
        table["scales"] = ["default" if scales == "auto" else scales] * len(maps)
    keys = list(zip(rows["family"], rows["seed"], strict=True))
    for quantity in ("load", "area"):
        values = list(zip(keys, rows[f"{quantity}_error"], strict=True))
        table[f"{quantity} error, %"] = [
            " ".join(f"{100 * error:+.1f}" for key, error in values if key == one) for one in maps
        ]
    return table


def hardness_table(rows: dict[str, list]) -> dict[str, list]:
    """Worst errors of load and area [%] by family and hardness, within `METAL` of contact."""
    families, hardness = np.array(rows["family"]), np.array(rows["hardness"])
    area = np.array(rows["area_fraction"])
    inside = (area > METAL[0]) & (area < METAL[1])
    table: dict[str, list] = {"family": list(dict.fromkeys(rows["family"]))}
    for value in dict.fromkeys(rows["hardness"]):
        table[f"H/(E* h') = {value:g}"] = [
            " / ".join(
                f"{100 * np.abs(np.array(rows[name])[chosen]).max():.1f}"
                for name in ("load_error", "area_error")
            )
            for chosen in (inside & (families == f) & (hardness == value) for f in table["family"])
        ]
    return table


def plasticity_table(rows: dict[str, list]) -> dict[str, list]:
    """What boundary elements find at each plasticity index, within `METAL` of contact."""
    hardness, area = np.array(rows["hardness"]), np.array(rows["area_fraction"])
    chosen = (area > METAL[0]) & (area < METAL[1])
    chosen &= np.array(["isotropic" in name for name in rows["family"]])
    table: dict[str, list] = {"E* h'/H": [], "plastic share of the area": [], "A H/P": []}
    for value in sorted(set(rows["hardness"])):
        share, over = (
            np.quantile(np.array(values)[chosen & (hardness == value)], [0.1, 0.9])
            for values in (rows["plastic_share_found"], 1.0 / np.array(rows["filling"]))
        )
        for name, text in zip(
            table,
            (
                f"{1 / value:g}",
                f"{share[0]:.2f} to {share[1]:.2f}",
                f"{over[0]:.2f} to {over[1]:.2f}",
            ),
            strict=True,
        ):
            table[name].append(text)
    return table
