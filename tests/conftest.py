"""Shared fixtures: where the measured maps lie, and jobs without processes of their own."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

# Before numpy is imported. Each process of tests would have a thread of OpenBLAS for every
# processor; where they wait for each other, dense systems of some hundred rows took thirty times
# as long.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def pytest_sessionstart() -> None:
    """Compile first: code that a process has compiled by itself differs in the last digits from
    that which the others read from the disk, and some tests compare processes to the last bit."""
    from asperity.compilation import CURVE, HARD, compile_ahead

    compile_ahead(*CURVE, *HARD, "bem")


def measured_folder() -> Path:
    """Folder of the measured maps: ASPERITY_MEASURED, or shared/measured beside the checkout."""
    beside = Path(__file__).resolve().parents[2] / "shared" / "measured"
    return Path(os.environ.get("ASPERITY_MEASURED", beside))


@pytest.fixture(scope="session")
def measured() -> Path:
    """Folder of the measured maps; the test is skipped where they are absent."""
    folder = measured_folder()
    if not folder.is_dir():
        pytest.skip(f"no measured maps at {folder.name}; set ASPERITY_MEASURED to their folder")
    return folder


class Here:
    """A pool whose one worker is this process; what it is sent is packed as for another."""

    workers = 1

    def submit(self, call: Callable[..., Any], *args: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(call(*pickle.loads(pickle.dumps(args))))
        return future


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Jobs run in this process: no other is started."""

    @contextmanager
    def opened(on: object, jobs: int) -> Iterator[Here]:
        yield Here()

    monkeypatch.setattr("asperity.distributed.sweep.opened", opened)
