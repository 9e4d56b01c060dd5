"""The notebooks of the site run from the first cell to the last, and are stored without outputs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))


def executed(path: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Everything that a notebook prints."""
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.delenv("MPLBACKEND", raising=False)
    notebook: Any = nbformat.read(path, as_version=4)
    nbclient.execute(notebook, cwd=folder, timeout=300)
    outputs = [one for cell in notebook.cells for one in cell.get("outputs", [])]
    assert any("image/png" in one.get("data", {}) for one in outputs)
    return "".join(one["text"] for one in outputs if one["output_type"] == "stream")


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_hold_no_outputs(path: Path):
    cells = nbformat.read(path, as_version=4).cells
    code = [cell for cell in cells if cell.cell_type == "code"]
    assert code
    assert not any(cell.outputs or cell.execution_count for cell in code)


def test_a_stand_in_map_goes_to_an_answer(tmp_path, monkeypatch):
    monkeypatch.delenv("ASPERITY_MEASURED", raising=False)
    text = executed(NOTEBOOKS[0], tmp_path, monkeypatch)
    assert "level the map" in text
    assert "% touches" in text


def test_a_measured_map_goes_to_an_answer(measured: Path, tmp_path, monkeypatch):
    monkeypatch.setenv("ASPERITY_MEASURED", str(measured))
    assert "0.50 % touches" in executed(NOTEBOOKS[0], tmp_path, monkeypatch)


def test_the_accuracy_that_is_needed(tmp_path, monkeypatch):
    assert "largest other uncertainty" in executed(NOTEBOOKS[1], tmp_path, monkeypatch)
