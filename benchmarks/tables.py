"""Write the tables of the pages from the CSV files that the benchmarks made.

    python benchmarks/tables.py            # rewrite every table of README.md and docs/
    python benchmarks/tables.py --check    # write nothing; exit code 1 if a page would change

A page shows docs/development/data/NAME.csv between the lines ``<!-- table:NAME -->`` and
``<!-- end -->``. The table is the file: the first row is the heading, each cell is as it stands.
"""

from __future__ import annotations

import argparse
import csv
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT / "docs" / "development" / "data"
MARKED = re.compile(r"(<!-- table:(\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def pages() -> list[Path]:
    """Every page that may show a table."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def table(name: str) -> str:
    """Markdown of one CSV file."""
    with (DATA / f"{name}.csv").open(newline="", encoding="utf-8") as file:
        heading, *rows = csv.reader(file)
    lines = [f"| {' | '.join(cells)} |\n" for cells in (heading, *rows)]
    return "".join([lines[0], "|---" * len(heading), "|\n", *lines[1:]])


def filled(text: str) -> str:
    """Text of a page with its tables written anew."""
    return MARKED.sub(lambda found: found[1] + table(found[2]) + found[3], text)


def main(check: bool) -> int:
    """Write the pages, or count those that would change."""
    changed = 0
    for page in pages():
        text = page.read_text(encoding="utf-8")
        if filled(text) != text:
            changed += 1
            print(page.relative_to(ROOT))
            if not check:
                page.write_text(filled(text), encoding="utf-8")
    return int(check and changed > 0)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing")
    sys.exit(main(parser.parse_args().check))
