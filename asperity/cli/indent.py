"""``asperity indent``: one contact by every law, with an optional boundary-element check."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from asperity.cli import options, output
from asperity.errors import InputError

EPILOG = """shapes:
  polygon:N   cosine:N   rounded:N:CORNER   ellipse:RATIO   cone   paraboloid
  random:DEVIATION:SEED   convex:SIDES:SEED   bent
examples:
  asperity indent --shape polygon:4 --k 1 --m 0.3 --bem
  asperity indent --shape rounded:3:0.3 --k 2 --modulus 1e9 --approach 1e-7 --scale 1e5
  asperity indent --shape polygon:4 --m 0.3 --load 1 --bem  # compared at equal load
  asperity indent profile.h5 --E 210e9 --nu 0.3 --approach 1e-8:1e-7:5
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity indent``."""
    parser.epilog = EPILOG
    parser.add_argument("file", nargs="?", help="profile file, or a map whose highest peak is used")
    parser.add_argument("--shape", help="a test body in place of a file, see below")
    parser.add_argument("--k", type=float, default=1.0, help="exponent of r (default 1)")
    parser.add_argument("--scale", type=float, default=1.0, help="factor of the gap (default 1)")
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--approach", metavar="D", help="approaches [m]: D, D1,D2 or LO:HI:N")
    group.add_argument("--load", metavar="F", help="normal forces [N] in place of approaches")
    parser.add_argument("--law", metavar="NAMES", help="laws, comma-separated (default all)")
    parser.add_argument("--bem", action="store_true", help="solve by boundary elements as well")
    parser.add_argument("--grid", type=int, default=256, help="points per axis (default 256)")
    options.add_tolerance_option(parser)
    parser.add_argument(
        "--picture",
        default="indent.png",
        metavar="FILE",
        help="picture of the last contact (default indent.png; 'none' for none)",
    )
    options.add_material_options(parser)


def run(args: argparse.Namespace) -> int:
    """Solve every contact, print one table each and draw the last."""
    from asperity.comparison.single import draw_case, judge

    profile, label = _profile(args)
    material = _material(args)
    laws = _laws(args.law)
    picture = None if args.picture == "none" else args.picture
    output.require_outputs(picture, inputs=[args.file] if args.file else [])
    grid = args.grid if args.bem else None
    good, case = True, None
    name, values = _driven(args, profile)
    sign, unit = ("d", "m") if name == "approach" else ("F", "N")
    for value in values:
        driven = {name: value}
        case = judge(profile, material, **driven, laws=laws, grid=grid, tolerance=args.tolerance)
        head = f"{label}   m = {material.m:g}   E* = {material.modulus:.6g}"
        print(f"{head}   {sign} = {value:.6g} {unit}")
        print(case.table() + "\n")
        good &= case.reference is None or bool(case.reference.converged)
        good &= any(row.solution is not None and row.solution.valid for row in case.rows)
    if picture and case is not None:
        output.save_figure(draw_case(case, title=label), picture)
        print(f"picture: {picture}")
    return 0 if good else 1


def _profile(args: argparse.Namespace) -> tuple[Any, str]:
    if (args.file is None) == (args.shape is None):
        raise InputError("give either a profile file or --shape")
    if args.file is not None:
        from surfaces.files.profile_file import read_profile

        return read_profile(args.file), Path(args.file).name
    body = _shape(args.shape, args.k, args.scale)
    named = "" if args.shape in ("cone", "paraboloid", "bent") else f", k = {args.k:g}"
    return body, args.shape + named


def _shape(text: str, k: float, scale: float) -> Any:
    """Test body from its name and numbers, such as ``rounded:4:0.3``."""
    from surfaces import PowerLawProfile, PowerSumProfile, shapes

    name, *rest = text.split(":")
    if not (np.isfinite(scale) and scale > 0):
        raise InputError(f"--scale must be positive, got {scale:g}")
    try:
        numbers = [float(word) for word in rest]
        if name in ("polygon", "cosine", "rounded", "convex") and numbers[0] % 1:
            raise InputError(f"--shape {text}: the number of sides must be whole")
        if name == "polygon":
            return shapes.polygon(int(numbers[0]), k, scale=scale)
        if name == "cosine":
            return shapes.cosine_polygon(int(numbers[0]), k, scale=scale)
        if name == "rounded":
            corner = numbers[1] if len(numbers) > 1 else 0.3
            return shapes.rounded_polygon(int(numbers[0]), k, corner=corner, scale=scale)
        if name in ("cone", "paraboloid"):
            return PowerLawProfile(1.0 if name == "cone" else 2.0, scale)
        if name == "bent":
            return shapes.bent_body(curvature=scale)
        if name == "ellipse":
            ratio = numbers[0]
            if not (np.isfinite(ratio) and ratio > 0):
                raise InputError(f"--shape {text}: the ratio of curvatures must be positive")
            body = PowerLawProfile(
                k, lambda p: scale * (np.cos(p) ** 2 + ratio * np.sin(p) ** 2) ** (k / 2)
            )
        elif name == "random":
            body = shapes.random_section(
                k, deviation=numbers[0], seed=int(numbers[1]) if len(numbers) > 1 else 0
            )
        elif name == "convex":
            seed = int(numbers[1]) if len(numbers) > 1 else 0
            body = shapes.random_polygon(k, sides=int(numbers[0]), seed=seed)
        else:
            raise InputError(f"no shape is called {name!r}; see asperity indent --help")
    except (ValueError, IndexError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"--shape {text} lacks its numbers; see asperity indent --help") from None
    if scale == 1.0 or name == "ellipse":
        return body
    return PowerSumProfile((k,), (lambda p: scale * body.psi(p),), corners=body.corners)


def _material(args: argparse.Namespace) -> Any:
    """Half-space from the options; a test body may do without one, then E* = 1."""
    from asperity.material import HalfSpace

    if args.shape is not None and args.E is None and args.modulus is None:
        return HalfSpace.from_modulus(1.0, args.m)
    return options.material(args)


def _laws(text: str | None) -> tuple[str, ...]:
    from asperity.microcontact.laws import LAWS

    if text is None:
        return ()
    names = tuple(word.strip() for word in text.split(","))
    for name in names:
        if name not in LAWS:
            raise InputError(f"no law is called {name!r}; the laws are {', '.join(LAWS)}")
    return names


def _driven(args: argparse.Namespace, profile: Any) -> tuple[str, list[float]]:
    """What is prescribed, "approach" or "load", and its values."""
    if args.load is not None:
        forces = options.numbers(args.load, "--load", geometric=True)
        if np.any(forces <= 0):
            raise InputError("--load must be positive")
        return "load", [float(f) for f in forces]
    if args.approach is not None:
        depths = options.numbers(args.approach, "--approach", geometric=False)
        if np.any(depths <= 0):
            raise InputError("--approach must be positive")
        return "approach", [float(d) for d in depths]
    if args.shape is not None:
        return "approach", [1.0]
    turn = 2 * np.pi * np.arange(64) / 64
    end = profile.radius if profile.edge is None else profile.edge
    return "approach", [
        float(np.min(profile(end / 2, turn if profile.edge is None else profile.phi)))
    ]
