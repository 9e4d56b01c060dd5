"""``asperity indent``: one contact by every law, with an optional boundary-element check."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from asperity.errors import InputError
from asperity.halfspace.material import HalfSpace
from surfaces import PolarProfile, PowerSumProfile
from surfaces.errors import as_choice

from . import batch, bodies, options, quantities, targets
from .exit_codes import EXIT_NOT_CONVERGED, EXIT_OK
from .messages import tell
from .surface import reading
from .surface_options import add_reading

if TYPE_CHECKING:
    from asperity.comparison.one_contact import LawComparison

_FORMS = list(bodies.BODIES)

EPILOG = f"""shapes:
  {"   ".join(_FORMS[:6])}
  {"   ".join(_FORMS[6:])}
examples:
  asperity indent --shape polygon:4 --k 1 --m 0.3 --bem --plot square.png
  asperity indent --shape rounded:3:0.3 --k 2 --modulus 1GPa --approach 0.1um --scale 1e5
  asperity indent --shape polygon:4 --m 0.3 --load 1 --bem  # compared at equal load
  asperity indent profile.h5 --E 210GPa --nu 0.3 --approach 10nm:100nm:5
  asperity indent --shape paraboloid --modulus 1GPa --hardness 100MPa  # where it yields
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity indent``."""
    parser.add_argument(
        "file", nargs="?", metavar="FILE", help="profile file, or a map whose highest peak is used"
    )
    parser.add_argument("--shape", help="a test body in place of a file, see below")
    number = quantities.of("plain number")
    parser.add_argument("--k", type=number, help="exponent of r of a test body (default 1)")
    parser.add_argument("--scale", type=number, help="factor of its gap (default 1)")
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--approach", metavar="LO:HI:N", help="approaches [m]: D, D1,D2 or LO:HI:N")
    group.add_argument("--load", metavar="LO:HI:N", help="normal loads [N] in place of approaches")
    parser.add_argument("--law", metavar="NAMES", help="laws, comma-separated (default all)")
    parser.add_argument("--bem", action="store_true", help="solve by boundary elements as well")
    parser.add_argument(
        "--grid", type=quantities.whole("points"), help="points per axis of these (default 256)"
    )
    options.add_tolerance_option(parser)
    parser.set_defaults(tolerance=None)
    targets.add_target(parser, "--plot", suffix=".png", help="picture of the last contact")
    targets.add_force(parser)
    batch.add_json(parser)
    add_reading(parser)
    options.add_material_options(parser)


def run(args: argparse.Namespace) -> int:
    """Solve every contact, print one table each and draw the last."""
    from asperity.comparison.one_contact import compare_laws, draw_laws

    profile, label = _profile(args)
    material = _material(args)
    laws = _laws(args.law)
    targets.require(args, inputs=[args.file] if args.file else [])
    bem = _boundary_elements(args)
    good, compared = True, None
    name, values = _driven(args, profile)
    args.document = []
    sign, unit = ("d", "m") if name == "approach" else ("F", "N")
    for value in values:
        driven: dict[str, Any] = {name: value, **bem}
        compared = compare_laws(profile, material, **driven, laws=laws)
        head = f"{label}   m = {material.m:g}   E* = {material.modulus:.6g}"
        tell(f"{head}   {sign} = {value:.6g} {unit}\n{compared.table()}\n")
        args.document.append(
            {name: value, "m": material.m, "modulus": material.modulus} | _results(compared)
        )
        good &= compared.reference is None or bool(compared.reference.converged)
        good &= any(row.solution is not None and row.solution.valid for row in compared.rows)
    if args.plot and compared is not None:
        targets.save_figure(draw_laws(compared, title=label), args.plot)
        tell(f"picture: {args.plot}")
    return EXIT_OK if good else EXIT_NOT_CONVERGED


def _results(compared: LawComparison) -> dict[str, Any]:
    """What the laws and the boundary elements tell of one contact."""
    told = ("force", "approach", "contact_area", "error_estimate", "saturated")
    errors = ("force_error", "contour_error", "area_error", "approach_error", "seconds")
    laws = [
        {name: getattr(row.solution, name) for name in told if row.solution is not None}
        | {name: getattr(row, name) for name in errors}
        | {"flags": row.solution.flag_names() if row.solution is not None else ""}
        | {"law": row.law, "reason": row.reason}
        for row in compared.rows
    ]
    bem = compared.reference
    names = ("force", "approach", "contact_area", "converged")
    return {"laws": laws, "bem": bem and {name: getattr(bem, name) for name in names}}


def _profile(args: argparse.Namespace) -> tuple[PowerSumProfile | PolarProfile, str]:
    """The gap from the file or of the test body, and what to call it."""
    if (args.file is None) == (args.shape is None):
        raise InputError("give either a profile file or --shape")
    from_file = args.file is not None
    for name in ("k", "scale") if from_file else ("dataset", "unit", "spacing"):
        if getattr(args, name) is not None:
            raise InputError(f"--{name} belongs to {'--shape' if from_file else 'a file'}")
    if from_file:
        from surfaces.files.profile_file import read_profile

        return read_profile(args.file, **reading(args)), Path(args.file).name
    body = bodies.body(args.shape, args.k, args.scale)
    return body, args.shape + (f", k = {body.powers[0]:g}" if len(body.powers) == 1 else "")


def _material(args: argparse.Namespace) -> HalfSpace:
    """Half-space from the options; a test body may do without one, then E* = 1."""
    moduli = (args.E, args.nu, args.modulus, args.E2, args.nu2, args.hardness2)
    if args.shape is not None and all(one is None for one in moduli):
        return HalfSpace.from_modulus(1.0, args.m, hardness=args.hardness)
    return options.material(args)


def _boundary_elements(args: argparse.Namespace) -> dict[str, Any]:
    """Settings of the boundary elements as arguments of `compare_laws`; no grid is none of them."""
    asked = {name: getattr(args, name) for name in ("grid", "tolerance")}
    given = {name: value for name, value in asked.items() if value is not None}
    if given and not args.bem:
        raise InputError(f"--{next(iter(given))} is a setting of the boundary elements; add --bem")
    return given if args.bem else {"grid": None}


def _laws(text: str | None) -> tuple[str, ...]:
    from asperity.microcontact.laws import LAWS

    words = () if text is None else text.split(",")
    return tuple(as_choice("law", word.strip(), LAWS) for word in words)


def _driven(args: argparse.Namespace, profile: Any) -> tuple[str, list[float]]:
    """What is prescribed, "approach" or "load", and its values."""
    for name, kind in (("load", "force"), ("approach", "length")):
        text = getattr(args, name)
        if text is not None:
            values = quantities.spread(text, f"--{name}", kind, geometric=kind == "force")
            if np.any(values <= 0):
                raise InputError(f"--{name} must be positive")
            return name, values.tolist()
    if args.shape is not None:
        return "approach", [1.0]
    turn = 2 * np.pi * np.arange(64) / 64
    whole = profile.edge is None
    end, phi = (profile.radius, turn) if whole else (profile.edge, profile.phi)
    return "approach", [float(np.min(profile(end / 2, phi)))]
