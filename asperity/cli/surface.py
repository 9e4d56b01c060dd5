"""``asperity surface``: look at, make, prepare, convert and check height-map files."""

from __future__ import annotations

import argparse
import glob
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from tqdm import tqdm

import surfaces
from surfaces.errors import AsperityError, InputError

_EPILOG = """examples:
  asperity surface info scan.h5 'raw/*.sur'
  asperity surface generate --shape 512 512 --size 1e-3 --hurst 0.8 --rms-slope 0.1 -o map.h5
  asperity surface prepare scan.h5 --level plane --outliers 6 --fill harmonic -o ready.h5
  asperity surface convert heights.csv --unit um --spacing 1e-6 -o heights.h5
  asperity surface validate scan.h5
  asperity surface peaks ready.h5 --min-prominence 1e-8 -o peaks.csv
"""

Work = Callable[[Path, argparse.Namespace], bool]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of all sub-commands."""
    parser.epilog = _EPILOG
    commands = parser.add_subparsers(dest="action", required=True, metavar="ACTION")

    info = _command(commands, "info", "what a map is and how rough it is")
    _files(info)

    validate = _command(commands, "validate", "name every fault of HDF5 height-map files")
    validate.add_argument("files", nargs="+", metavar="FILE", help="files or glob patterns")
    validate.add_argument("--dataset", metavar="NAME", help="name of the heights in the file")

    convert = _command(commands, "convert", "rewrite maps as HDF5 schema 1, .npz, .txt or .csv")
    _files(convert)
    _outputs(convert)

    prepare = _command(commands, "prepare", "level, remove outliers, fill, filter, make periodic")
    _files(prepare)
    _outputs(prepare)
    add_preparation(prepare)

    generate = _command(commands, "generate", "make a self-affine rough surface")
    _generation(generate)

    peaks = _command(commands, "peaks", "list the peaks of a map")
    _files(peaks)
    peaks.add_argument("--above", type=float, metavar="M", help="only heights above this [m]")
    peaks.add_argument(
        "--min-prominence", type=float, default=0.0, metavar="M", help="smallest prominence [m]"
    )
    peaks.add_argument("-o", "--output", metavar="CSV", help="write all peaks as CSV")


def add_preparation(parser: argparse.ArgumentParser) -> None:
    """Options of `surfaces.prepare`."""
    parser.add_argument(
        "--level",
        choices=["none", "mean", "plane", "quadratic", "cylinder"],
        default="plane",
        help="form to take out (default: plane)",
    )
    parser.add_argument(
        "--fill", choices=["none", "harmonic"], default="harmonic", help="fill missing points"
    )
    parser.add_argument(
        "--fill-limit", type=float, default=0.1, metavar="F", help="largest fraction to fill (0.1)"
    )
    parser.add_argument(
        "--outliers", type=float, metavar="K", help="drop spikes beyond K robust deviations"
    )
    parser.add_argument(
        "--bandpass",
        type=float,
        nargs=2,
        metavar=("SHORT", "LONG"),
        help="wavelengths to keep [m]; 0 and inf leave a side open",
    )
    parser.add_argument("--periodic", choices=["mirror", "taper", "wrap"], help="make it periodic")
    parser.add_argument(
        "--resample", type=float, nargs="+", metavar="D", help="pixel size to move to: DY DX [m]"
    )
    parser.add_argument(
        "--crop",
        type=int,
        nargs=4,
        metavar=("TOP", "BOTTOM", "LEFT", "RIGHT"),
        help="pixels to keep, first and one past last",
    )


def run(args: argparse.Namespace) -> int:
    """Run one action on every file; a bad file is named and the batch goes on."""
    if args.action == "generate":
        return _generate(args)
    actions: dict[str, Work] = {
        "info": _info,
        "validate": _validate,
        "convert": _convert,
        "prepare": _prepare,
        "peaks": _peaks,
    }
    files = expand(args.files)
    if len(files) > 1 and getattr(args, "output", None):
        raise InputError(f"-o names one file and {len(files)} were given; use --folder")
    bad = 0
    for path in tqdm(files, disable=None, unit="file", leave=False):
        try:
            bad += not actions[args.action](path, args)
        except (AsperityError, MemoryError) as error:
            bad += 1
            text = " ".join(str(error).split()) or f"{path}: out of memory"
            named = text if str(path) in text else f"{path}: {text}"
            tqdm.write(f"asperity surface {args.action}: {named}", file=sys.stderr)
    return 2 if bad else 0


def expand(patterns: Sequence[str]) -> list[Path]:
    """Files of names and glob patterns, in order, each once."""
    found: dict[Path, None] = {}
    for pattern in patterns:
        names = sorted(glob.glob(pattern, recursive=True)) if glob.has_magic(pattern) else [pattern]
        if not names and not Path(pattern).exists():
            raise InputError(f"{pattern}: no file matches")
        found |= dict.fromkeys(Path(name) for name in names or [pattern])
    return list(found)


def _command(
    commands: argparse._SubParsersAction[argparse.ArgumentParser], name: str, summary: str
) -> argparse.ArgumentParser:
    example = next(line for line in _EPILOG.splitlines() if f"surface {name}" in line)
    return commands.add_parser(
        name,
        help=summary,
        description=summary[0].upper() + summary[1:] + ".",
        epilog=f"example:\n{example}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def _files(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="+", metavar="FILE", help="files or glob patterns")
    parser.add_argument("--dataset", metavar="NAME", help="name of the heights in the file")
    parser.add_argument("--unit", help="unit of the heights where the file states none")
    parser.add_argument(
        "--spacing", type=float, nargs="+", metavar="D", help="pixel size DY DX [m], if not stated"
    )


def _outputs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", metavar="FILE", help="file to write (one input only)")
    parser.add_argument("--folder", metavar="DIR", help="folder to write NAME.h5 to, for batches")
    parser.add_argument("--float32", action="store_true", help="half the size, 7 digits")


def _generation(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--shape", type=int, nargs="+", default=[512, 512], metavar="N")
    parser.add_argument("--size", type=float, nargs="+", default=[1e-3], metavar="L", help="[m]")
    parser.add_argument("--hurst", type=float, default=0.8, help="Hurst exponent (0.8)")
    parser.add_argument("--rms-slope", type=float, help="rms slope [-]")
    parser.add_argument("--rms-height", type=float, help="rms height [m]")
    parser.add_argument("--rolloff", type=float, help="longest self-affine wavelength [m]")
    parser.add_argument("--cutoff", type=float, help="shortest wavelength [m]")
    parser.add_argument(
        "--anisotropy", type=float, default=1.0, help="ratio of correlation lengths"
    )
    parser.add_argument("--angle", type=float, default=0.0, help="direction of the lay [degrees]")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--name", help="name kept in the file")
    parser.add_argument("-o", "--output", metavar="FILE", required=True)
    parser.add_argument("--float32", action="store_true", help="half the size, 7 digits")


def _read(path: Path, args: argparse.Namespace) -> surfaces.HeightMap:
    return surfaces.read(
        path, dataset=args.dataset, unit=args.unit, spacing=_pair(args.spacing, "--spacing")
    )


def _pair(values: Sequence[float] | None, option: str) -> tuple[float, float] | None:
    if values is None:
        return None
    if len(values) not in (1, 2):
        raise InputError(f"{option} takes one number or two (y and x), not {len(values)}")
    return float(values[0]), float(values[-1])


def _info(path: Path, args: argparse.Namespace) -> bool:
    hm = _read(path, args)
    (ny, nx), (dy, dx), (length_y, length_x) = hm.shape, hm.spacing, hm.size
    lines = [
        f"{path}",
        f"  points     {ny} x {nx} (y, x), {hm.missing} missing",
        f"  pixel      {dy:.6g} x {dx:.6g} m, map {length_y:.6g} x {length_x:.6g} m",
        f"  periodic   {'yes' if hm.periodic else 'no'}",
        f"  rms height {hm.rms_height:.6g} m",
    ]
    for step in hm.history:
        details = ", ".join(f"{k} {v}" for k, v in step.items() if k != "step")
        lines.append(f"  history    {step.get('step', '?')}: {details}"[:160])
    tqdm.write("\n".join(lines))
    return True


def _validate(path: Path, args: argparse.Namespace) -> bool:
    faults = surfaces.validate(path, dataset=args.dataset)
    if not faults:
        tqdm.write(f"{path}: valid, schema surface/1")
    for fault in faults:
        tqdm.write(f"{path}: {'fault' if fault.fatal else 'note'}: {fault}")
    return not any(fault.fatal for fault in faults)


def _convert(path: Path, args: argparse.Namespace) -> bool:
    _save(_read(path, args), path, args)
    return True


def _prepare(path: Path, args: argparse.Namespace) -> bool:
    hm = prepared(_read(path, args), args)
    for step in hm.history:
        if step["step"] != "read":
            details = ", ".join(f"{key} {value}" for key, value in step.items() if key != "step")
            tqdm.write(f"{path}: {step['step']}: {details}", file=sys.stderr)
    _save(hm, path, args)
    return True


def prepared(hm: surfaces.HeightMap, args: argparse.Namespace) -> surfaces.HeightMap:
    """The map after the options of `add_preparation`."""
    if args.crop:
        top, bottom, left, right = args.crop
        hm = surfaces.crop(hm, (top, bottom), (left, right))
    band = args.bandpass
    if band is not None:
        band = (band[0] or None, band[1] if math.isfinite(band[1]) else None)
    hm = surfaces.prepare(
        hm,
        level=None if args.level == "none" else args.level,
        fill=None if args.fill == "none" else args.fill,
        outliers=args.outliers,
        bandpass=band,
        fill_limit=args.fill_limit,
    )
    if args.resample:
        hm = surfaces.resample(hm, _pair(args.resample, "--resample"))
    return surfaces.make_periodic(hm, args.periodic) if args.periodic else hm


def _save(hm: surfaces.HeightMap, path: Path, args: argparse.Namespace) -> None:
    if (args.output is None) == (args.folder is None):
        raise InputError("say where to write: -o FILE for one input, --folder DIR for several")
    if args.folder is not None:
        folder = Path(args.folder)
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{folder}: cannot be made ({error.strerror})") from error
        target = folder / f"{path.stem}.h5"
        if target.exists() and target.samefile(path):
            raise InputError(f"{target}: would replace the input; choose another --folder")
    else:
        target = Path(args.output)
    surfaces.write(hm, target, dtype="float32" if args.float32 else "float64")
    tqdm.write(f"{path} -> {target}", file=sys.stderr)


def _generate(args: argparse.Namespace) -> int:
    if len(args.shape) > 2 or len(args.size) > 2:
        raise InputError("--shape and --size take one number or two (y and x)")
    shape = (args.shape[0], args.shape[-1])
    hm = surfaces.self_affine(
        shape,
        (args.size[0], args.size[-1]),
        hurst=args.hurst,
        rms_slope=args.rms_slope,
        rms_height=args.rms_height,
        rolloff=args.rolloff,
        cutoff=args.cutoff,
        anisotropy=args.anisotropy,
        angle=math.radians(args.angle),
        seed=args.seed,
    )
    if args.name:
        hm = hm.replace(name=args.name)
    surfaces.write(hm, args.output, dtype="float32" if args.float32 else "float64")
    tqdm.write(f"{args.output}: {hm!r}, rms height {hm.rms_height:.6g} m", file=sys.stderr)
    return 0


def _peaks(path: Path, args: argparse.Namespace) -> bool:
    peaks = surfaces.segment(
        _read(path, args), above=args.above, min_prominence=args.min_prominence
    )
    tqdm.write(f"{path}: {len(peaks)} peaks")
    columns = ("x", "y", "height", "prominence", "basin_area")
    if args.output:
        rows = zip(*(getattr(peaks, name).tolist() for name in (*columns, "border")), strict=True)
        lines = ["x_m,y_m,height_m,prominence_m,basin_area_m2,border"]
        lines += [",".join(str(value) for value in row) for row in rows]
        try:
            Path(args.output).write_text("\n".join(lines) + "\n")
        except OSError as error:
            raise InputError(f"{args.output}: cannot be written ({error.strerror})") from error
        return True
    tqdm.write("  " + "".join(f"{name:>14s}" for name in columns) + "   (SI; highest ten)")
    for index in range(min(10, len(peaks))):
        values = (float(getattr(peaks, name)[index]) for name in columns)
        tqdm.write("  " + "".join(f"{value:14.6g}" for value in values))
    return True
