"""``asperity ensemble``: mean curve of seeds, windows or repeats, and how well it is known."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import surfaces
from asperity.errors import InputError
from asperity.progress import bar
from surfaces.errors import as_count

from . import batch, options, quantities, targets
from .exit_codes import EXIT_NOT_CONVERGED, EXIT_OK
from .messages import tell
from .surface import generator, reading
from .surface_options import add_generation
from .sweep import add_solving_options, add_worker_options, settings_for

if TYPE_CHECKING:
    from asperity.distributed.bands import Ensemble
    from asperity.distributed.jobs import Surface

EPILOG = """examples:
  asperity ensemble 'scans/*.h5' --E 210GPa --plot mean.png -o repeats/
  asperity ensemble scan.h5 --windows 24 --E 210GPa --pressure 20MPa:500MPa:9 -o windows/
  asperity ensemble --seeds 20 --shape 64 --rms-slope 0.1 --E 210GPa --until 50% -o seeds/
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity ensemble``."""
    options.add_surface_options(parser, "*")
    group = parser.add_argument_group("members", "Without these options each file is a member.")
    group.add_argument(
        "--windows",
        type=quantities.whole("points"),
        nargs="+",
        metavar="N",
        help="points of windows NY NX of each map",
    )
    group.add_argument(
        "--seeds", type=quantities.whole(), metavar="N", help="so many seeds, from --seed (0) on"
    )
    group.add_argument(
        "--until",
        type=quantities.of("share"),
        metavar="SHARE",
        help="add members until the 95%% confidence interval of the mean contact area has this "
        "half width, as 2%%, at least 14 (default: all members)",
    )
    add_generation(parser.add_argument_group("surface of the seeds"))
    options.add_material_options(parser)
    add_solving_options(parser)
    add_worker_options(parser)
    parser.add_argument(
        "-o",
        "--output",
        default="ensemble/",
        metavar="DIR",
        help="folder of ensemble.csv, convergence.csv, ensemble.h5 and, as of a sweep, the members "
        "(default ensemble/)",
    )
    targets.add_target(parser, "--plot", suffix=".png", help="picture of the mean and its bands")
    targets.add_force(parser)
    batch.add_json(parser)


def run(args: argparse.Namespace) -> int:
    """Run members until the mean is known well enough, write it and tell it."""
    from asperity.distributed.ensemble import ensemble

    targets.require(args)
    members = _members(args)
    material, settings = options.material(args), settings_for(args)
    with bar(len(members), "members") as advance:
        found = ensemble(
            members,
            material,
            settings,
            folder=args.output,
            until=args.until,
            workers=args.workers,
            scheduler=args.scheduler,
            threads=args.threads,
            force=args.force,
            progress=advance,
        )
    args.document = found.to_dataframe().to_dict("records")
    tell(str(found))
    if args.plot:
        _draw(found, args.plot)
        tell(f"plot            {args.plot}")
    return EXIT_OK if found.met and found.sweep.converged else EXIT_NOT_CONVERGED


def _members(args: argparse.Namespace) -> list[Surface]:
    """The members that the options name, in their order."""
    from asperity.distributed.ensemble import seeded
    from asperity.distributed.jobs import Surface

    if args.seeds is not None:
        if args.files or args.windows:
            raise InputError("--seeds are of a surface that is made: name no file and no --windows")
        why = "--seeds are of a surface that is made, neither read nor prepared"
        options.require_default(args, why, options.add_surface_options, "-")
        first, make = as_count("--seed", args.seed or 0, 0), generator(args)
        seeds = range(first, first + as_count("--seeds", args.seeds, 1))
        named = zip(seeds, seeded(make, seeds), strict=True)
        return [Surface(f"{args.texture} {seed}", load) for seed, load in named]
    why = "files are read, and no surface is made without --seeds"
    options.require_default(args, why, add_generation)
    if not args.files:
        raise InputError("an ensemble has no member: name files of maps, or give --seeds")
    files, how = batch.expand(args.files), options.surface_choices(args)
    if args.windows is not None:
        return [member for file in files for member in _windows(file, how, args)]
    return [Surface(str(f), partial(options.load_surface, str(f.absolute()), how)) for f in files]


def _windows(file: Path, how: argparse.Namespace, args: argparse.Namespace) -> list[Surface]:
    """Windows of one map, each read and prepared alone."""
    from asperity.distributed.ensemble import windows_of
    from asperity.distributed.jobs import Surface

    if args.crop is not None or len(args.windows) > 2:
        raise InputError("--windows takes one number or two (y and x), and no --crop beside it")
    with surfaces.open(file, **reading(args)) as opened:
        places = windows_of(opened.shape, tuple(args.windows))
    return [
        Surface(
            f"{file} {rows[0]}:{rows[1]} {columns[0]}:{columns[1]}",
            partial(
                options.load_surface,
                str(file.absolute()),
                argparse.Namespace(**vars(how) | {"crop": [*rows, *columns]}),
            ),
        )
        for rows, columns in places
    ]


def _draw(found: Ensemble, target: str) -> None:
    """Contact area and separation with their bands, and the convergence."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13, 4), layout="constrained")
    area, separation, members = figure.subplots(1, 3)
    found.plot("area_fraction", area)
    area.set_yscale("log")
    found.plot("separation", separation)
    members.plot(range(2, len(found) + 1), 100 * found.convergence[1:])
    members.set(xlabel="members", ylabel="mean contact area known to [%]")
    if found.convergence[1] > 0.0:
        members.set_yscale("log")
    if found.until is not None:
        members.axhline(100 * found.until, color="0.5", linestyle="--")
    targets.save_figure(figure, target)
