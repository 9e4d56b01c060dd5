"""Shared fixtures: where the measured maps lie, and how a test without them is skipped."""

from __future__ import annotations

import os
from pathlib import Path

import pytest


def measured_folder() -> Path:
    """Folder of the measured maps: ASPERITY_MEASURED, or shared/measured beside the checkout."""
    beside = Path(__file__).resolve().parents[2] / "shared" / "measured"
    return Path(os.environ.get("ASPERITY_MEASURED", beside))


@pytest.fixture(scope="session")
def measured() -> Path:
    """Folder of the measured maps; the test is skipped where they are absent."""
    folder = measured_folder()
    if not folder.is_dir():
        pytest.skip(f"no measured maps at {folder.name}; set ASPERITY_MEASURED to their folder")
    return folder
