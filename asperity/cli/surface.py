"""``asperity surface``: look at, make, prepare, convert and check height-map files."""

from __future__ import annotations

import argparse
import functools
import inspect
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import surfaces
from surfaces.checks import constant
from surfaces.errors import InputError
from surfaces.history import in_words

from . import batch, targets
from .exit_codes import EXIT_OK
from .messages import tell
from .surface_options import EPILOG, PARAMETERS, add_arguments

__all__ = ["EPILOG", "add_arguments", "generator", "prepared", "read_map", "reading", "run"]


def run(args: argparse.Namespace) -> int:
    """Run one action on every file; a bad file is named and the batch goes on."""
    if args.action == "generate":
        return _generate(args)
    actions: dict[str, batch.Work] = {
        "info": _info,
        "validate": _validate,
        "convert": _convert,
        "prepare": _prepare,
        "peaks": _peaks,
    }
    args.sections = []
    code = batch.each(args, actions[args.action])
    if args.sections:
        from surfaces.page import write_page

        write_page(args.sections, Path(args.report))
        tell(f"report {args.report}")
    return code


def read_map(path: str | Path, args: argparse.Namespace) -> surfaces.HeightMap:
    """The map, or the part of it that ``--crop`` keeps, as the options of `add_reading` say."""
    crop = getattr(args, "crop", None)
    rows, columns = ((crop[0], crop[1]), (crop[2], crop[3])) if crop else (None, None)
    return surfaces.read(path, **reading(args), rows=rows, columns=columns)


def reading(args: argparse.Namespace) -> dict[str, Any]:
    """What the options of `add_reading` say of a file, as keyword arguments."""
    spacing = _pair(args.spacing, "--spacing")
    return {"dataset": args.dataset, "unit": args.unit, "spacing": spacing}


def _pair(values: Sequence[float] | None, option: str) -> tuple[float, float] | None:
    if values is None:
        return None
    if len(values) not in (1, 2):
        raise InputError(f"{option} takes one number or two (y and x), not {len(values)}")
    return float(values[0]), float(values[-1])


def _info(args: argparse.Namespace) -> Mapping[str, Any]:
    if args.memory is None:
        hm = read_map(args.file, args)
        if not args.report:
            return _describe(args.file, hm, surfaces.describe(hm))
        from surfaces.page import section

        args.sections.append(section(hm))
        return _describe(args.file, hm, args.sections[-1].found)
    if args.report:
        raise InputError("--report draws the map and needs all of it; leave out --memory")
    with surfaces.open(args.file, **reading(args)) as file:
        hm = file.on_disk()
    return _describe(args.file, hm, surfaces.describe(hm))


def _describe(path: str, hm: surfaces.HeightMap, found: surfaces.Statistics) -> Mapping[str, Any]:
    """Tell what a map is and how rough; returns its row of the table."""
    (ny, nx), (dy, dx) = hm.shape, hm.spacing
    lines = [
        f"points      {ny} x {nx} (y, x), {hm.missing} missing",
        f"pixel       {dy:.6g} x {dx:.6g} m, map {ny * dy:.6g} x {nx * dx:.6g} m",
        f"periodic    {'yes' if hm.periodic else 'no'}",
        *str(found).splitlines(),
        *(f"history     {step}" for step in in_words(hm.history)),
    ]
    tell("\n".join([path, *(f"  {line}" for line in lines)]))
    spectral = {} if found.moments is None else {"rms_slope": found.moments.rms_slope}
    return {
        **_map_row(hm),
        **found.parameters,
        **spectral,
        "warnings": found.warnings,
        "history": hm.history,
    }


def _map_row(hm: surfaces.HeightMap) -> dict[str, Any]:
    (ny, nx), (dy, dx) = hm.shape, hm.spacing
    return {"ny": ny, "nx": nx, "dy": dy, "dx": dx, "missing": hm.missing, "periodic": hm.periodic}


def _validate(args: argparse.Namespace) -> Mapping[str, Any]:
    faults = surfaces.validate(args.file, dataset=args.dataset)
    if not faults:
        tell(f"{args.file}: valid, schema surface/1")
    for fault in faults:
        tell(f"{args.file}: {'fault' if fault.fatal else 'note'}: {fault}")
    fatal = [str(fault) for fault in faults if fault.fatal]
    return {
        "valid": not fatal,
        "faults": len(fatal),
        "notes": len(faults) - len(fatal),
        "reason": fatal[0] if fatal else "",
        "all_faults": [{"text": str(fault), "fatal": fault.fatal} for fault in faults],
    }


def _convert(args: argparse.Namespace) -> Mapping[str, Any]:
    return _saved(read_map(args.file, args), args)


def _prepare(args: argparse.Namespace) -> Mapping[str, Any]:
    return _saved(_read_and_prepared(args), args)


def _saved(hm: surfaces.HeightMap, args: argparse.Namespace) -> Mapping[str, Any]:
    surfaces.write(hm, args.output, dtype="float32" if args.float32 else "float64")
    tell(f"{args.file} -> {args.output}")
    rough = {"rms_height": hm.rms_height, "rms_slope": hm.roughness.rms_slope}
    return _map_row(hm) | rough | {"output": args.output, "history": hm.history}


def _read_and_prepared(args: argparse.Namespace) -> surfaces.HeightMap:
    """The map after the options of `add_preparation`, each step told as it is recorded."""
    before = read_map(args.file, args)
    hm = prepared(before, args)
    for step in in_words(hm.history[len(before.history) :]):
        tell(f"{args.file}: {step}")
    return hm


def prepared(hm: surfaces.HeightMap, args: argparse.Namespace) -> surfaces.HeightMap:
    """The map after the options of `add_preparation`, but for the crop, which the read did."""
    level = args.level or ("none" if hm.periodic else "plane")
    band = args.bandpass
    if band is not None:
        band = (band[0] or None, band[1] if math.isfinite(band[1]) else None)
    hm = surfaces.prepare(
        hm,
        level=level,
        fill=args.fill,
        outliers=args.outliers,
        bandpass=band,
        filter=args.filter,
        fill_limit=args.fill_limit,
    )
    if pixel := _pair(args.resample, "--resample"):
        hm = surfaces.resample(hm, pixel)
    return surfaces.make_periodic(hm, args.periodic) if args.periodic else hm


def generator(args: argparse.Namespace) -> functools.partial[surfaces.HeightMap]:
    """What makes the surface of the options of `add_generation`, with all its arguments."""
    if len(args.shape) > 2 or len(args.size) > 2:
        raise InputError("--shape and --size take one number or two (y and x)")
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
    shape, size = (args.shape[0], args.shape[-1]), (args.size[0], args.size[-1])
    return functools.partial(make, shape, size, **given)


def _generate(args: argparse.Namespace) -> int:
    if args.memory is not None and args.texture != "self-affine":
        raise InputError(f"--memory does not belong to {args.texture}")
    make, dtype = generator(args), "float32" if args.float32 else "float64"
    targets.require(args)
    if args.memory is not None:
        facts: dict[str, Any] = make.keywords | {"dtype": dtype}
        surfaces.write_self_affine(args.output, *make.args, name=args.name or "", **facts)
        tell("{}: {} x {} points".format(args.output, *make.args[0]))
        return EXIT_OK
    hm = make()
    if args.name:
        hm = hm.replace(name=args.name)
    surfaces.write(hm, args.output, dtype=dtype)
    tell(f"{args.output}: {hm!r}, rms height {hm.rms_height:.6g} m")
    return EXIT_OK


def _peaks(args: argparse.Namespace) -> Mapping[str, Any]:
    hm = _read_and_prepared(args)
    if constant(hm):
        raise InputError(f"{args.file}: the map is constant; a flat map has no peaks")
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
    counts = {
        "peaks": len(peaks),
        "resolved": int(profiles.valid.sum()),
        "at_border": int(peaks.border.sum()),
    }
    tell(
        "{0}: {peaks} peaks, {resolved} resolved, {at_border} at the border".format(
            args.file, **counts
        )
    )
    if args.plot:
        from surfaces.plot import plot_map

        targets.save_figure(plot_map(hm, peaks), args.plot)
    if args.fans:
        from surfaces.plot import plot_profiles

        targets.save_figure(plot_profiles(profiles, range(min(9, len(peaks)))), args.fans)
    if args.output:
        from asperity.results.storage import write_csv

        write_csv(args.output, columns)
    else:
        shown = list(columns)[:7]
        tell("  " + "".join(f"{name:>18s}" for name in shown) + "   (highest ten)")
        for index in range(min(10, len(peaks))):
            tell("  " + "".join(f"{float(columns[name][index]):18.6g}" for name in shown))
    return counts | {"columns": columns}
