"""Compilation ahead: parts in processes of their own, and nothing at all once the code is there."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from asperity import bem_curve, compilation, contact_curve, solve, warmup
from surfaces.numerics import compiled as _compiled


@pytest.fixture
def nothing_known(monkeypatch, tmp_path):
    """As in a process that has not compiled or loaded anything, with an empty folder."""
    monkeypatch.setattr(compilation, "_compiled", set())
    monkeypatch.setattr(compilation, "cache_folder", lambda: tmp_path)
    return tmp_path


def started_parts(monkeypatch, command):
    """Parts for which processes are started, each of which runs `command` instead."""
    start, parts, children = subprocess.Popen, [], []

    def started(arguments, **options):
        parts.append(arguments[4:])
        children.append(start(command, **options))
        return children[-1]

    monkeypatch.setattr(subprocess, "Popen", started)
    return parts, children


@pytest.mark.parametrize("part", warmup.PARTS)
def test_each_part_runs_in_a_process_of_its_own(part):
    arguments = [sys.executable, "-m", "asperity.warmup", part]
    done = subprocess.run(arguments, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert compilation._on_disk(part)


def test_one_line_says_that_parts_are_compiled_and_only_once(nothing_known, monkeypatch, capsys):
    monkeypatch.setattr(compilation, "available", lambda: 2)
    parts, _ = started_parts(monkeypatch, ["true"])
    compilation.compile_ahead(*compilation.CURVE)
    assert parts == [["plan", "basins", "contacts"], ["summits", "laws"]]
    assert capsys.readouterr().err == "asperity: compiling for this machine, about 30 s, once\n"
    compilation.compile_ahead("laws", "contacts")
    assert (len(parts), capsys.readouterr().err) == (2, "")


@pytest.mark.parametrize("engine", [solve, contact_curve, bem_curve])
def test_compiling_is_not_counted_in_the_run_time(engine, nothing_known, monkeypatch):
    """By a clock that moves a day while loops are compiled, also those of a verification."""
    clock, late = time.perf_counter, []
    monkeypatch.setattr(compilation, "_compile", late.append)
    monkeypatch.setattr(time, "perf_counter", lambda: clock() + 86400 * len(late))
    verify = {"verify": bem_curve} if engine is contact_curve else {}
    curve = engine(warmup.small_map(), warmup.BODY, pressures=[1e-3, 1e-2], **verify)
    assert late and sum(curve.seconds.values()) < 3600


def test_a_part_is_compiled_anew_where_a_source_has_changed(nothing_known, monkeypatch, tmp_path):
    source = tmp_path / "loops.py"
    source.write_text("from .constants import GAIN\n")
    (tmp_path / "constants.py").write_text("GAIN = 1.0\n")
    monkeypatch.setattr(compilation, "kept_sources", lambda: [source])
    with compilation.compiling("laws"):
        pass
    assert json.loads((nothing_known / "laws.json").read_text())
    assert compilation._on_disk("laws")
    (tmp_path / "constants.py").write_text("GAIN = 2.0\n")
    _compiled.stamp.cache_clear()
    _compiled._read.cache_clear()
    assert not compilation._on_disk("laws")


def test_types_that_are_found_once_are_those_of_the_compiler():
    code = """
import numba
from numba.core.registry import cpu_target
from asperity.warmup import types_once

context = cpu_target.typing_context
context.refresh()
plus = context.resolve_value_type(abs)
many = [(numba.float64,), (numba.int64,), (numba.complex128,), [numba.float32]]
before = [plus.get_call_type(context, one, {}) for one in many]
types_once()
for _ in range(2):
    assert before == [plus.get_call_type(context, one, {}) for one in many]
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_part_that_fails_is_left_to_the_run_itself(nothing_known, monkeypatch):
    monkeypatch.setitem(compilation.SECONDS, "no such part", 1.0)
    compilation.compile_ahead("no such part")


def test_an_interrupted_run_waits_for_no_compiler(nothing_known, monkeypatch):
    """Ctrl-C reaches this process alone where a supervisor sends it."""
    wait, interrupts = subprocess.Popen.wait, iter([KeyboardInterrupt])

    def interrupted(child, *given, **options):
        for interrupt in interrupts:
            raise interrupt
        return wait(child, *given, **options)

    monkeypatch.setattr(subprocess.Popen, "wait", interrupted)
    monkeypatch.setattr(compilation, "available", lambda: 2)
    _, children = started_parts(monkeypatch, ["sleep", "60"])
    with pytest.raises(KeyboardInterrupt):
        compilation.compile_ahead("laws", "contacts", "bem")
    assert [child.returncode for child in children] == [-signal.SIGTERM] * 2


def test_a_curve_needs_nothing_that_the_parts_lack():
    """Neither a loop nor another form of one, or it would be compiled after all have ended."""
    code = """
from asperity import HalfSpace, bem_curve, compilation, contact_curve, warmup
from surfaces import self_affine
from surfaces.numerics.compiled import _loops

def forms():
    return {(str(loop.py_func), form) for loop in _loops for form in loop.overloads}

for part in warmup.PARTS:
    warmup.PARTS[part]()
known = forms()
for changes in {}, {"periodic": False}:
    contact_curve(warmup.small_map().replace(**changes), warmup.BODY)
hm = warmup.small_map()
contact_curve(hm, warmup.BODY, interaction=False)
contact_curve(hm, HalfSpace.from_modulus(1.0, hardness=0.01))
contact_curve(hm, warmup.BODY, separations=[2.5 * hm.rms_height, 2.2 * hm.rms_height, 0.0])
waves = {"hurst": 0.8, "rms_slope": 0.1, "cutoff": 0.01, "rolloff": 0.05}
large = self_affine((512, 512), (1.0, 1.0), **waves)
loads = contact_curve(large, warmup.BODY).mean_pressure
bem_curve(large, warmup.BODY, pressures=loads[-3:], boundary="free", accuracy=0.1)
print(forms() - known or "{}")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "{}"


@pytest.mark.parametrize("version", ["numpy.__version__", "numba.__version__", "sys.version"])
def test_another_version_has_a_folder_of_its_own(version, monkeypatch, tmp_path):
    monkeypatch.setattr("numba.config.CACHE_DIR", str(tmp_path))
    folder = _compiled.cache_folder.__wrapped__
    known = folder()
    assert folder() == known and known.parent == tmp_path
    monkeypatch.setattr(version, "0")
    assert folder() != known


def test_a_folder_that_cannot_be_written_gives_way_to_a_temporary_one(tmp_path):
    """As to a service that owns neither the installation nor a home."""
    (tmp_path / "file").touch()
    code = (
        "from surfaces.numerics.compiled import cache_folder;"
        "from surfaces.numerics import splines; import numpy;"
        "splines.coefficients(numpy.ones((9, 9)), True);"
        "print(cache_folder(), len(list(cache_folder().glob('*/*.nbc'))))"
    )
    folder, kept = printed(code, tmp_path / "file").split()
    assert int(kept) > 0 and not Path(folder).exists()
    assert not folder.startswith(str(tmp_path))


def test_changed_constants_of_another_file_are_not_those_of_the_kept_code(tmp_path):
    """Numba by itself looks at the file of the loop alone."""
    (tmp_path / "constants.py").write_text("GAIN = 1.0\n")
    loop = "from surfaces.numerics.compiled import compiled\n\nfrom .constants import GAIN\n\n\n"
    (tmp_path / "loops.py").write_text(f"{loop}@compiled()\ndef gain():\n    return GAIN\n")
    call = f"import sys; sys.path.insert(0, {str(tmp_path.parent)!r});"
    call += f"from {tmp_path.name}.loops import gain; print(gain(), gain.stats.cache_hits)"
    assert printed(call, tmp_path / "kept") == "1.0 Counter()"
    assert printed(call, tmp_path / "kept") == "1.0 Counter({(): 1})"
    (tmp_path / "constants.py").write_text("GAIN = 2.0\n")
    assert printed(call, tmp_path / "kept") == "2.0 Counter()"


def test_kept_code_whose_arguments_are_of_a_class_that_has_moved_is_not_read(tmp_path):
    """As after an update of the package: the kept index names the module of the class."""
    pair = "from typing import NamedTuple\n\n\nclass Pair(NamedTuple):\n    one: float\n"
    loop = "from surfaces.numerics.compiled import compiled\n\nfrom .{} import Pair\n\n\n"
    loop += "@compiled()\ndef first(pair):\n    return pair.one\n"
    call = f"import sys; sys.path.insert(0, {str(tmp_path.parent)!r});"
    call += f"from {tmp_path.name}.loops import Pair, first; print(first(Pair(1.0)))"
    for module in ("pairs", "couples"):
        (tmp_path / "pairs.py").unlink(missing_ok=True)
        (tmp_path / f"{module}.py").write_text(pair)
        (tmp_path / "loops.py").write_text(loop.format(module))
        assert printed(call, tmp_path / "kept") == "1.0"


def printed(code, folder):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment
    )
    return done.stdout.strip()


def test_without_compilation_one_sentence_tells_why_nothing_runs():
    code = "import asperity; asperity.contact_curve"
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stderr.endswith(
        "NUMBA_DISABLE_JIT is set and the loops run compiled only; unset it\n"
    )
