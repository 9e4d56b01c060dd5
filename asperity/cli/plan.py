"""``asperity plan``: what a scene needs and what is left out; nothing is run."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

from asperity.halfspace.material import HalfSpace
from surfaces.heightmap import HeightMap

from . import batch, options, output, targets
from .messages import tell

EPILOG = """example:
  asperity plan scan.h5 --E 210GPa --pressure 1MPa:500MPa:30
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``asperity plan``."""
    options.add_scene_options(parser)
    options.add_model_options(parser)
    targets.add_force(parser)
    batch.add_table(parser)


def run(args: argparse.Namespace) -> int:
    """Print the plan of every map."""
    return batch.each(args, options.on_scene(args, _plan))


def _plan(
    hm: HeightMap, material: HalfSpace, loads: dict[str, Any], args: argparse.Namespace
) -> Mapping[str, Any]:
    from asperity.model.plan import make_plan

    plan = make_plan(hm, material, **loads, **options.model(args))
    tell(f"{hm}\n{plan}")
    return {
        **output.facts_of(hm),
        "boundary": plan.boundary,
        "law": plan.law,
        "interaction": plan.interaction,
        "resampled": plan.resampled is not None,
        "sub_contact_law": plan.sub_contact_law is not None,
        "reasons": plan.reasons,
        "warnings": plan.warnings,
    }
