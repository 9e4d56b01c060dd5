"""Ctrl-C ends a command in one sentence, wherever it falls."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from collections import deque
from contextlib import ExitStack

import pytest
from llvmlite import binding
from llvmlite.binding import ffi
from numba.core.compiler_lock import global_compiler_lock
from refusals import STEEL, good_map

import surfaces
from asperity.cli.interrupt import interruptible
from asperity.cli.main import main


def test_an_interrupted_run_is_one_sentence(folder, capsys, monkeypatch):
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    surfaces.write(good_map(), folder / "scan.h5")
    monkeypatch.setattr("asperity.cli.options.load_surface", interrupt)
    assert main(["curve", "scan.h5", *STEEL]) == 130
    assert capsys.readouterr().err.endswith("interrupted; --resume goes on from its results file\n")


def test_an_interrupt_that_comes_while_code_is_compiled_is_not_lost(tmp_path):
    """The compiler drops what is raised in the functions that it calls; of several one is kept."""
    code = """
import signal, sys, time
import numba
from numba.core.codegen import JITCodeLibrary
from asperity.cli import main, report

noted = JITCodeLibrary._object_compiled_hook.__func__

def interrupted(cls, *compiled):
    noted(cls, *compiled)
    for _ in range(3):
        signal.raise_signal(signal.SIGINT)

def run(args):
    numba.njit(lambda x: x)(1)
    signal.pause()

JITCodeLibrary._object_compiled_hook = classmethod(interrupted)
report.run = run
signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background ignores it
done = main.main(["report", "results.h5"])
time.sleep(0.2)
sys.exit(done)
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60
    )
    assert (done.returncode, done.stderr) == (130, "asperity report: interrupted\n")


def test_an_interrupt_that_comes_while_an_object_ends_is_not_lost():
    """Python prints what `__del__` raises, and goes on."""

    class Ends:
        def __del__(self):
            signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), interruptible():
            ends = Ends()
            del ends
            time.sleep(5.0)
    finally:
        signal.signal(signal.SIGINT, before)


def test_an_interrupt_that_comes_as_compiled_code_returns_is_not_lost():
    """Compiled code makes some results by a function of Python, and ignores what that raises."""
    code = """
import signal, sys, threading
import numpy as np
from asperity.bem import _grid_kernels
from asperity.cli import main, report

zeros, least = np.zeros((1000, 1000)), np.zeros((1000, 20))

def run(args):
    given = zeros, zeros, zeros, least, 1.0
    _grid_kernels.select(*given)
    threading.Timer(0.1, signal.raise_signal, [signal.SIGINT]).start()
    while True:
        _grid_kernels.select(*given)

report.run = run
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.exit(main.main(["report", "results.h5"]))
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60
    )
    assert (done.returncode, done.stderr) == (130, "asperity report: interrupted\n")


@pytest.mark.parametrize("switch", ["taken", "left"])
def test_an_interrupt_leaves_no_lock_of_the_compiler_held(switch):
    """A thread that waits for it would never end, nor the program, which waits for the thread."""

    def interrupted():
        signal.raise_signal(signal.SIGINT)

    calls = {name: interrupted if name == switch else int for name in ("taken", "left")}
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    ffi.register_lock_callback(*calls.values())
    try:
        with pytest.raises(KeyboardInterrupt), interruptible():
            binding.get_default_triple()
            time.sleep(5.0)
    finally:
        ffi.unregister_lock_callback(*calls.values())
        signal.signal(signal.SIGINT, before)
    other = threading.Thread(target=binding.get_default_triple, daemon=True)
    other.start()
    other.join(5.0)
    assert not other.is_alive()


@pytest.mark.parametrize("place", ["acquire", "push", "pop"])
def test_an_interrupt_leaves_no_lock_held_that_the_compiler_keeps_in_a_stack(place, monkeypatch):
    """It is taken before the stack knows of it, and left after the stack has forgotten it."""

    def interrupted(name):
        if name == place:
            signal.raise_signal(signal.SIGINT)

    class Lock:
        held = 0

        def acquire(self):
            self.held += 1
            interrupted("acquire")

        def release(self):
            self.held -= 1

    class Calls(deque):
        def pop(self):
            found = super().pop()
            interrupted("pop")
            return found

    class Stack(ExitStack):
        def _push_cm_exit(self, *given):
            interrupted("push")
            super()._push_cm_exit(*given)

    def compiled():
        with Stack() as scope:
            scope._exit_callbacks = Calls()
            scope.enter_context(global_compiler_lock)
            assert lock.held == 1
        time.sleep(5.0)

    lock = Lock()
    monkeypatch.setattr(global_compiler_lock, "_lock", lock)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), interruptible():
            compiled()
    finally:
        signal.signal(signal.SIGINT, before)
    assert lock.held == 0
