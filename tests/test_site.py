"""The documentation site builds without a warning, and shows every public name."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import asperity
import surfaces

ROOT = Path(__file__).resolve().parents[1]


def test_every_public_name_is_in_the_reference():
    text = (ROOT / "docs" / "api.rst").read_text()
    parts = re.split(r"\.\. currentmodule:: (\w+)\n", text)[1:]
    shown: dict[str, set[str]] = {"asperity": set(), "surfaces": set()}
    for package, part in zip(parts[::2], parts[1::2], strict=True):
        shown[package] |= set(re.findall(r"^   (\w+)$", part, re.MULTILINE))
    # the classes of errors are the same in both packages
    assert shown["asperity"] == set(asperity.__all__)
    assert shown["surfaces"] | shown["asperity"] >= set(surfaces.__all__)
    assert shown["surfaces"] <= set(surfaces.__all__)


def test_the_site_builds(tmp_path: Path):
    """All pages and links, without running stories and notebooks, which have tests of their own."""
    for needed in ("sphinx", "furo", "myst_nb", "sphinx_gallery"):
        pytest.importorskip(needed)
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "dummy"]
    skip = ["-D", "plot_gallery=0", "-D", "nb_execution_mode=off"]
    done = subprocess.run(
        [*command, *skip, ROOT / "docs", tmp_path],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
