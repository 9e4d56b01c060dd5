"""What is said of each constant: its sensitivity is that of the committed table."""

from __future__ import annotations

import csv
import inspect
import re
from collections import defaultdict
from dataclasses import fields
from pathlib import Path

import pytest

from asperity.parameters import DEFAULTS, ENGINE

ROWS = Path(__file__).parents[2] / "docs" / "development" / "sensitivity.csv"
GROUPS = {**vars(DEFAULTS), **vars(ENGINE)}


def entries(group: str) -> dict[tuple[str, ...], str]:
    """Names of the constants of each entry in the docstring of a group, and what it says."""
    found: dict[tuple[str, ...], str] = {}
    for line in (inspect.getdoc(type(GROUPS[group])) or "").splitlines():
        if re.fullmatch(r"[a-z_]+(, [a-z_]+)*", line):
            names = tuple(line.split(", "))
            found[names] = ""
        elif found:
            found[names] += f" {line.strip()}"
    return found


@pytest.mark.parametrize("group", GROUPS)
def test_every_constant_is_described(group):
    described = {name for names in entries(group) for name in names}
    assert described == {field.name for field in fields(GROUPS[group])}


def test_the_sensitivities_are_those_of_the_table():
    """The largest change of load and area by a quarter, from a tenth of a percent on."""
    changes = defaultdict(lambda: [0.0, 0.0])
    with ROWS.open() as file:
        for row in csv.DictReader(file):
            now = (100.0 * float(row[f"{kind}_change"]) for kind in ("load", "area"))
            known = changes[row["constant"]]
            changes[row["constant"]] = [max(pair) for pair in zip(known, now, strict=True)]
    for group in GROUPS:
        for names, text in entries(group).items():
            load, area = map(max, zip(*(changes[f"{group}.{name}"] for name in names), strict=True))
            matters = max(load, area) >= 0.1
            stated = f"(25 %: load {load:.1f} %, area {area:.1f} %.)" if matters else ""
            assert text.count("(25 %") == matters and stated in text, (group, names, stated)
