"""One name for one option, help that runs, completion of the shell."""

from __future__ import annotations

import argparse
import re
import shlex
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest

import asperity
import surfaces
from asperity.cli.main import COMMANDS, build_parser, main

OWN = {"--shape", "--law", "-o", "--output"} | {
    *("--E", "--nu", "--m", "--modulus", "--hardness", "--E2", "--nu2", "--hardness2")
}
"""A body or points along the axes; one law or several; a file, or the folder of a demo or a sweep;
one material or, in a sweep, several."""

LONG = {"stress", "warmup", "completion"}
"""Commands whose examples are only understood here, or are lines of a shell."""


def leaves(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """All parsers that take options."""
    inner = [a for a in parser._actions if isinstance(a, argparse._SubParsersAction)]
    if not inner:
        yield parser
    for action in inner:
        for choice in action.choices.values():
            yield from leaves(choice)


PARSERS = list(leaves(build_parser(*COMMANDS)))


def test_an_option_means_the_same_everywhere():
    found: dict[str, set[tuple[object, ...]]] = {}
    for parser in PARSERS:
        for action in parser._actions:
            for name in action.option_strings:
                kind = getattr(action.type, "__qualname__", ""), action.nargs, action.metavar
                found.setdefault(name, set()).add((*kind, action.dest))
    differ = {name for name, uses in found.items() if len(uses) > 1}
    assert differ == OWN, {name: found[name] for name in differ ^ OWN}


def test_the_short_name_is_that_of_the_output_and_what_is_written_is_guarded():
    for parser in PARSERS:
        known = parser._option_string_actions
        assert ("-o" in known) == ("--output" in known), parser.prog
        writes = {"--output", "--plot", "--report", "--csv", "--table"} & known.keys()
        assert not writes or "--force" in known, parser.prog
        old = {"--results", "--folder", "--picture", "--html", "--page", "--out"}
        assert not old & known.keys(), parser.prog


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files that the examples name."""
    folder = tmp_path_factory.mktemp("examples")
    hm = surfaces.self_affine(
        (48, 60), (4.8e-4, 6e-4), hurst=0.8, rms_slope=0.1, cutoff=6e-5, seed=1
    )
    for name in ("scan", "scans/a", "scans/b", "raw/c"):
        (folder / name).parent.mkdir(exist_ok=True)
        surfaces.write(hm, folder / f"{name}.h5")
    (folder / "plan.toml").write_text(
        'files = "scans/*.h5"\n[[material]]\nE = ["70GPa", "210GPa"]\n'
    )
    np.savetxt(folder / "heights.csv", 1e6 * hm.heights, delimiter=",")
    turn = 2 * np.pi * np.arange(32) / 32
    with h5py.File(folder / "profile.h5", "w") as file:
        file["r"], file["phi"] = (radii := np.linspace(0, 2e-6, 24)), turn
        file["f"] = 1e5 * radii[:, None] ** 2 * (1 + 0.1 * np.cos(2 * turn))
    material = asperity.HalfSpace(210e9, 0.3)
    asperity.compare(hm, material, pressures=[1e8, 3e8]).to_hdf5(folder / "compared.h5")
    return folder


@pytest.fixture
def folder(files: Path, folder: Path) -> Path:
    """A fresh copy of these files."""
    shutil.copytree(files, folder, dirs_exist_ok=True)
    return folder


@pytest.mark.parametrize("command", [*COMMANDS])
def test_examples_of_the_help_run(command, here, folder, capsys):
    with pytest.raises(SystemExit):
        main([command, "--help"])
    text = re.split(r"^examples?:", capsys.readouterr().out, flags=re.M)[1]
    found = [shlex.split(line, comments=True) for line in re.findall(r"  asperity (.*)", text)]
    assert found
    for words in found:
        if command in LONG:
            words = words[: words.index(">")] if ">" in words else words
            assert build_parser(command).parse_args(words).command == command
            continue
        if "--bem" in words:
            words += ["--grid", "32"]
        if command in ("report", "interface"):
            for name in [word for word in words if word.endswith(".h5")]:
                shutil.copy("compared.h5", name)
        assert main(words) == 0, (words, capsys.readouterr().err)
        for left in {"results.h5", "report.html"} & {p.name for p in folder.iterdir()}:
            (folder / left).unlink()


@pytest.mark.parametrize("shell", ["bash", "zsh"])
def test_completion_is_a_script_of_all_commands_and_options(shell, capsys):
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    for word in (*COMMANDS, "--pressure", "--no-interaction", "prepare", "--resample"):
        assert word in script
    if shutil.which(shell) is not None:
        subprocess.run([shell, "-n"], input=script, text=True, check=True)


def test_bash_completes_an_option(tmp_path, capsys):
    if shutil.which("bash") is None:
        pytest.skip("no bash on this machine")
    main(["completion", "bash"])
    script = capsys.readouterr().out
    script += """
COMP_WORDS=(asperity surface prepare --per); COMP_CWORD=3
_shtab_asperity; echo "${COMPREPLY[@]}"
"""
    done = subprocess.run(
        ["bash"], input=script, capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert done.stdout.split() == ["--periodic"]
