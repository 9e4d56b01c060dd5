"""Every example runs as it stands, and prints the number pinned here."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def run(name: str, folder: Path) -> str:
    code = f"import sys; sys.path.insert(0, {str(EXAMPLES.parent)!r}); " + (
        f"import runpy; runpy.run_path({str(EXAMPLES / name)!r}, run_name='__main__')"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_ten_lines(tmp_path):
    share = re.search(r"([\d.]+) % touches", run("01_ten_lines.py", tmp_path))
    assert share is not None
    assert float(share[1]) == pytest.approx(2.5, abs=0.05)


def test_compare_with_bem(tmp_path):
    text = run("02_compare_with_bem.py", tmp_path)
    overlap = re.search(r"overlap ([\d.]+)", text)
    assert overlap is not None
    assert float(overlap[1]) > 0.6
    assert (tmp_path / "report.html").stat().st_size > 20_000


def test_measured_map(tmp_path):
    text = run("03_measured_map.py", tmp_path)
    assert "10 points, 10 converged" in text
    assert "'step': 'level'" in text


def test_graded_half_space(tmp_path):
    text = run("04_graded_half_space.py", tmp_path)
    pairs = re.findall(r"mean pressure (\S+) Pa, boundary elements (\S+) Pa", text)
    assert len(pairs) == 6
    for model, reference in pairs:
        assert float(model) == pytest.approx(float(reference), rel=0.15)


def test_the_readme_shows_the_first_example():
    readme = (EXAMPLES.parent / "README.md").read_text()
    code = (EXAMPLES / "01_ten_lines.py").read_text().split('"""', 2)[2].strip()
    assert code in readme


def test_one_contact(tmp_path):
    text = run("05_one_contact.py", tmp_path)
    errors = re.findall(r"mN, (\S+) % of force, expected (\S+) %", text)
    (published, _), (resolved, expected) = ((float(a), float(b)) for a, b in errors)
    assert published == pytest.approx(-4.15, abs=0.1)
    assert abs(resolved) < min(expected, abs(published) / 4)


def test_picture(tmp_path):
    assert "The model is" in run("06_picture.py", tmp_path)
    assert (tmp_path / "contact.png").stat().st_size > 20_000


def test_beyond_the_curve(tmp_path):
    text = run("07_beyond_the_curve.py", tmp_path)
    assert len(re.findall(r" carr(?:y|ies) 1\.000000 of the load", text)) == 2
    conductance = re.search(r"conductance (\S+) S", text)
    assert conductance is not None
    # slope of boundary elements (map refined twice, 1e-7) between 0.97 and 1.03 of the load
    assert float(conductance[1]) == pytest.approx(1.584e10, rel=0.03)
    assert (tmp_path / "contact.vti").is_file()


def test_hardness(tmp_path):
    text = run("08_hardness.py", tmp_path)
    touches = [float(share) for share in re.findall(r"(\S+) % touches", text)]
    assert len(touches) == 4 and touches == sorted(touches, reverse=True)
    first, again = (float(a) for a in re.findall(r"(?:elements|elastically): (\S+) %", text))
    assert first == pytest.approx(touches[0], rel=0.03)
    assert again == pytest.approx(first, rel=0.06)


def test_figures_of_the_paper(tmp_path):
    """A coarse run of the script that regenerates them: contours, errors, pressure."""
    from runpy import run_path

    script = run_path(str(EXAMPLES / "paper_figures.py"))
    assert script["main"](["--quick", "--only", "1,6", "--out", str(tmp_path)]) == 0
    rows = (tmp_path / "fig01.csv").read_text().splitlines()
    assert len(rows) == 17 and rows[0].startswith("shape,k,m,d,law,e_F_percent")
    for number in ("01", "06"):
        assert (tmp_path / f"fig{number}.png").stat().st_size > 20_000
