"""Errors of the single-contact laws and of the errors they expect, against boundary elements.

    python benchmarks/single_contacts.py                   # the set that fixed nothing
    python benchmarks/single_contacts.py --set fit         # the set the factors were chosen on
    python benchmarks/single_contacts.py --harmonics       # third and fourth harmonics, every ratio
    python benchmarks/single_contacts.py --csv docs/development/data/law_estimates.csv
    python benchmarks/single_contacts.py --harmonics \\
        --csv docs/development/data/single_harmonics.csv

Sections: polygonal, rounded and irregular bodies r^k psi(phi) of several k and m. Summits: local
peaks cut from self-affine maps, pressed to two depths inside their basins. The two sets differ in
every seed. For each law and kind: the share of contacts whose error of the force lies inside the
error that the law expects of itself (plus the change of the boundary elements on the coarser
grid), root mean square and largest errors of force and area in percent. --csv keeps the table that
the pages show.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import comb
from pathlib import Path
from typing import Any

import numpy as np
from scipy.ndimage import label

import surfaces
from asperity import HalfSpace, indent
from asperity.bem.single import BemIndentation, indent_bem
from asperity.errors import AsperityError
from asperity.microcontact.hertz import elliptic_contact
from asperity.microcontact.single.indent import SOLVERS
from asperity.results.storage import write_csv
from surfaces import PolynomialProfile, shapes

SEEDS = {"fit": 100, "check": 500}
GRADINGS = (-0.3, 0.0, 0.3, 0.5)
HARMONICS = {"third": (0.2, 0.0), "fourth": (0.0, 0.2), "both": (0.2, 0.2)}
"""Shares of the third and the fourth harmonic of the gap."""
FAMILIES = (
    {"cutoff": 10.0, "hurst": 0.8},
    {"cutoff": 6.0, "hurst": 0.5},
    {"cutoff": 16.0, "hurst": 0.8},
    {"cutoff": 8.0, "hurst": 0.8, "anisotropy": 4.0},
)


@dataclass(frozen=True)
class Contact:
    """One profile to be pressed."""

    kind: str
    profile: Any
    m: float
    depth: float


def sections(seed: int, count: int) -> Iterator[Contact]:
    """Bodies ``r^k psi(phi)`` of all kinds."""
    rng = np.random.default_rng(seed)
    for i in range(count):
        k, m = float(rng.choice([1.0, 1.5, 2.0])), float(rng.choice(GRADINGS))
        if i % 4 == 0:
            body = shapes.random_polygon(k, sides=int(rng.integers(4, 9)), seed=seed + i)
        elif i % 4 == 1:
            corner = float(rng.uniform(0.1, 0.6))
            body = shapes.rounded_polygon(int(rng.integers(3, 7)), k, corner=corner)
        else:
            deviation = float(rng.uniform(0.03, 0.15))
            body = shapes.random_section(k, deviation=deviation, seed=seed + i)
        yield Contact("sections", body, m, 1.0)


def summits(seed: int, count: int) -> Iterator[Contact]:
    """Summits of self-affine maps, at two depths inside their basins."""
    rng = np.random.default_rng(seed)
    for j, family in enumerate(FAMILIES):
        hm = surfaces.self_affine(
            (256, 240), (256.0, 250.0), rms_slope=0.1, rolloff=64.0, seed=seed + j, **family
        )
        peaks = surfaces.segment(hm)
        profiles = surfaces.fit_profiles(hm, peaks, rays=32, nodes=33)
        good = np.flatnonzero(profiles.valid & (profiles.pixels >= 40))
        for i in rng.permutation(good)[: count // (2 * len(FAMILIES))]:
            low = float(np.min(profiles.q[i, :, -1] * profiles.edge[i] ** 2))
            m = float(rng.choice(GRADINGS))
            for share in (0.3, 0.8):
                yield Contact("summits", profiles.profile(int(i)), m, share * low)


def reference(contact: Contact, grid: int) -> tuple[BemIndentation, float] | None:
    """Boundary elements and their relative change from the coarser grid; None if unusable."""
    material = HalfSpace.from_modulus(1.0, contact.m)
    fine, coarse = (
        indent_bem(contact.profile, material, contact.depth, grid=n, tolerance=1e-5)
        for n in (grid, 2 * grid // 3)
    )
    whole = label(fine.solutions[-1].contact, np.ones((3, 3)))[1] == 1
    if not (fine.valid and whole):
        return None
    return fine, abs(float(coarse.force / fine.force - 1))


def judge(contacts: list[Contact], grid: int) -> dict[str, list[str]]:
    """Print the share inside and the errors, law by law; return the table of the pages."""
    rows: dict[tuple[str, str], list[tuple[float, float, float, bool, bool]]] = {}
    used = 0
    for contact in contacts:
        found = reference(contact, grid)
        if found is None:
            continue
        used += 1
        truth, uncertainty = found
        material = HalfSpace.from_modulus(1.0, contact.m)
        for law in SOLVERS:
            try:
                one = indent(contact.profile, material, contact.depth, law=law)
            except AsperityError:
                continue
            if not (one.valid and np.isfinite(one.force)):
                continue
            error = abs(float(one.force / truth.force) - 1)
            inside = error <= float(one.error_estimate) + uncertainty
            area = abs(float(one.contact_area / truth.contact_area) - 1)
            flagged = bool(np.any(one.flags))
            row = (error, area, float(one.error_estimate), inside, flagged)
            for kind in (contact.kind, "all"):
                rows.setdefault((law, kind), []).append(row)
    print(f"{used} of {len(contacts)} contacts usable, grid {grid}")
    print(
        "law        kind        n  inside %   e_F rms  largest   e_A rms  largest  estimate rms %"
    )
    for (law, kind), values in sorted(rows.items()):
        error, area, expected, inside, _ = np.array(values).T
        print(
            f"{law:10} {kind:9} {inside.size:4d} {100 * inside.mean():8.1f}  "
            f"{100 * rms(error):8.3f} {100 * error.max():8.2f}  "
            f"{100 * rms(area):8.2f} {100 * area.max():8.2f}  {100 * rms(expected):8.3f}"
        )
    return _estimates({key: np.array(values) for key, values in rows.items()})


def _estimates(rows: dict[tuple[str, str], np.ndarray]) -> dict[str, list[str]]:
    """Share inside and rms errors of the force, one row per law; empty where no contact is left."""
    laws = [law for law in SOLVERS if law != "auto"]
    table = {"law": [f"`{law}`" for law in laws]}

    def column(kind: str, figure: Callable[[np.ndarray], str], unflagged: bool) -> list[str]:
        chosen = (rows.get((law, kind), np.empty((0, 5))) for law in laws)
        parts = (part[part[:, 4] == 0] if unflagged else part for part in chosen)
        return [figure(part) if len(part) else "" for part in parts]

    for name, figure, unflagged in (
        ("{} inside", lambda part: f"{100 * part[:, 3].mean():.0f} %", False),
        ("force error of {}, rms, %", lambda part: f"{100 * rms(part[:, 0]):.2g}", False),
        ("{} without flag, rms, %", lambda part: f"{100 * rms(part[:, 0]):.2g}", True),
    ):
        for kind in ("sections", "summits"):
            table[name.format(kind)] = column(kind, figure, unflagged)
    return table


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values * values)))


def wave(n: int, amplitude: float, phase: float, a: float, b: float) -> dict:
    """Terms of ``amplitude rho^n cos(n t + phase)`` on the ellipse of semi-axes a, b."""
    turned = amplitude * np.exp(1j * phase)
    return {
        (n - j, j): float((comb(n, j) * 1j**j * turned).real) / (a ** (n - j) * b**j)
        for j in range(n + 1)
    }


def summed(*parts: dict) -> dict:
    """Sum of polynomials."""
    return {key: sum(p.get(key, 0.0) for p in parts) for key in {k for p in parts for k in p}}


def waved(ratio: float, m: float, third: float, fourth: float, phases: tuple[float, float]) -> Any:
    """Paraboloid with shares of the third and fourth harmonic of its gap at the edge.

    As in the study that set the bar: a quartic of 0.05 goes with a third harmonic of 0.2, and one
    of the same size with a fourth, so that the gap keeps rising.
    """
    material = HalfSpace.from_modulus(1.0, m)
    k1, k2 = np.sqrt(ratio), 1 / np.sqrt(ratio)
    contact = elliptic_contact(k1, k2, 1.0, material)
    a, b = float(contact.semi_major), float(contact.semi_minor)
    e = 0.25 * (k2 * a * a + k1 * b * b)
    quartic = e * (0.25 * third + fourth)
    around = {(4, 0): quartic / a**4, (2, 2): 2 * quartic / (a * b) ** 2, (0, 4): quartic / b**4}
    terms = summed(
        {(2, 0): 0.5 * k2, (0, 2): 0.5 * k1},
        wave(3, e * third, phases[0], a, b),
        wave(4, e * fourth, phases[1], a, b),
        around,
    )
    return PolynomialProfile(terms), material, (a, b)


@dataclass(frozen=True)
class Walled:
    """A profile with a wall where the gap of a polynomial need no longer rise."""

    profile: Any
    axes: tuple[float, float]
    start: float = 1.8
    radius: float = np.inf

    def __call__(self, r: Any, phi: Any) -> np.ndarray:
        """Gap [m]."""
        r, phi = np.broadcast_arrays(np.asarray(r, float), np.asarray(phi, float))
        rho = r * np.hypot(np.cos(phi) / self.axes[0], np.sin(phi) / self.axes[1])
        over = np.maximum(rho - self.start, 0.0)
        held = r / np.maximum(rho / self.start, 1.0)
        return np.asarray(np.maximum(self.profile(held, phi), 0.0) + 2 * over)


def harmonics(grid: int) -> dict[str, list[str]]:
    """Print the errors of `ellipse` for third and fourth harmonics; the table of the pages."""
    largest: dict[str, list[str]] = {"m": [], "curvature ratio": []}
    largest |= {
        f"{kind} error: {which}, %": [] for kind in ("force", "area") for which in HARMONICS
    }
    rng = np.random.default_rng(7)
    some = [(0.4, 0.9), (0.0, 0.0), *(tuple(rng.uniform(0, 2 * np.pi, 2)) for _ in range(2))]
    print("m     ratio  third fourth    e_F %  worst    e_A %  worst   estimate %  BEM grid %")
    for m in (0.0, 0.5, -0.3):
        for ratio in (1.0, 3.0, 10.0):
            largest["m"].append(f"{m:g}")
            largest["curvature ratio"].append(f"{ratio:g}")
            for which, (third, fourth) in HARMONICS.items():
                rows = []
                for phases in some:
                    body, material, axes = waved(ratio, m, third, fourth, phases)
                    walled = Walled(body, axes)
                    fine, coarse = (
                        indent_bem(walled, material, 1.0, grid=n, tolerance=1e-5)
                        for n in (grid, grid // 2)
                    )
                    if label(fine.solutions[-1].contact, np.ones((3, 3)))[1] > 1:
                        continue
                    one = indent(body, material, 1.0, law="ellipse")
                    rows.append(
                        (
                            float(one.force / fine.force) - 1,
                            float(one.contact_area / fine.contact_area) - 1,
                            float(one.error_estimate),
                            float(coarse.force / fine.force) - 1,
                        )
                    )
                force, area, expected, change = 100 * np.array(rows).T
                largest[f"force error: {which}, %"].append(f"{np.abs(force).max():.2g}")
                largest[f"area error: {which}, %"].append(f"{np.abs(area).max():.1f}")
                print(
                    f"{m:4.1f} {ratio:6.0f} {third:6.1f} {fourth:6.1f} {force[0]:8.3f}"
                    f" {np.abs(force).max():6.3f} {area[0]:8.2f} {np.abs(area).max():6.2f}"
                    f" {expected.max():10.2f} {np.abs(change).max():10.3f}",
                    flush=True,
                )
    return largest


def main() -> None:
    """Read the options and print one of the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--set", choices=tuple(SEEDS), default="check", dest="which")
    parser.add_argument("--count", type=int, default=72, help="sections, and as many summits")
    parser.add_argument("--grid", type=int, default=96, help="points per axis (default 96)")
    parser.add_argument("--harmonics", action="store_true", help="the bar of `ellipse` instead")
    parser.add_argument("--csv", type=Path, help="the table of the pages")
    args = parser.parse_args()
    if args.harmonics:
        table = harmonics(max(args.grid, 128))
    else:
        seed = SEEDS[args.which]
        table = judge([*sections(seed, args.count), *summits(seed, args.count)], args.grid)
    if args.csv:
        write_csv(args.csv, table)


if __name__ == "__main__":
    main()
