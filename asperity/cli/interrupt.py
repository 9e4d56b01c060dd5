"""Ctrl-C while code is compiled or objects end: what is raised in such calls is lost."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

CALLED_BACK = {"_raw_object_cache_notify", "_raw_object_cache_getbuffer", "__del__"}
"""Functions that the compiler and Python call from within: an exception does not leave them."""

_later = threading.Timer(0.0, signal.raise_signal)


@contextmanager
def interruptible() -> Iterator[None]:
    """Let Ctrl-C reach this program also while code is compiled."""
    ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if not ours or threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.signal(signal.SIGINT, _interrupt)
    try:
        yield
    finally:
        _later.cancel()
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt; once, a moment later, where it would be lost."""
    global _later
    while frame is not None:
        if frame.f_code.co_name in CALLED_BACK:
            _later.cancel()
            _later = threading.Timer(0.05, signal.raise_signal, [number])
            _later.daemon = True
            _later.start()
            return
        frame = frame.f_back
    raise KeyboardInterrupt
