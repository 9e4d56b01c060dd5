"""Every example runs as it stands, and prints the number pinned here."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from runpy import run_path

import matplotlib
import pytest
from matplotlib import pyplot

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


@pytest.fixture
def run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[[str], str]:
    """Runs an example in an empty folder, and returns what it prints."""
    matplotlib.use("Agg")
    monkeypatch.setattr(pyplot, "show", lambda: pyplot.close("all"))
    monkeypatch.chdir(tmp_path)

    def of(name: str) -> str:
        run_path(str(EXAMPLES / name), run_name="__main__")
        return capsys.readouterr().out

    return of


def test_ten_lines(run):
    share = re.search(r"([\d.]+) % touches", run("01_ten_lines.py"))
    assert share is not None
    assert float(share[1]) == pytest.approx(2.5, abs=0.05)


def test_compare_with_bem(run, tmp_path):
    text = run("02_compare_with_bem.py")
    overlap = re.search(r"overlap ([\d.]+)", text)
    assert overlap is not None
    assert float(overlap[1]) > 0.6
    assert (tmp_path / "report.html").stat().st_size > 20_000


def test_measured_map(run):
    text = run("03_measured_map.py")
    assert "10 points, 10 converged" in text
    assert "'step': 'level'" in text


def test_graded_half_space(run):
    text = run("04_graded_half_space.py")
    pairs = re.findall(r"mean pressure (\S+) Pa, boundary elements (\S+) Pa", text)
    assert len(pairs) == 6
    for model, reference in pairs:
        assert float(model) == pytest.approx(float(reference), rel=0.15)


def test_the_readme_shows_the_first_example():
    readme = (EXAMPLES.parent / "README.md").read_text()
    code = (EXAMPLES / "01_ten_lines.py").read_text().split('"""', 2)[2]
    assert code.partition("# %%")[0].strip() in readme


def test_one_contact(run):
    text = run("05_one_contact.py")
    errors = re.findall(r"mN, (\S+) % of force, expected (\S+) %", text)
    (published, _), (resolved, expected) = ((float(a), float(b)) for a, b in errors)
    assert published == pytest.approx(-4.15, abs=0.1)
    assert abs(resolved) < min(expected, abs(published) / 4)


def test_picture(run, tmp_path):
    assert "The model is" in run("06_picture.py")
    assert (tmp_path / "contact.png").stat().st_size > 20_000


def test_beyond_the_curve(run, tmp_path):
    text = run("07_beyond_the_curve.py")
    assert len(re.findall(r" carr(?:y|ies) 1\.000000 of the load", text)) == 2
    conductance = re.search(r"conductance (\S+) S", text)
    assert conductance is not None
    # slope of boundary elements (map refined twice, 1e-7) between 0.97 and 1.03 of the load
    assert float(conductance[1]) == pytest.approx(1.584e10, rel=0.03)
    assert (tmp_path / "contact.vti").is_file()


def test_hardness(run):
    text = run("08_hardness.py")
    touches = [float(share) for share in re.findall(r"(\S+) % touches", text)]
    assert len(touches) == 4 and touches == sorted(touches, reverse=True)
    first, again = (float(a) for a in re.findall(r"(?:elements|elastically): (\S+) %", text))
    assert first == pytest.approx(touches[0], rel=0.03)
    assert again == pytest.approx(first, rel=0.06)


def numbers(pattern: str, text: str) -> list[float]:
    return [float(value) for value in re.findall(pattern, text)]


def test_cut_off(run):
    """Rougher maps touch less; the area fraction is 2 to 2.6 p / (E* h')."""
    text = run("09_cut_off.py")
    slopes, areas = numbers(r"slope (\S+),", text), numbers(r"(\S+) % touches", text)
    assert areas == sorted(areas)
    factors = [
        0.01 * area * slope * 3e9 / 0.84 / 5e6 for area, slope in zip(areas, slopes, strict=True)
    ]
    assert 2.0 < min(factors) and max(factors) < 2.6


def test_two_bodies(run):
    text = run("10_two_bodies.py")
    assert "E* = 58.6 GPa, hardness 1.0 GPa" in text
    ground, blasted, both = numbers(r"(\S+) um apart", text)
    assert both > max(ground, blasted)


def test_worn_surface(run):
    text = run("11_worn_surface.py")
    areas, spots, separations = (
        numbers(pattern, text) for pattern in (r"(\S+) % in", r"in (\d+) spots", r"(\S+) um from")
    )
    for new, worn in zip(range(3), range(3, 6), strict=True):
        assert areas[worn] > 3 * areas[new]
        assert spots[worn] > spots[new]
        assert separations[worn] < separations[new]


def test_ensemble(run):
    """Light loads scatter more."""
    text = run("12_ensemble.py")
    light, heavy = (numbers(rf"([\d.]+) % at {load}", text) for load in ("0.1 MPa", "10 MPa"))
    assert len(light) == 2
    assert all(a > 1.5 * b > 0 for a, b in zip(light, heavy, strict=True))


def test_every_story_is_tested_and_has_a_title_and_a_picture():
    tests = Path(__file__).read_text()
    for story in sorted(EXAMPLES.glob("[0-9]*.py")):
        text = story.read_text()
        assert f'run("{story.name}"' in tests
        assert re.match(r'"""\n(.+)\n=+\n\n', text), story.name
        assert "plt.show()" in text, story.name


def test_figures_of_the_paper(tmp_path):
    """A coarse run of the script that regenerates them: contours, errors, pressure."""
    script = run_path(str(EXAMPLES / "paper_figures.py"))
    assert script["main"](["--quick", "--only", "1,6", "--out", str(tmp_path)]) == 0
    rows = (tmp_path / "fig01.csv").read_text().splitlines()
    assert len(rows) == 17 and rows[0].startswith("shape,k,m,d,law,e_F_percent")
    for number in ("01", "06"):
        assert (tmp_path / f"fig{number}.png").stat().st_size > 20_000
