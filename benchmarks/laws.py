"""Time and error of the law tables: 11 000 summits of a rough map at 50 approaches.

    python benchmarks/laws.py [law ...]

Microseconds per profile on the threads that numba has, without compilation, least of several
runs: the fit of the profiles, the table of the law, its evaluation at 50 approaches, and their
sum, with its share of the bar. The error is that of the table against one ten times finer (force,
at contacts without flag).
"""

from __future__ import annotations

import numpy as np
from common import least, machine, options, rough

import surfaces
from asperity import HalfSpace
from asperity.microcontact import tabulate
from asperity.microcontact.law_table import LazyTable
from asperity.microcontact.laws import LAWS
from asperity.microcontact.ray_laws import tabulate_expansion

BAR = 20.0
"""Microseconds per profile that fit, table and evaluation may take together."""
SLOW = "auto", "ritz"
"""Laws that press basins or minimize: they are measured by name alone."""
SHARES = np.linspace(0.02, 1.0, 50) ** 2


def main(laws: list[str]) -> None:
    """Print one row per law and grading."""
    hm = rough((1024, 1024), 4.0, 1)
    peaks = surfaces.segment(hm)
    profiles = surfaces.fit_profiles(hm, peaks)
    n = len(profiles)
    fit = least(lambda: surfaces.fit_profiles(hm, peaks)) / n * 1e6
    print(f"{machine()}, {n} profiles, seed 1")
    print(f"law        m    fit  table  evaluate    sum [us per profile; bar {BAR:g}]")
    rows = np.arange(n)[:, None]
    for law in laws:
        for m in (0.0, 0.3):
            material = HalfSpace.from_modulus(1.0, m)
            table = tabulate(profiles, material, law=law)
            depth = table.reach[:, None] * SHARES
            made = least(lambda: tabulate(profiles, material, law=law)) / n * 1e6  # noqa: B023
            read = least(lambda: table.evaluate(rows, depth)) / n * 1e6  # noqa: B023
            total = fit + made + read
            error = ""
            if law in ("paper", "harmonic"):
                fine = tabulate_expansion(
                    profiles, material, law=law, nodes=64, radii=96, points=64
                )
                some = depth[:, 10:40:10]
                good = (LazyTable.of(fine).flags_at(rows, some) & 3) == 0
                change = table.evaluate(rows, some)[0] / fine.evaluate(rows, some)[0] - 1
                values = np.abs(change[good])
                error = f"error {np.median(values):.1e}, 95 % {np.percentile(values, 95):.1e}"
            print(
                f"{law:9} {m:3.1f} {fit:6.1f} {made:6.1f} {read:9.1f} {total:6.1f}"
                f"  {'within' if total <= BAR else 'ABOVE'} {total / BAR:5.2f}  {error}"
            )


if __name__ == "__main__":
    parser = options(__doc__)
    parser.add_argument("laws", nargs="*", default=[law for law in LAWS if law not in SLOW])
    main(parser.parse_args().laws)
