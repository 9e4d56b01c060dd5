"""``asperity surface``: look at, make, prepare, convert and check height-map files."""

from __future__ import annotations

import argparse
import glob
import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import surfaces
from surfaces.errors import AsperityError, InputError

from . import output
from .surface_options import PARAMETERS, add_arguments

__all__ = ["add_arguments", "expand", "prepared", "read_map", "run"]

Work = Callable[[Path, argparse.Namespace], bool]


def run(args: argparse.Namespace) -> int:
    """Run one action on every file; a bad file is named and the batch goes on."""
    from tqdm import tqdm

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
    for option in ("output", "plot", "fans"):
        if len(files) > 1 and getattr(args, option, None):
            remedy = "use --folder" if hasattr(args, "folder") else "give one file"
            raise InputError(f"--{option} names one file and {len(files)} were given; {remedy}")
    _require_targets(files, args)
    bad = 0
    for path in tqdm(files, disable=None, unit="file", leave=False):
        try:
            bad += not actions[args.action](path, args)
        except (AsperityError, MemoryError) as error:
            bad += 1
            text = output.told(path, error)
            output.tell(f"asperity surface {args.action}: {text}", error=True)
    if getattr(args, "sections", None):
        from surfaces.page import write_page

        write_page(args.sections, Path(args.html))
    return 2 if bad else 0


def expand(patterns: Sequence[str]) -> list[Path]:
    """Files of names and glob patterns, in order, each once; a pattern without match is a name."""
    names = [
        name
        for word in patterns
        for name in (not Path(word).exists() and sorted(glob.glob(word, recursive=True))) or [word]
    ]
    return [Path(name) for name in dict.fromkeys(names)]


def read_map(path: Path, args: argparse.Namespace) -> surfaces.HeightMap:
    """The map, or the part of it that ``--crop`` keeps, as the options of `add_reading` say."""
    crop = getattr(args, "crop", None)
    return surfaces.read(
        path,
        dataset=args.dataset,
        unit=args.unit,
        spacing=_pair(args.spacing, "--spacing"),
        rows=(crop[0], crop[1]) if crop else None,
        columns=(crop[2], crop[3]) if crop else None,
    )


def _pair(values: Sequence[float] | None, option: str) -> tuple[float, float] | None:
    if values is None:
        return None
    if len(values) not in (1, 2):
        raise InputError(f"{option} takes one number or two (y and x), not {len(values)}")
    return float(values[0]), float(values[-1])


def _info(path: Path, args: argparse.Namespace) -> bool:
    hm = read_map(path, args)
    (ny, nx), (dy, dx), (length_y, length_x) = hm.shape, hm.spacing, hm.size
    lines = [
        f"points      {ny} x {nx} (y, x), {hm.missing} missing",
        f"pixel       {dy:.6g} x {dx:.6g} m, map {length_y:.6g} x {length_x:.6g} m",
        f"periodic    {'yes' if hm.periodic else 'no'}",
        *str(surfaces.describe(hm)).splitlines(),
        *(f"history     {_told(step)}" for step in hm.history),
    ]
    output.tell("\n".join([str(path), *(f"  {line}" for line in lines)]))
    if args.html:
        from surfaces.page import section

        args.sections = [*getattr(args, "sections", []), section(hm)]
    return True


def _told(step: Mapping[str, object]) -> str:
    details = ", ".join(f"{key} {_short(value)}" for key, value in step.items() if key != "step")
    return f"{step.get('step', '?')}: {details}"


def _short(value: object) -> str:
    """A value of the history, its numbers to six digits."""
    if isinstance(value, list | tuple):
        return " ".join(map(_short, value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _validate(path: Path, args: argparse.Namespace) -> bool:
    faults = surfaces.validate(path, dataset=args.dataset)
    if not faults:
        output.tell(f"{path}: valid, schema surface/1")
    for fault in faults:
        output.tell(f"{path}: {'fault' if fault.fatal else 'note'}: {fault}")
    return not any(fault.fatal for fault in faults)


def _convert(path: Path, args: argparse.Namespace) -> bool:
    _save(read_map(path, args), path, args)
    return True


def _prepare(path: Path, args: argparse.Namespace) -> bool:
    _save(_read_and_prepared(path, args), path, args)
    return True


def _read_and_prepared(path: Path, args: argparse.Namespace) -> surfaces.HeightMap:
    """The map after the options of `add_preparation`, each step told as it is recorded."""
    before = read_map(path, args)
    hm = prepared(before, args)
    for step in hm.history[len(before.history) :]:
        output.tell(f"{path}: {_told(step)}", error=True)
    return hm


def prepared(hm: surfaces.HeightMap, args: argparse.Namespace) -> surfaces.HeightMap:
    """The map after the options of `add_preparation`, but for the crop, which the read did."""
    level = args.level or ("none" if hm.periodic else "plane")
    band = args.bandpass
    if band is not None:
        band = (band[0] or None, band[1] if math.isfinite(band[1]) else None)
    hm = surfaces.prepare(
        hm,
        level=None if level == "none" else level,
        fill=None if args.fill == "none" else args.fill,
        outliers=args.outliers,
        bandpass=band,
        filter=args.filter,
        fill_limit=args.fill_limit,
    )
    if pixel := _pair(args.resample, "--resample"):
        hm = surfaces.resample(hm, pixel)
    return surfaces.make_periodic(hm, args.periodic) if args.periodic else hm


def _require_targets(files: Sequence[Path], args: argparse.Namespace) -> None:
    """Refuse, before any work, outputs that cannot be written or would replace something."""
    named = [getattr(args, option, None) for option in ("output", "plot", "fans", "html")]
    if hasattr(args, "folder"):
        if (args.output is None) == (args.folder is None):
            raise InputError("say where to write: -o FILE for one input, --folder DIR for several")
        if args.folder is not None:
            output.require_distinct(files)
            output.make_folder(args.folder)
            named += [_target(path, args) for path in files]
    output.require_outputs(*named, inputs=files)
    output.require_pictures(getattr(args, "plot", None), getattr(args, "fans", None))


def _target(path: Path, args: argparse.Namespace) -> Path:
    return Path(args.output) if args.folder is None else Path(args.folder) / f"{path.stem}.h5"


def _save(hm: surfaces.HeightMap, path: Path, args: argparse.Namespace) -> None:
    target = _target(path, args)
    surfaces.write(hm, target, dtype="float32" if args.float32 else "float64")
    output.tell(f"{path} -> {target}", error=True)


def _generate(args: argparse.Namespace) -> int:
    if len(args.shape) > 2 or len(args.size) > 2:
        raise InputError("--shape and --size take one number or two (y and x)")
    output.require_outputs(args.output)
    make = getattr(surfaces, args.texture.replace("-", "_"))
    takes = inspect.signature(make).parameters
    given = {name: getattr(args, name) for name in PARAMETERS if getattr(args, name) is not None}
    for name in sorted(given.keys() - takes.keys()):
        raise InputError(f"--{name.replace('_', '-')} does not belong to {args.texture}")
    if "angle" in given:
        given["angle"] = math.radians(given["angle"])
    given.setdefault("hurst", 0.8)
    for name, parameter in takes.items():
        if parameter.default is parameter.empty and name not in (*given, "shape", "size"):
            raise InputError(f"{args.texture} needs --{name.replace('_', '-')}")
    hm = make((args.shape[0], args.shape[-1]), (args.size[0], args.size[-1]), **given)
    if args.name:
        hm = hm.replace(name=args.name)
    surfaces.write(hm, args.output, dtype="float32" if args.float32 else "float64")
    output.tell(f"{args.output}: {hm!r}, rms height {hm.rms_height:.6g} m", error=True)
    return 0


def _peaks(path: Path, args: argparse.Namespace) -> bool:
    hm = _read_and_prepared(path, args)
    if hm.rms_height == 0.0:
        raise InputError(f"{path}: the map is constant; a flat map has no peaks")
    peaks = surfaces.segment(
        hm, above=args.above, min_prominence=args.min_prominence, wolf=args.wolf
    )
    profiles = surfaces.fit_profiles(hm, peaks)
    columns = {
        "x_m": profiles.x,
        "y_m": profiles.y,
        "height_m": profiles.height,
        "prominence_m": peaks.prominence,
        "basin_area_m2": peaks.basin_area,
        "curvature_1_per_m": profiles.curvature[:, 0],
        "curvature_2_per_m": profiles.curvature[:, 1],
        "angle_rad": profiles.angle,
        "border": peaks.border.astype(int),
        "resolved": profiles.valid.astype(int),
    }
    resolved = int(profiles.valid.sum())
    output.tell(
        f"{path}: {len(peaks)} peaks, {resolved} resolved, {peaks.border.sum()} at the border"
    )
    if args.plot:
        from surfaces.plot import plot_map

        output.save_figure(plot_map(hm, peaks), args.plot)
    if args.fans:
        from surfaces.plot import plot_profiles

        output.save_figure(plot_profiles(profiles, range(min(9, len(peaks)))), args.fans)
    if args.output:
        from asperity.results.storage import write_csv

        write_csv(args.output, columns)
        return True
    shown = list(columns)[:7]
    output.tell("  " + "".join(f"{name:>18s}" for name in shown) + "   (highest ten)")
    for index in range(min(10, len(peaks))):
        output.tell("  " + "".join(f"{float(columns[name][index]):18.6g}" for name in shown))
    return True
