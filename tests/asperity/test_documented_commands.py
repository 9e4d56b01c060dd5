"""The commands of docs/surfaces.md take every measured map from its file to its peaks."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from asperity.cli.main import main

PAGE = Path(__file__).resolve().parents[2] / "docs" / "surfaces.md"
COMMANDS = re.findall(r"^    asperity (surface peaks .*)$", PAGE.read_text(), re.MULTILINE)


@pytest.mark.parametrize("command", COMMANDS)
def test_command(command: str, measured: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = command.split()
    words[2] = str(measured / words[2])
    assert main(words) == 0
    out = capsys.readouterr().out
    count = re.search(r"(\d+) peaks, (\d+) resolved", out)
    assert count is not None and int(count[1]) >= 5
    assert int(count[2]) > 0.5 * int(count[1])


def test_every_measured_map_has_its_command(measured: Path) -> None:
    named = {command.split()[2] for command in COMMANDS}
    assert named == {path.name for path in measured.glob("*.h5")}
