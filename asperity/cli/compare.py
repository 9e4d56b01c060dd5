"""``asperity compare``: both models on one or several surfaces, results file and report."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asperity.halfspace.material import HalfSpace
from asperity.progress import bar
from surfaces.heightmap import HeightMap

from . import batch, options, output, targets
from .messages import tell

if TYPE_CHECKING:
    from asperity.comparison.result import Comparison

EPILOG = """examples:
  asperity compare scan.h5 --E 210GPa --nu 0.3
  asperity compare 'scans/*.h5' --E 210GPa --fill harmonic --periodic taper -o compared/
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity compare``."""
    options.add_scene_options(parser)
    options.add_model_options(parser)
    options.add_tolerance_option(parser)
    output.add_output_options(parser, report=True)


def run(args: argparse.Namespace) -> int:
    """Compare on each file; a bad file is named and the others go on."""
    if args.report is None and args.output is not None:
        targets.fill_in(args, len(batch.expand(args.files)) > 1)
        args.report = targets.beside(args.output, "report.html")
    return output.each(args, _compare)


def _compare(
    hm: HeightMap, material: HalfSpace, loads: dict[str, Any], args: argparse.Namespace
) -> Mapping[str, Any]:
    from asperity.bem.curve import bem_curve
    from asperity.comparison.run import compare
    from asperity.halfspace.scene import checked_loads
    from asperity.results.resume import require_continuable, with_held
    from asperity.results.storage import columns, write_csv, write_results

    settings = options.elements(args)
    request = output.request_of(hm, material, args, settings)
    if args.resume and Path(args.output).exists():
        kind, values = checked_loads(hm, material, **loads)
        held = require_continuable(args.output, request).curves
        solved = [curve for curve in held.values() if curve.model == "bem"]
        loads = {f"{kind}s": with_held(values, kind, solved)}

    solve = partial(bem_curve, hm, material, **settings)
    kept = (hm, material, loads, args, "bem", request)
    with bar(None, Path(args.file).name) as advance:
        comparison = compare(
            hm,
            material,
            **loads,
            **options.model(args),
            tolerance=args.tolerance,
            reference=partial(output.solve_and_keep, solve, *kept),
            progress=advance,
        )
    content = comparison.to_results()
    content.about["request"] = request
    write_results(args.output, content)
    if args.csv:
        write_csv(args.csv, columns(comparison.table))
    tell(f"{args.file}\n{comparison}\nresults         {args.output}")
    return _row(comparison, hm) | {"output": args.output}


def _row(comparison: Comparison, hm: HeightMap) -> dict[str, Any]:
    """A row of the table, and what else a comparison tells."""
    from asperity.results.storage import columns

    row, ours = comparison.table[comparison.map_point], comparison.pareto[0]
    told = ("mean_pressure", "area_bem", "area_model")
    curves = (comparison.model, comparison.reference)
    return {
        **{name: row[name] for name in told},
        "rms_load_error": ours["load_error"],
        "rms_area_error": ours["area_error"],
        "separation_bem": row["separation_bem"],
        "separation_model": row["separation_model"],
        "overlap": comparison.overlap,
        "converged": comparison.converged,
        "points": len(comparison.table),
        **output.facts_of(hm),
        "seconds_model": ours["seconds"],
        "seconds_bem": sum(comparison.reference.seconds.values()),
        "reason": next((why for curve in curves for why in curve.reasons if why), ""),
        "comparison": {
            "verdict": comparison.verdict(),
            "points": columns(comparison.table),
            "runs": columns(comparison.pareto),
        },
    }
