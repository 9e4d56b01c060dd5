"""What follows from a normal contact curve, on request: conductance and partial slip."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

import numpy as np

from asperity.errors import InputError
from asperity.results.curve import ContactCurve

from . import quantities, targets
from .messages import warn

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace


def add_derived_options(parser: argparse.ArgumentParser) -> None:
    """Options for what the normal curve tells beyond itself."""
    group = parser.add_argument_group("from the curve (homogeneous bodies)")
    add_resistivity_option(
        group,
        "of both bodies [Ohm m] or [m K/W]: constriction conductance, printed and in the CSV",
    )
    group.add_argument(
        "--friction",
        type=quantities.of("plain number"),
        metavar="MU",
        help="coefficient of friction, for --slip",
    )
    targets.add_target(
        group,
        "--slip",
        suffix=".csv",
        help="CSV table of shear against tangential displacement, heaviest load",
    )


def add_resistivity_option(parser: Any, what: str) -> None:
    """Option of the conductance."""
    two = quantities.several("plain number", 2)
    parser.add_argument("--resistivity", **two, metavar=("RHO1", "RHO2"), help=what)


def require_derivable(material: HalfSpace, loads: dict[str, Any], args: argparse.Namespace) -> None:
    """Refuse, before any work, what does not follow from the curve of this material."""
    if (args.friction is None) != (args.slip is None):
        raise InputError("partial slip needs both --friction MU and --slip FILE")
    if material.m != 0.0 and (args.resistivity or args.slip):
        raise InputError("--resistivity and --slip hold for homogeneous bodies, --m 0")
    if material.hardness < np.inf and args.slip:
        raise InputError("--slip is of elastic contacts alone; leave --hardness out")
    if material.hardness < np.inf and args.resistivity and args.command == "solve":
        raise InputError("--resistivity with --hardness is told by asperity curve and bem alone")
    if args.slip and args.modulus is not None:
        raise InputError("--slip needs --E and --nu in place of --modulus")
    if args.slip and not 0 < args.friction < np.inf:
        raise InputError(f"--friction is {args.friction}; it must be positive and finite")
    if args.slip and any(len(np.unique(values)) < 2 for values in loads.values()):
        raise InputError("--slip needs lighter load points beside the heaviest, such as LO:HI:10")
    if args.resistivity:
        from asperity.extensions.conductance import total_resistivity

        total_resistivity(tuple(args.resistivity))


def conductance(curve: ContactCurve, args: argparse.Namespace) -> dict[str, Any]:
    """Column of the conductance per nominal area, if it was asked for."""
    from asperity.extensions.conductance import constriction_conductance

    if args.resistivity is None:
        return {}
    return {"conductance": constriction_conductance(curve, resistivity=tuple(args.resistivity))}


def write_slip(curve: ContactCurve, material: HalfSpace, args: argparse.Namespace) -> None:
    """Write the partial-slip curve under the heaviest load; the partner of one body is rigid.

    Says so where fewer than two load points converged, from which none follows.
    """
    loads = np.unique(curve.mean_pressure[curve.mean_pressure > 0])
    if len(loads) < 2:
        warn(args, "fewer than two load points converged: no partial slip is written")
        return
    from asperity.extensions.partial_slip import friction_curve, tangential_modulus
    from asperity.results.storage import write_csv

    from . import options

    slip = friction_curve(
        curve,
        float(loads[-1]),
        friction=args.friction,
        modulus_ratio=material.modulus / tangential_modulus(*options.bodies(args)),
    )
    names = ("displacement", "shear", "stick_area_fraction")
    write_csv(args.slip, {name: np.asarray(getattr(slip, name)) for name in names})
