"""Compilation ahead: parts in processes of their own, and nothing at all once the code is there."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest
from numba.core import caching

from asperity import compilation
from asperity.errors import AsperityError
from surfaces.numerics.compiled import compiled


@pytest.mark.parametrize("part", ["laws", "contacts", "bem"])
def test_each_part_runs_in_a_process_of_its_own(part):
    arguments = [sys.executable, "-m", "asperity.compilation", part]
    done = subprocess.run(arguments, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_no_process_starts_where_the_code_is_there(monkeypatch):
    compilation._laws()
    for index in compilation._indices():
        index.touch()
    assert not compilation._cold()

    def started(*_, **__):
        raise AssertionError("a process was started")

    monkeypatch.setattr(subprocess, "Popen", started)
    with compilation.compiling("laws", "bem"):
        pass


def test_a_new_date_of_the_source_starts_processes_once(monkeypatch):
    compilation._laws()
    for index in compilation._indices():
        os.utime(index, (0.0, 0.0))
    assert compilation._cold()
    for part in "_summits", "_basins":
        monkeypatch.setattr(compilation, part, lambda: None)
    with compilation.compiling():
        pass
    assert not compilation._cold()


def test_a_part_that_fails_is_left_to_the_run_itself(monkeypatch):
    monkeypatch.setattr(compilation, "_cold", lambda: True)
    with compilation.compiling("no such part"):
        pass


def test_an_interrupted_run_waits_for_no_compiler(monkeypatch):
    """Ctrl-C reaches this process alone where a supervisor sends it."""
    children = []
    start = subprocess.Popen

    def started(*arguments, **options):
        children.append(start(*arguments, **options))
        return children[-1]

    monkeypatch.setattr(compilation, "_cold", lambda: True)
    monkeypatch.setattr(subprocess, "Popen", started)
    with pytest.raises(KeyboardInterrupt), compilation.compiling("laws", "bem"):
        raise KeyboardInterrupt
    assert [child.returncode for child in children] == [-signal.SIGTERM] * 2


def test_a_curve_needs_nothing_that_the_parts_lack():
    """Neither a loop nor another form of one, or it would be compiled after all have ended."""
    code = """
import sys
from numba.core.dispatcher import Dispatcher
from asperity import compilation, contact_curve

def forms():
    modules = [m for n, m in sys.modules.items() if n.startswith(("asperity", "surfaces"))]
    loops = {v for m in modules for v in vars(m).values() if isinstance(v, Dispatcher)}
    return {(str(loop.py_func), form) for loop in loops for form in loop.overloads}

for part in "laws", "contacts", "summits", "basins":
    getattr(compilation, f"_{part}")()
known = forms()
contact_curve(compilation.small_map(), compilation.BODY)
print({name for name, _ in forms() - known})
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_where_compiled_code_can_be_kept_nowhere_is_told(monkeypatch):
    """As to a service that owns neither the installation nor a home."""
    monkeypatch.setattr(caching.CacheImpl, "_locator_classes", [])
    with pytest.raises(AsperityError, match="set NUMBA_CACHE_DIR"):
        compiled()(lambda x: x)
