"""What the pages show can be done and is so: code runs, commands, links and tables are right."""

from __future__ import annotations

import re
import shlex
import shutil
import warnings
from glob import glob
from pathlib import Path
from runpy import run_path
from textwrap import dedent

import numpy as np
import pytest

import asperity
import surfaces
from asperity.cli.main import COMMANDS, build_parser, main

ROOT = Path(__file__).resolve().parents[1]
FOR_USERS = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
PAGES = [
    *FOR_USERS,
    ROOT / "CONTRIBUTING.md",
    ROOT / "CHANGELOG.md",
    *sorted((ROOT / "docs" / "development").glob("*.md")),
]
HEADER = r"asperity (?:" + "|".join(COMMANDS) + r")(?= |\n)[^\n#`]*"


def _blocks(language: str) -> list[tuple[str, str]]:
    """Page and text of the fenced blocks of a language."""
    pattern = re.compile(rf"^( *)```{language}\n(.*?)^ *```", re.MULTILINE | re.DOTALL)
    return [
        (page.name, dedent(text)) for page in PAGES for _, text in pattern.findall(page.read_text())
    ]


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Small files with the names that the pages use."""
    h5py = pytest.importorskip("h5py")
    folder = tmp_path_factory.mktemp("pages")
    hm = surfaces.self_affine(
        (64, 80), (6.4e-4, 8e-4), hurst=0.8, rms_slope=0.1, rolloff=2e-4, cutoff=6e-5, seed=1
    )
    for name in ("scan", "other_body", "large", "scans/a", "scans/b"):
        (folder / name).parent.mkdir(exist_ok=True)
        surfaces.write(hm, folder / f"{name}.h5")
    with h5py.File(folder / "other.h5", "w") as file:
        file["scan/z"] = hm.heights * 1e6
    r, phi = np.linspace(0.0, 1e-6, 9), np.arange(8) * np.pi / 4
    with h5py.File(folder / "profile.h5", "w") as file:
        file["r"], file["phi"], file["f"] = r, phi, np.outer(r**2 / 2e-6, np.ones(8))
    material = asperity.HalfSpace(210e9, 0.3)
    asperity.compare(hm, material, pressures=[1e8, 3e8]).to_hdf5(folder / "results.h5")
    return folder


@pytest.fixture
def folder(files: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A fresh copy of these files, and the place where a command runs."""
    shutil.copytree(files, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_python_on_the_pages_runs(here, folder):
    blocks = [text for name, text in _blocks("python") if name != "README.md"]
    assert len(blocks) >= 3
    for text in blocks:
        rows = np.zeros((2, 4))
        names = {"shape": (4, 4), "spacing": 1e-6, "blocks": [rows, rows], "asperity": asperity}
        with warnings.catch_warnings():
            exec(compile(text, "page", "exec"), names)


def test_every_link_and_every_file_that_is_named_exists():
    """Of the pages, and the files that docstrings and comments name."""
    for page in PAGES:
        for target, anchor in re.findall(r"\]\(([^)#:]+)(?:#([^)]+))?\)", page.read_text()):
            assert (page.parent / target).exists(), (page.name, target)
            assert not anchor or anchor in _anchors(page.parent / target), (page.name, anchor)
    named = re.compile(
        r"\b(?:asperity|surfaces|benchmarks|examples|docs|tests)/[\w/]+\.(?:py|md)\b"
    )
    sources = [
        file
        for top in ("asperity", "surfaces", "benchmarks", "examples", "tests")
        for file in ROOT.glob(f"{top}/**/*.py")
    ]
    for file in (*PAGES, *sources):
        for name in named.findall(file.read_text()):
            assert (ROOT / name).is_file(), (file.name, name)


def _anchors(page: Path) -> set[str]:
    """Names that a link may give to the headings of a page."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading).lower().replace(" ", "-") for heading in headings}


def test_tables_on_the_pages_are_those_of_the_files():
    script = run_path(str(ROOT / "benchmarks" / "tables.py"))
    texts = {page: page.read_text() for page in script["pages"]()}
    shown = [name for text in texts.values() for _, name, _ in script["MARKED"].findall(text)]
    assert set(shown) == {path.stem for path in script["DATA"].glob("*.csv")}
    for page, text in texts.items():
        assert script["filled"](text) == text, f"{page.name}: run python benchmarks/tables.py"


def test_the_places_of_results_on_the_page_of_formats_exist(files):
    h5py = pytest.importorskip("h5py")
    page = (ROOT / "docs" / "formats.md").read_text()
    (named,) = re.findall(r"^\| `curves/NAME/([\w/]+)`", page, re.MULTILINE)
    with h5py.File(files / "results.h5") as file:
        assert all(named in curve for curve in file["curves"].values())


def test_the_pages_for_users_are_short():
    words = [w for page in FOR_USERS for w in page.read_text().split() if re.search(r"\w", w)]
    assert len(words) <= 7000


def test_histories_and_seeds_are_left_to_the_pages_for_developers():
    for page in FOR_USERS:
        assert not re.search(r"seeds? \d|\d -> |before -> now", page.read_text()), page.name


def test_commands_on_the_pages_are_understood():
    found = [words for page in PAGES for words in _commands(page.read_text())]
    assert len(found) >= 12
    for words in found:
        assert build_parser(words[0]).parse_args(words).command == words[0]


def _commands(text: str) -> list[list[str]]:
    """Arguments of the complete commands in a text: those that name a file or a shape, whole."""
    found = (shlex.split(line)[1:] for line in re.findall(HEADER, text.replace("\n--", " --")))
    complete = re.compile(r"\.h5|FILE|--shape|^warmup$")
    return [words for words in found if "..." not in words and complete.search(" ".join(words))]


NOT_RUN = {
    "demo": "tests/cli/test_commands.py runs it",
    "warmup": "compiles for half a minute",
    "stress": "runs for an hour; tests/asperity/stress runs single cases",
    "completion": "tests/cli/test_options.py runs it",
}
"""Commands of the pages that are not run here, and why."""


def _on_the_page(page: Path) -> list[str]:
    """Every command with arguments on a page, in order; a name alone is a mention of it."""
    found = (re.sub(r"\s+#.*", "", line).strip() for line in re.findall(HEADER, page.read_text()))
    mention = re.compile(r"asperity (?:surface )?\w+$")
    return [command for command in found if not mention.match(command)]


@pytest.mark.parametrize("page", FOR_USERS, ids=lambda page: page.stem)
def test_commands_on_the_pages_run(page: Path, here, folder: Path, capsys):
    """One after the other in one folder, as a reader would: none stands in the way of another."""
    (folder / "results.h5").unlink()
    for command in _on_the_page(page):
        words = shlex.split(command.split(">")[0].split("|")[0].replace("FILE", "scan.h5"))[1:]
        given = [name for word in words for name in sorted(glob(word)) or [word]]
        if words[0] not in NOT_RUN:
            assert main(given) == 0, (command, capsys.readouterr().err)


MEASURED = re.findall(
    r"^    asperity (surface peaks .*)$",
    (ROOT / "docs" / "development" / "peaks.md").read_text(),
    re.MULTILINE,
)


@pytest.mark.parametrize("command", MEASURED)
def test_measured_maps_go_from_file_to_peaks(command: str, measured: Path, capsys):
    words = command.split()
    words[2] = str(measured / words[2])
    assert main(words) == 0
    count = re.search(r"(\d+) peaks, (\d+) resolved", capsys.readouterr().out)
    assert count is not None and int(count[1]) >= 5
    assert int(count[2]) > 0.5 * int(count[1])


def test_every_measured_map_has_its_command(measured: Path):
    assert {command.split()[2] for command in MEASURED} == {p.name for p in measured.glob("*.h5")}
