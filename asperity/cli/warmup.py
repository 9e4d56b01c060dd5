"""``asperity warmup``: compile for this machine all that daily use needs."""

from __future__ import annotations

import argparse

from .exit_codes import EXIT_OK

EPILOG = """example:
  asperity warmup
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """``asperity warmup`` has no options."""


def run(args: argparse.Namespace) -> int:
    """Compile what the disk does not hold, and name the folder that keeps it."""
    from asperity.compilation import CURVE, HARD, compile_ahead
    from surfaces.numerics.compiled import cache_folder

    compile_ahead(*CURVE, *HARD, "bem")
    print(f"compiled code   {cache_folder()}")
    return EXIT_OK
