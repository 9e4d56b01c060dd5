"""Compilation ahead: parts in processes of their own, and nothing at all once the code is there."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

import asperity
from asperity import compilation

BODY = asperity.HalfSpace.from_modulus(1.0)


@pytest.mark.parametrize("part", ["laws", "bem"])
def test_each_part_runs_in_a_process_of_its_own(part):
    arguments = [sys.executable, "-m", "asperity.compilation", part, "0.3", "periodic"]
    done = subprocess.run(arguments, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_no_process_starts_where_the_code_is_there(monkeypatch):
    compilation._laws(BODY, "periodic")
    assert not compilation._cold()

    def started(*_, **__):
        raise AssertionError("a process was started")

    monkeypatch.setattr(subprocess, "Popen", started)
    compilation.compile_ahead(("laws", "bem"), BODY, "periodic")


def test_a_new_date_of_the_source_starts_processes_once(monkeypatch):
    compilation._laws(BODY, "periodic")
    for index in compilation._indices():
        os.utime(index, (0.0, 0.0))
    assert compilation._cold()
    monkeypatch.setattr(compilation, "_sum_of_contacts", lambda *_: None)
    compilation.compile_ahead((), BODY, "periodic")
    assert not compilation._cold()


def test_a_part_that_fails_is_left_to_the_run_itself(monkeypatch):
    monkeypatch.setattr(compilation, "_cold", lambda: True)
    compilation.compile_ahead(("no such part",), BODY, "periodic")


def test_an_interrupted_run_waits_for_no_compiler(monkeypatch):
    """Ctrl-C reaches this process alone where a supervisor sends it."""
    children = []
    start = subprocess.Popen

    def started(*arguments, **options):
        children.append(start(*arguments, **options))
        return children[-1]

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(compilation, "_cold", lambda: True)
    monkeypatch.setattr(compilation, "_sum_of_contacts", interrupted)
    monkeypatch.setattr(subprocess, "Popen", started)
    with pytest.raises(KeyboardInterrupt):
        compilation.compile_ahead(("laws", "bem"), BODY, "periodic")
    assert [child.returncode for child in children] == [-signal.SIGTERM] * 2
