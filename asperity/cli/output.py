"""Results of the commands that make a curve: kept as they come, written and told at the end."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from asperity import __version__
from asperity.progress import bar
from asperity.results.curve import ContactCurve, at_heaviest

from . import batch, derived, targets
from .exit_codes import EXIT_NOT_CONVERGED, EXIT_OK
from .messages import tell, warn

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from surfaces import HeightMap

    from .options import SceneWork


def add_output_options(parser: argparse.ArgumentParser, *, report: bool = False) -> None:
    """Options that say where results go."""
    group = parser.add_argument_group(
        "output",
        "With a folder, DIR/, each file is called as its input: DIR/scan.h5.\n"
        "With several inputs a file name gets theirs in front: scan-curve.csv.",
    )
    targets.add_target(
        group,
        "-o",
        "--output",
        suffix=".h5",
        alone="results.h5",
        several="results/",
        help="results file (default results.h5, of several inputs in results/)",
    )
    told = " (default report.html, or as -o says)" if report else ""
    targets.add_target(
        group,
        "--report",
        suffix=".html",
        one=True,
        alone="report.html" if report else None,
        several="report.html" if report else None,
        help=f"page about all inputs side by side{told}",
    )
    if not report:
        targets.add_target(group, "--plot", suffix=".png", help="picture of the curve")
    group.add_argument(
        "--resume", action="store_true", help="continue from the points in the results file"
    )
    targets.add_force(group)
    targets.add_target(group, "--csv", suffix=".csv", help="also write the curve as CSV")
    batch.add_table(group, several="table.csv")


def each(args: argparse.Namespace, work: SceneWork) -> int:
    """Do the work on every map; then, where a report is asked for, write a page about all results.

    The material has to allow what the options derive from the curve, where there are such options.
    """
    from . import options

    if "slip" in args:
        derived.require_derivable(options.material(args), options.loads(args), args)
    code = batch.each(args, options.on_scene(args, work))
    done = [row["output"] for row in args.document if "output" in row]
    if args.report and done:
        from asperity.comparison.report.build import write_report
        from asperity.comparison.report.sample import read_sample

        write_report(args.report, [read_sample(file) for file in done])
        tell(f"report          {args.report}")
    return code


def add_fields_option(parser: argparse.ArgumentParser, what: str) -> None:
    """Option for the fields of the last load point."""
    targets.add_target(
        parser, "--fields", suffix=".vti", help=f"ParaView file of {what}, last point"
    )


def solve_and_keep(
    solve: Callable[..., ContactCurve],
    hm: HeightMap,
    material: HalfSpace,
    loads: dict[str, Any],
    args: argparse.Namespace,
    model: str,
    request: dict[str, Any],
    chained: bool = False,
) -> ContactCurve:
    """Run a solver that takes load points, `progress` and `checkpoint`, such as `contact_curve` of
    a map and a material; each finished point is kept in the results file.

    With `chained`, missing points are solved with all others (`run_resumably`).
    """
    from asperity.halfspace.scene import checked_loads
    from asperity.results.resume import run_resumably

    kind, values = checked_loads(hm, material, **loads)
    with bar(len(values), "load points") as advance:

        def solve_points(points: Any, keep: Any, paths: dict[str, Any]) -> ContactCurve:
            told = {"progress": advance, "checkpoint": keep}
            return solve(**{f"{kind}s": points}, **told, **({} if chained else {"paths": paths}))

        return run_resumably(
            solve_points,
            values,
            kind,
            args.output,
            model=model,
            request=request,
            resume=args.resume,
            chained=chained,
        )


def request_of(
    hm: HeightMap, material: HalfSpace, args: argparse.Namespace, settings: dict[str, Any]
) -> dict[str, Any]:
    """Facts that an interrupted run and the one that goes on with it must share."""
    return {
        "version": __version__,
        "command": args.command,
        "kind of load points": "pressure" if args.separation is None else "separation",
        "input": hm.digest,
        **material.facts,
        **settings,
    }


def finish(
    curve: ContactCurve, hm: HeightMap, material: HalfSpace, args: argparse.Namespace
) -> dict[str, Any]:
    """Write the CSV where asked, tell the curve and what follows from it; return what was found."""
    from asperity.results.storage import write_csv

    more = derived.conductance(curve, args)
    columns = curve.columns() | more
    if args.csv:
        write_csv(args.csv, columns)
    if args.plot:
        _draw(curve, args.plot)
    try:
        if args.slip:
            derived.write_slip(curve, material, args)
    finally:
        lines = [
            f"{name}     {' '.join(f'{v:.4g}' for v in values)} S/m^2 or W/(m^2 K)"
            for name, values in more.items()
        ]
        silent = replace(curve, settings={**curve.settings, "warnings": []})  # told before
        tell("\n".join([args.file, str(silent), *lines, f"results         {args.output}"]))
    return {
        **at_heaviest(curve),
        **facts_of(hm),
        "seconds": sum(curve.seconds.values()),
        "model": curve.model,
        "output": args.output,
        "curve": columns,
        "settings": curve.settings,
        "seconds_by_stage": curve.seconds,
    }


def _draw(curve: ContactCurve, target: str) -> None:
    """Picture of contact area and of separation against pressure."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4), layout="constrained")
    area, separation = figure.subplots(1, 2)
    curve.plot(ax=area)
    curve.plot("separation", "mean_pressure", ax=separation)
    targets.save_figure(figure, target)


def facts_of(hm: HeightMap) -> dict[str, Any]:
    """What a table tells of a map."""
    return {"rms_height": hm.rms_height, "rms_slope": hm.roughness.rms_slope}


def last_converged(curve: ContactCurve, args: argparse.Namespace) -> bool:
    """Whether the last load point can be shown; says so where it cannot."""
    if not curve.converged[-1]:
        text = "the last load point did not converge: no table and no field of it is written"
        warn(args, text)
    return bool(curve.converged[-1])


def exit_code(curves: Iterable[ContactCurve]) -> int:
    """0 if every load point converged, else 1."""
    return EXIT_OK if all(c.converged.all() for c in curves) else EXIT_NOT_CONVERGED
