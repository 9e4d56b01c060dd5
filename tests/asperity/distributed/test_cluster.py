"""A scheduler and workers of somebody else, in processes that are killed in the middle."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest

import asperity

from .conftest import LOADS, STEEL, same_but_seconds

JOBS = 40
"""Enough that some are left when the first is finished."""


class Cluster:
    """A scheduler and two workers."""

    def __init__(self) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{port}"
        self.scheduler = self._started("scheduler", "--host", "127.0.0.1", "--port", str(port))
        one = ("--nthreads", "1", "--no-nanny", "--death-timeout", "30")
        self.workers = [self._started("worker", self.address, *one) for _ in range(2)]

    @staticmethod
    def _started(part: str, *options: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.dask_{part}", *options]
        place = {**os.environ, "PYTHONPATH": str(Path(asperity.__file__).parents[1])}
        return subprocess.Popen(
            [*command, "--no-dashboard"],
            env=place,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    def wait(self) -> None:
        """Wait until both workers are there."""
        import distributed

        with distributed.Client(self.address) as client:
            client.wait_for_workers(2, timeout=60)

    def end(self) -> None:
        """Kill what is left."""
        for process in (self.scheduler, *self.workers):
            process.kill()
            process.wait()


@pytest.fixture
def cluster() -> Iterator[Cluster]:
    """A cluster that runs."""
    pytest.importorskip("distributed", reason="dask.distributed is not installed")
    it = Cluster()
    try:
        it.wait()
        yield it
    finally:
        it.end()


def test_a_killed_scheduler_costs_nothing_that_is_finished(cluster, maps, tmp_path, request):
    files, out, killed = maps(JOBS), tmp_path / "out", []

    def kill(row: object) -> None:
        cluster.scheduler.kill()
        cluster.scheduler.wait()  # the client may be asked for workers before it notices
        killed.append(time.monotonic())  # not before: loops may be compiled first

    with pytest.raises(asperity.AsperityError, match=r"^the Dask scheduler was lost; run the same"):
        asperity.sweep(files, STEEL, LOADS, folder=out, scheduler=cluster.address, progress=kill)
    assert time.monotonic() - killed[0] < 45.0
    for worker in cluster.workers:  # may end their job first
        worker.wait(60)
    finished = {file: file.stat().st_mtime_ns for file in (out / "results").glob("m*.h5")}
    told = asperity.Sweep.read(out).table["state"].tolist()
    assert 0 < told.count("done") <= len(finished) < JOBS
    request.getfixturevalue("here")
    resumed = asperity.sweep(files, STEEL, LOADS, folder=out)
    assert {file: file.stat().st_mtime_ns for file in finished} == finished
    assert same_but_seconds(resumed, asperity.sweep(files, STEEL, LOADS, folder=tmp_path / "whole"))


def test_a_killed_worker_costs_nothing_that_is_finished(cluster, maps, tmp_path, request):
    files = maps(JOBS)
    go = partial(asperity.sweep, files, STEEL, LOADS)
    found = go(
        folder=tmp_path / "out",
        scheduler=cluster.address,
        progress=lambda row: cluster.workers[0].kill(),
    )
    assert cluster.workers[0].wait(10) != 0 and found.converged
    request.getfixturevalue("here")
    assert same_but_seconds(found, go(folder=tmp_path / "whole"))
