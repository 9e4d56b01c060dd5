"""Ctrl-C while code is compiled, arrays are handed on or objects end: what is raised in such calls
is lost, or leaves a lock held."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import FrameType

CALLED_BACK = {
    "_raw_object_cache_notify",
    "_raw_object_cache_getbuffer",
    "_numba_unpickle",
    "__del__",
}
"""Functions that compiled code and Python call from within: an exception does not leave them."""

LOCKING = {"__enter__", "__exit__", "acquire", "release"}
LOCKS = ("llvmlite", "binding", "ffi.py"), ("numba", "core", "compiler_lock.py")
"""Methods of the locks of the compiler, and their modules: an exception there leaves the lock held,
and other threads wait for it for ever."""

KEEPING = {ExitStack.enter_context.__code__, ExitStack.__exit__.__code__}
"""Where the compiler has a lock taken or left: for a moment nobody knows that it is held."""


@contextmanager
def interruptible() -> Iterator[None]:
    """Let Ctrl-C reach this program wherever it falls."""
    ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if not ours or threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.signal(signal.SIGINT, _interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt: here, or in the caller of a frame in which it would do harm."""
    unsafe = None
    while frame is not None:
        code = frame.f_code
        locking = code.co_name in LOCKING and Path(code.co_filename).parts[-3:] in LOCKS
        if locking or code in KEEPING or code.co_name in CALLED_BACK:
            unsafe = frame
        frame = frame.f_back
    if unsafe is None or unsafe.f_back is None:
        raise KeyboardInterrupt
    unsafe.f_back.f_trace = _raise
    sys.settrace(lambda *_: None)


def _raise(frame: FrameType, event: str, argument: object) -> None:
    """Raise KeyboardInterrupt at the next line of a frame, or as it returns; once."""
    sys.settrace(None)
    frame.f_trace = None
    raise KeyboardInterrupt
