"""``asperity compare``: both models on one or several surfaces, results file and report."""

from __future__ import annotations

import argparse
import sys
from functools import partial
from pathlib import Path

from asperity.errors import AsperityError

from . import options, output
from .exit_codes import EXIT_BAD_INPUT, EXIT_NOT_CONVERGED, EXIT_OK
from .surface import expand

EPILOG = """examples:
  asperity compare scan.h5 --E 210e9 --nu 0.3
  asperity compare scans/*.h5 --E 210e9 --level plane --fill harmonic --periodic taper
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity compare``."""
    parser.epilog = EPILOG
    options.add_surface_options(parser, several=True)
    options.add_material_options(parser)
    options.add_load_options(parser)
    options.add_model_options(parser)
    options.add_tolerance_option(parser)
    output.add_output_options(parser, report=True)


def run(args: argparse.Namespace) -> int:
    """Compare on each file; a bad file is named and the others go on."""
    material, loads = options.material(args), options.loads(args)
    paths = expand(args.files)
    output.require_distinct(paths)
    files, several = [str(path) for path in paths], len(paths) > 1
    targets = {path: _targets(path, args, several) for path in files}
    output.require_outputs(*(name for names in targets.values() for name in names), inputs=files)
    worst = EXIT_OK
    for file in files:
        try:
            converged = _compare_one(file, args, material, loads, targets[file])
        except (AsperityError, MemoryError) as error:
            if not several:
                raise
            sys.stderr.write(f"asperity compare: {output.told(file, error)}\n")
            worst = EXIT_BAD_INPUT
        else:
            worst = worst if converged else max(worst, EXIT_NOT_CONVERGED)
    return worst


def _targets(file: str, args: argparse.Namespace, several: bool) -> list[str | None]:
    """Names of the results, the report and the table of one input."""
    names = (args.results, args.report, args.csv)
    return [name and output.named(name, Path(file).stem, several) for name in names]


def _compare_one(file, args, material, loads, targets) -> bool:  # type: ignore[no-untyped-def]
    hm = options.load_surface(file, args)
    from asperity.bem.curve import bem_curve
    from asperity.comparison.run import compare
    from asperity.results.resume import require_continuable
    from asperity.results.storage import columns, write_csv, write_results

    results, report, table = targets
    settings = {"tolerance": args.tolerance, "boundary": args.boundary}
    request = output.request_of(hm, material, args, settings)
    if args.resume and Path(results).exists():
        require_continuable(results, request)

    solve = partial(bem_curve, hm, material, **settings)
    kept = (hm, material, loads, results, "bem", request, args.resume)
    with output.bar(None, Path(file).name) as advance:
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
    write_results(results, content)
    comparison.to_html(report)
    if table:
        write_csv(table, columns(comparison.table))
    print(f"{file}\n{comparison}\nresults {results}, report {report}", flush=True)
    return comparison.converged
