"""Options of ``asperity surface`` and its sub-commands."""

from __future__ import annotations

import argparse
from typing import Any

from surfaces.files.atomic import NOT_HDF5

from . import batch, quantities, targets

EPILOG = """examples:
  asperity surface info scan.h5 'raw/*.h5' --report maps.html --table maps.csv
  asperity surface generate --shape 512 512 --size 1mm --hurst 0.8 --rms-slope 0.1 -o map.h5
  asperity surface prepare scan.h5 --level plane --outliers 6 --fill harmonic -o ready.h5
  asperity surface convert heights.csv --unit um --spacing 1um -o heights.h5
  asperity surface validate scan.h5
  asperity surface peaks scan.h5 --fill harmonic --wolf 5 --plot peaks.png -o peaks.csv
"""


SIDES = quantities.several("length", "+")

TEXTURES = ("self-affine", "plateau-honed", "ground", "turned", "two-scale")
PARAMETERS = {
    "hurst": "Hurst exponent (0.8)",
    "rms_slope": "rms slope [-]; self-affine, plateau-honed, ground",
    "rms_height": "rms height [m]; self-affine",
    "rolloff": "longest self-affine wavelength [m]",
    "cutoff": "shortest wavelength [m]",
    "anisotropy": "ratio of the wavelengths along and across the lay; self-affine",
    "angle": "direction of the lay from +x [degrees]; self-affine, ground",
    "feed": "distance of the grooves [m]; turned",
    "nose_radius": "radius of the tool [m]; turned",
    "roughness": "rms height of the roughness on the grooves [m]; turned",
    "coarse": "shortest wavelength of the coarse scale [m]; two-scale",
    "fine": "shortest wavelength of the fine scale [m]; two-scale. Share of fine roughness; others",
    "coarse_height": "rms height of the coarse scale [m]; two-scale",
    "fine_height": "rms height of the fine scale [m]; two-scale",
    "seed": "names one of all such surfaces (0)",
}
"""Options of the textures; each texture takes some of them."""

ANY_OUTPUT = "file to write, or a folder, DIR/, in which each file is called as its input"
"""What is told of the output of a command that takes several files."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add all sub-commands with their options."""
    commands = parser.add_subparsers(dest="action", required=True, metavar="ACTION")

    info = _command(commands, "info", "what a map is and how rough it is, as it stands")
    _file_options(info)
    targets.add_target(
        info,
        "--report",
        suffix=".html",
        one=True,
        help="HTML page of all maps, numbers and pictures",
    )
    _table_options(info)

    validate = _command(commands, "validate", "name every fault of HDF5 height-map files")
    batch.add_files(validate)
    validate.add_argument("--dataset", metavar="NAME", help="name of the heights in the file")
    _table_options(validate)

    convert = _command(commands, "convert", "rewrite maps as HDF5 schema 1, .npz, .txt or .csv")
    _file_options(convert)
    _output_options(convert, ANY_OUTPUT)
    batch.add_table(convert)

    prepare = _command(commands, "prepare", "level, remove outliers, fill, filter, make periodic")
    _file_options(prepare)
    _output_options(prepare, ANY_OUTPUT)
    batch.add_table(prepare)
    add_preparation(prepare)

    generate = _command(commands, "generate", "make a rough surface")
    add_generation(generate)
    generate.add_argument("--name", help="name kept in the file")
    generate.add_argument(
        "--memory",
        type=quantities.of("memory"),
        metavar="SIZE",
        help="make the map by blocks in the file, in so much memory (2GiB); self-affine",
    )
    _output_options(generate, "file to write")

    peaks = _command(commands, "peaks", "prepare a map and list its peaks")
    _file_options(peaks)
    add_preparation(peaks, fill="none")
    finding = peaks.add_argument_group("peaks")
    finding.add_argument(
        "--above", type=quantities.of("length"), metavar="D", help="only heights above this [m]"
    )
    least = finding.add_mutually_exclusive_group()
    least.add_argument(
        "--min-prominence",
        type=quantities.of("length"),
        default=0.0,
        metavar="D",
        help="smallest prominence [m]",
    )
    least.add_argument(
        "--wolf",
        type=quantities.of("percentage"),
        metavar="PERCENT",
        help="the same in %% of the height range",
    )
    targets.add_target(finding, "--plot", suffix=".png", help="picture of map, summits and basins")
    targets.add_target(finding, "--fans", suffix=".png", help="profiles of the nine highest peaks")
    targets.add_target(finding, "-o", "--output", suffix=".csv", help="write all peaks as CSV")
    _table_options(peaks)


def add_reading(parser: argparse.ArgumentParser) -> None:
    """Options that say what a file does not."""
    group = parser.add_argument_group("reading")
    group.add_argument("--dataset", metavar="NAME", help="name of the heights in the file")
    group.add_argument("--unit", help="unit of the heights if not stated (um, nm; 2.5nm)")
    group.add_argument(
        "--spacing", **SIDES, metavar="D", help="pixel size DY DX [m], if not stated"
    )
    group.add_argument(
        "--memory",
        type=quantities.of("memory"),
        metavar="SIZE",
        help="most memory to use, such as 2GiB: larger maps stay on disk (default: all free)",
    )


def add_preparation(parser: argparse.ArgumentParser, *, fill: str = "harmonic") -> None:
    """Options of `surfaces.prepare`, and of cropping and resampling."""
    parser = parser.add_argument_group("preparation")  # type: ignore[assignment]
    parser.add_argument(
        "--level",
        choices=["none", "mean", "plane", "quadratic", "cubic", "quartic", "quintic", "cylinder"],
        help="form to take out (default: plane; a periodic map stays as it is)",
    )
    parser.add_argument(
        "--fill",
        choices=["none", "harmonic"],
        default=fill,
        help=f"missing points (default: {fill})",
    )
    parser.add_argument(
        "--fill-limit",
        type=quantities.of("share"),
        default=0.1,
        metavar="F",
        help="largest fraction to fill (0.1, or 10%%)",
    )
    parser.add_argument(
        "--outliers",
        type=quantities.of("plain number"),
        metavar="K",
        help="drop spikes beyond K robust deviations",
    )
    parser.add_argument(
        "--bandpass",
        **quantities.several("length", 2),
        metavar=("SHORT", "LONG"),
        help="wavelengths to keep [m] (S and L filter); 0 and inf leave a side open",
    )
    parser.add_argument(
        "--filter",
        choices=["sharp", "gaussian", "spline"],
        default="sharp",
        help="limits of the band: sharp, or the filters of ISO 16610-61 and -62 (default sharp)",
    )
    parser.add_argument(
        "--periodic", choices=["mirror", "taper", "smooth", "wrap"], help="make it periodic"
    )
    parser.add_argument("--resample", **SIDES, metavar="D", help="pixel size to move to: DY DX [m]")
    parser.add_argument(
        "--crop",
        type=quantities.whole("pixels"),
        nargs=4,
        metavar=("TOP", "BOTTOM", "LEFT", "RIGHT"),
        help="pixels to keep, first and one past last",
    )


def _command(
    commands: argparse._SubParsersAction[argparse.ArgumentParser], name: str, summary: str
) -> argparse.ArgumentParser:
    example = next(line for line in EPILOG.splitlines() if f"surface {name}" in line)
    return commands.add_parser(
        name,
        help=summary,
        description=summary[0].upper() + summary[1:] + ".",
        epilog=f"example:\n{example}",
    )


def _file_options(parser: argparse.ArgumentParser) -> None:
    batch.add_files(parser)
    add_reading(parser)


def _table_options(parser: argparse.ArgumentParser) -> None:
    targets.add_force(parser)
    batch.add_table(parser)


def _output_options(parser: argparse.ArgumentParser, what: str) -> None:
    targets.add_target(
        parser, "-o", "--output", suffix=".h5", formats=NOT_HDF5, required=True, help=what
    )
    targets.add_force(parser)
    parser.add_argument("--float32", action="store_true", help="half the size, 7 digits")


def add_generation(parser: Any) -> None:
    """Options that say what surface is made."""
    what = "kind of surface (default self-affine)"
    parser.add_argument("--texture", choices=TEXTURES, default="self-affine", help=what)
    parser.add_argument(
        "--shape",
        type=quantities.whole("points"),
        nargs="+",
        default=[512, 512],
        metavar="N",
        help="points NY NX, or of both sides (default 512)",
    )
    parser.add_argument(
        "--size",
        **SIDES,
        default=[1e-3],
        metavar="L",
        help="lengths LY LX [m], or of both sides (default 1 mm)",
    )
    for name, text in PARAMETERS.items():
        kind = "length" if "[m]" in text else "angle" if name == "angle" else "plain number"
        number: Any = quantities.whole() if name == "seed" else quantities.of(kind)
        parser.add_argument(f"--{name.replace('_', '-')}", type=number, metavar="X", help=text)
