"""The examples of CONTRIBUTING.md work in the places that it names."""

from __future__ import annotations

import re
from dataclasses import field, make_dataclass, replace
from pathlib import Path
from textwrap import dedent
from types import ModuleType

import numpy as np
import pytest
from test_house import MOST_REACHED, reached

import asperity
from asperity.microcontact import laws
from asperity.model import law_factory
from asperity.parameters import DEFAULTS, Corrections
from surfaces import FileFormatError, HeightMap, PowerLawProfile, self_affine

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "CONTRIBUTING.md").read_text()
BODY = asperity.HalfSpace.from_modulus(1.0)


def example(heading: str) -> ModuleType:
    """The module that a section shows."""
    section = PAGE.partition(f"## {heading}\n")[2].partition("\n## ")[0]
    (text,) = re.findall(r"^ *```python\n(.*?)^ *```", section, re.MULTILINE | re.DOTALL)
    module = ModuleType("example")
    exec(compile(dedent(text), "CONTRIBUTING.md", "exec"), vars(module))
    return module


def hills(stretch: float) -> HeightMap:
    """A lattice of hills, longer along y than along x by a factor, on a grid that is not square."""
    y, x = (2.0 * np.pi * np.arange(n) / n for n in (48, 60))
    heights = 0.01 * (stretch**-2 * np.cos(2.0 * y)[:, None] + np.cos(2.0 * x))
    return HeightMap(heights, (1.0 / 48, 1.0 / 60), periodic=True)


def test_a_law_of_the_page_gives_a_curve(monkeypatch):
    module = example("Add a contact law")
    monkeypatch.setitem(laws.TABULATORS, "sphere", module.tabulate)
    for stretch, equal in ((1.0, True), (2.0, False)):
        hm = hills(stretch)
        given = {"separations": [0.6 * float(hm.heights.max() - hm.heights.mean())]}
        sphere, hertz = (
            float(asperity.contact_curve(hm, BODY, law=law, **given).load[0])
            for law in ("sphere", "hertz")
        )
        assert sphere > 0.0
        assert (abs(sphere / hertz - 1.0) < 1e-3) == equal
    with pytest.raises(asperity.InputError, match="'sphere'"):
        asperity.indent(PowerLawProfile(2.0, 1.0), BODY, 0.01, law="sphere")


def test_a_correction_of_the_page_changes_the_laws_that_it_is_for(monkeypatch):
    module = example("Add a correction")
    monkeypatch.setitem(law_factory.CORRECTIONS, "cut_basins", module.correct)
    switches = make_dataclass(
        "Switches", [("cut_basins", bool, field(default=True))], bases=(Corrections,), frozen=True
    )
    hm = self_affine((96, 120), (96.0, 120.0), hurst=0.8, rms_slope=0.1, cutoff=6.0, seed=1)
    stated = []
    for on in (False, True):
        parameters = replace(DEFAULTS, corrections=switches(cut_basins=on))
        given = {"separations": [0.5 * hm.rms_height], "boundary": "free"}
        plan = asperity.make_plan(hm, BODY, **given, parameters=parameters)
        solved = asperity.solve_contacts(hm, BODY, plan, separations=given["separations"])
        stated.append(solved.microcontacts(0)["estimate"])
    changed = stated[1] > stated[0]
    assert changed.any() and not changed.all()
    np.testing.assert_allclose(stated[1][changed], 0.1)


def test_a_law_or_a_correction_more_is_not_one_module_too_many():
    """Or a fourth file would have to change."""
    assert len(reached("asperity.curve")) + 1 <= MOST_REACHED


def test_a_format_of_the_page_is_read_and_its_faults_are_told(tmp_path):
    read = example("Add a file format").read_surfer
    heights, path = np.random.default_rng(1).normal(size=(4, 6)), tmp_path / "a.grd"
    text = "DSAA 6 4 0 10 0 9 -3 3 " + " ".join(map(str, heights.ravel()))
    path.write_text(text)
    hm = read(path, None, "um", None)
    np.testing.assert_allclose(hm.heights, 1e-6 * heights)
    np.testing.assert_allclose(hm.spacing, (3e-6, 2e-6))
    with pytest.raises(asperity.InputError, match="states no unit"):
        read(path, None, None, None)
    for cut in range(5, len(text) - 20, 7):
        path.write_text(text[:cut])
        with pytest.raises(FileFormatError, match="damaged Surfer grid"):
            read(path, None, "um", None)


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("TABULATORS", "asperity/microcontact/laws.py"),
        ("SOLVERS", "asperity/microcontact/single/indent.py"),
        ("Corrections", "asperity/parameters/corrections.py"),
        ("Parameters", "asperity/parameters/__init__.py"),
        ("CORRECTIONS", "asperity/model/law_factory.py"),
        ("_reader", "surfaces/files/formats.py"),
        ("MAKERS", "tests/surfaces/test_exchange_formats.py"),
    ],
)
def test_the_page_names_the_files_to_change_and_what_stands_there(name, file):
    places = re.findall(rf"`{name}`\s+of\s+`([\w/.]+)`|`{name}`\s+in\s+`([\w/.]+)`", PAGE)
    assert places and all(file.endswith(one or other) for one, other in places)
    text = (ROOT / file).read_text()
    assert re.search(rf"^(?:class |def )?{name}\b[:( =]", text, re.MULTILINE)
