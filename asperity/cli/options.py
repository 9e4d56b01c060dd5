"""Options that sub-commands share: the surface, its preparation, the material, the loads."""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from asperity.errors import InputError, SurfaceError
from asperity.halfspace.material import HalfSpace
from asperity.microcontact.laws import LAWS
from surfaces.checks import constant
from surfaces.heightmap import HeightMap
from surfaces.numerics.memory import set_memory
from surfaces.two_bodies import composite

from . import batch, quantities
from .surface import prepared, read_map
from .surface_options import add_preparation, add_reading

LOADS = {"pressure": "pressure", "load": "force", "separation": "length"}
"""Options that take a list of load points, and the kind of quantity of each."""

SceneWork = Callable[[HeightMap, HalfSpace, dict[str, Any], argparse.Namespace], Mapping[str, Any]]
"""As `batch.Work`, of a map, a half-space and load points as keyword arguments of the models."""


def add_scene_options(parser: argparse.ArgumentParser) -> None:
    """Options of maps, half-space and load points."""
    add_surface_options(parser)
    add_material_options(parser)
    add_load_options(parser)


def add_surface_options(parser: argparse.ArgumentParser, count: str = "+") -> None:
    """Options that name the files and say how the maps are read and prepared."""
    batch.add_files(parser, count)
    add_reading(parser)
    add_preparation(parser, fill="none")
    parser.add_argument(
        "--boundary",
        choices=["periodic", "free"],
        help="treat the contact as periodic or as one finite punch (default: as the map says)",
    )
    parser.add_argument(
        "--against",
        metavar="FILE",
        help="second rough surface, read and prepared alike, turned over onto the first",
    )


def add_material_options(parser: argparse.ArgumentParser, *, several: bool = False) -> None:
    """Options of the elastic half-space; with `several` each takes several values."""
    group = parser.add_argument_group("material")
    number, pressure = "plain number", "pressure"
    for name, kind, text in (
        ("--E", pressure, "Young's modulus [Pa], or 210GPa; E0 if graded"),
        ("--nu", number, "Poisson's ratio (default 0.3)"),
        ("--m", number, "exponent of E(z) = E z^m (default 0)"),
        ("--modulus", pressure, "composite modulus E* [Pa] in place of E, nu"),
        ("--hardness", pressure, "largest pressure that the body bears [Pa] (default: no limit)"),
        ("--E2", pressure, "Young's modulus of a second body [Pa]"),
        ("--nu2", number, "its Poisson's ratio (default 0.3)"),
        ("--hardness2", pressure, "its hardness [Pa] (default: no limit)"),
    ):
        how = quantities.several(kind, "+") if several else {"type": quantities.of(kind)}
        metavar = "P" if kind is pressure else None
        group.add_argument(name, metavar=metavar, help=text, **how)
    parser.set_defaults(m=0.0)


def add_model_options(parser: argparse.ArgumentParser) -> None:
    """Options of the microcontact model."""
    group = parser.add_argument_group("model")
    group.add_argument(
        "--law",
        default="auto",
        choices=LAWS,
        help="contact law of one summit (default auto)",
    )
    group.add_argument(
        "--no-interaction",
        action="store_true",
        help="the classical sum: contacts do not displace each other",
    )
    group.add_argument(
        "--scales",
        default="auto",
        choices=["auto", "all"],
        help="auto: of a broad random spectrum the finest waves act as a law of the contacts of "
        "the others, and other maps rough to the pixel are solved on a finer grid; all: every "
        "summit of the map as it is makes a contact (default auto)",
    )


def add_tolerance_option(parser: argparse.ArgumentParser) -> None:
    """Option of the boundary elements."""
    parser.add_argument(
        "--tolerance",
        type=quantities.of("share"),
        default=1e-6,
        metavar="SHARE",
        help="bound of the certificate (default 1e-6)",
    )


def add_load_options(parser: argparse.ArgumentParser) -> None:
    """Options that choose the load points."""
    group = parser.add_argument_group(
        "load points",
        "A list such as 1MPa,5MPa or LO:HI:N; pressures and loads are spaced by equal ratios.",
    ).add_mutually_exclusive_group()
    group.add_argument("--pressure", metavar="LO:HI:N", help="mean pressures [Pa], or 2MPa:1GPa:9")
    group.add_argument("--load", metavar="LO:HI:N", help="normal loads [N] on the map, or 1mN:1N:9")
    group.add_argument("--separation", metavar="HI:LO:N", help="separations [m], or 2um:1um:9")


def load_surface(file: str, args: argparse.Namespace) -> HeightMap:
    """Read the map and prepare it as the options ask; refuse what no model can use.

    With ``--against`` it is the composite with the second surface. Workers learn here how much
    memory they may use.
    """
    set_memory(args.memory)
    hm = _full_map(file, args)
    if args.against is not None:
        hm = composite(hm, _full_map(args.against, args))
    if constant(hm):
        raise SurfaceError(f"{Path(file).name} is constant: a flat map has no peaks to touch")
    return hm


def _full_map(file: str, args: argparse.Namespace) -> HeightMap:
    hm = read_map(Path(file), args)
    if args.fill != "none" or not hm.missing:
        hm = prepared(hm, args)
    if hm.missing:
        raise SurfaceError(
            f"{Path(file).name} has {hm.missing} missing points of {hm.source.size}; "
            "pass --fill harmonic"
        )
    return hm if hm.name else hm.replace(name=Path(file).stem)


def material(args: argparse.Namespace) -> HalfSpace:
    """Half-space from the options; the composite of two bodies where there are two."""
    first, *second = bodies(args)
    return HalfSpace.pair(first, *second) if second else first


def bodies(args: argparse.Namespace) -> list[HalfSpace]:
    """The elastic bodies of the options: one, or two where the second has a modulus.

    Without it both bodies of ``--against`` are of the same material.
    """
    first = _first_body(args)
    if args.E2 is not None:
        nu = 0.3 if args.nu2 is None else args.nu2
        return [first, HalfSpace(args.E2, nu, args.m, hardness=args.hardness2)]
    if args.nu2 is not None or args.hardness2 is not None:
        raise InputError("--nu2 and --hardness2 are of a second body: give its --E2")
    if getattr(args, "against", None) is not None and args.modulus is None:
        return [first, first]
    return [first]


def _first_body(args: argparse.Namespace) -> HalfSpace:
    if args.modulus is not None and not (args.E is args.nu is args.E2 is None):
        raise InputError("--modulus is E* of all: give it or --E (with --nu, and --E2), not both")
    if args.modulus is None and args.E is None:
        raise InputError("no material: give --E (Young's modulus in Pa) or --modulus (E* in Pa)")
    if args.modulus is not None:
        return HalfSpace.from_modulus(args.modulus, m=args.m, hardness=args.hardness)
    nu = 0.3 if args.nu is None else args.nu
    return HalfSpace(args.E, nu, m=args.m, hardness=args.hardness)


def model(args: argparse.Namespace) -> dict[str, Any]:
    """Choices of the microcontact model, as keyword arguments."""
    return {
        "law": args.law,
        "interaction": not args.no_interaction,
        "boundary": args.boundary,
        "scales": args.scales,
    }


def elements(args: argparse.Namespace) -> dict[str, Any]:
    """Choices of the boundary elements, as keyword arguments."""
    return {"boundary": args.boundary, "tolerance": args.tolerance}


def materials(args: argparse.Namespace) -> list[HalfSpace]:
    """Half-spaces of all values of the options of a material with each other."""
    names = vars(_defaults(add_material_options)).keys()
    given = {name: getattr(args, name) for name in names}
    lists = [value if isinstance(value, list) else [value] for value in given.values()]
    return [
        material(argparse.Namespace(**vars(args) | dict(zip(given, values, strict=True))))
        for values in itertools.product(*lists)
    ]


def surface_choices(args: argparse.Namespace) -> argparse.Namespace:
    """The options that say how maps are read and prepared, alone, for workers in any folder."""
    names = vars(_defaults(add_surface_options, "-")).keys() - {"files"}
    chosen = {name: getattr(args, name) for name in sorted(names)}
    if args.against is not None:
        chosen["against"] = str(Path(args.against).absolute())
    return argparse.Namespace(**chosen)


def require_default(
    args: argparse.Namespace, why: str, add: Callable[..., None], *words: str
) -> None:
    """Refuse options of one kind that nothing would be done with, for a reason."""
    given = [
        f"--{name.replace('_', '-')}"
        for name, default in vars(_defaults(add, *words)).items()
        if name != "files" and getattr(args, name) != default
    ]
    if given:
        raise InputError(f"{why}: leave out {', '.join(given)}")


def _defaults(add: Callable[..., None], *words: str) -> argparse.Namespace:
    """Options of one kind as they are where none is given."""
    parser = argparse.ArgumentParser()
    add(parser)
    return parser.parse_args(words)


def loads(args: argparse.Namespace) -> dict[str, Any]:
    """The load points asked for, "pressures", "loads" or "separations"; empty for the default."""
    given = {name: getattr(args, name) for name in LOADS if getattr(args, name) is not None}
    if len(given) > 1:  # one of a plan, the other of the command line
        raise InputError(f"give one of {' and '.join(f'--{name} {given[name]}' for name in given)}")
    for name, text in given.items():
        kind = LOADS[name]
        lengths = kind == "length"
        values = quantities.spread(text, f"--{name}", kind, geometric=not lengths)
        if not (lengths or (values > 0).all()):
            raise InputError(f"--{name} {text}: must be positive")
        return {f"{name}s": values}
    return {}


def on_scene(args: argparse.Namespace, work: SceneWork) -> batch.Work:
    """Work on every input, of its map, the half-space and the load points."""
    body, points = material(args), loads(args)

    def of_file(args: argparse.Namespace) -> Mapping[str, Any]:
        hm, asked = load_surface(args.file, args), points
        if "loads" in asked:
            asked = {"pressures": asked["loads"] / hm.area}
        return work(hm, body, asked, args)

    return of_file
