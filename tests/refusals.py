"""Refusals of the command line: a good map to begin with, and the one sentence of a bad call."""

from __future__ import annotations

import pytest

import surfaces
from asperity.cli.main import main

STEEL = ["--E", "210e9", "--nu", "0.3"]


def good_map(shape: tuple[int, int] = (24, 32)) -> surfaces.HeightMap:
    return surfaces.self_affine(shape, (24e-6, 32e-6), hurst=0.8, rms_slope=0.1, seed=1)


def refusal(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """Run the command and return its one sentence, having checked that it is one."""
    try:
        code = main(arguments)
    except SystemExit as leaving:
        code = leaving.code
    shown = capsys.readouterr()
    assert code == 2, shown.err
    assert shown.err.count("\n") == 1, shown.err
    assert "Traceback" not in shown.err
    return shown.err
