"""Where jobs run: Dask, or a pool of processes; batches of jobs, workers that are lost."""

from __future__ import annotations

import logging
import math
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import active_children, forkserver, get_context, parent_process
from multiprocessing.process import BaseProcess
from typing import Any, Protocol

from asperity.errors import AsperityError, InputError
from surfaces.errors import as_count
from surfaces.numerics.parallel import available

from .jobs import Job
from .work import JobResult, failure

__all__ = ["Pool", "Workers", "opened", "run_in_batches"]

SECONDS_OF_A_BATCH = 1.0
"""Work that goes to a worker at once: sending it takes some milliseconds."""

LEAST_SECONDS = 1e-3
"""Least time of a job, for the size of a batch."""

IN_FLIGHT = 2
"""Batches sent for each worker: one that is run, and one that waits."""

SECONDS_TO_ANSWER = 2.0
"""Longest wait for a scheduler to tell its workers; those that it told before are taken then."""

SECONDS_BETWEEN_LOOKS, SECONDS_WITHOUT_WORKERS = 10.0, 300.0
"""How often workers are counted while none of them answers; how long there may be none."""

LEAN = {
    "MALLOC_TRIM_THRESHOLD_": str(1 << 30),
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}
"""Environment of workers that are started here. By the defaults of Dask they give freed memory back
at once and sample their own stack every 10 ms, which costs jobs 5 to 8 % of their time."""

IMPORTED = (
    "distributed",
    "asperity.curve",
    "asperity.distributed.work",
    "surfaces.files.hdf5",
    "scipy.interpolate",
)
"""What all workers need: half of the time before their first job. On Linux they are forked from a
process that has imported it, and has no threads."""

INSTALL = "pip install 'asperity[distributed]'"

Work = Callable[[Sequence[Job]], list[JobResult]]


class Pool(Protocol):
    """What runs calls in other processes, `workers` at a time."""

    @property
    def workers(self) -> int: ...

    def submit(self, *call: Any) -> Future[Any]:
        """Run a function with its arguments."""


@dataclass(frozen=True)
class Workers:
    """What workers a sweep asks for.

    So many processes, as many as the threads of their jobs leave processors for if None; or those
    of the Dask scheduler at an address. Each job has so many threads. Other numbers are refused.
    """

    count: int | None = None
    scheduler: str | None = None
    threads: int = 1

    def __post_init__(self) -> None:
        if self.count is not None:
            count = as_count("the number of workers", self.count, 1)
            object.__setattr__(self, "count", count)
        object.__setattr__(self, "threads", as_count("the number of threads", self.threads, 1))


@contextmanager
def opened(on: Workers, jobs: int) -> Iterator[Pool]:
    """Workers on Dask, or in a pool of processes where it is not installed; no more are started
    here than there are jobs. Refused if no scheduler answers, or Dask is needed and not
    installed."""
    count = min(on.count or max(1, available() // on.threads), jobs)
    method, known = _start_method() if on.scheduler is None else "", active_children()
    try:
        import dask
        import distributed
    except (ImportError, OSError, RuntimeError):
        if on.scheduler is not None:
            raise InputError(
                f"jobs run on the scheduler {on.scheduler} by dask.distributed, which is not "
                f"installed; {INSTALL}"
            ) from None
        _tell(f"dask.distributed is not installed: a pool of {count} processes; {INSTALL}")
        with closing(_Processes(count, method)) as pool, _ended_at_once(known):
            yield pool
        return
    with ExitStack() as stack:
        log = logging.getLogger("distributed.client")  # tells a lost scheduler with its traceback
        stack.callback(log.setLevel, log.level)
        log.setLevel(logging.CRITICAL)
        where: Any = on.scheduler
        if where is None:
            lean: dict[str, Any] = {
                "distributed.worker.profile.enabled": False,
                "distributed.worker.multiprocessing-method": method,
                "distributed.nanny.pre-spawn-environ": LEAN,
            }
            with _uninterrupted(inherit=method == "spawn"), dask.config.set(lean):
                where = distributed.LocalCluster(
                    n_workers=count,
                    threads_per_worker=1,
                    dashboard_address="127.0.0.1:0",
                    silence_logs=logging.CRITICAL,  # a heartbeat cut off at the end is an error
                )
                stack.enter_context(where)
        try:
            client = stack.enter_context(distributed.Client(where))
        except (OSError, TypeError, ValueError) as error:
            raise InputError(
                f"no Dask scheduler answers at {where} ({' '.join(str(error).split())}); start "
                "one by `dask scheduler`, and workers by `dask worker ADDRESS --nthreads 1`"
            ) from error
        with _ended_at_once(known):
            yield _Dask(client)


@contextmanager
def _ended_at_once(known: list[BaseProcess]) -> Iterator[None]:
    """After Ctrl-C end the workers here, all child processes but the `known` ones: asked to, they
    would end their jobs before."""
    try:
        yield
    except KeyboardInterrupt:
        for process in set(active_children()).difference(known):
            process.terminate()
        raise


def _start_method() -> str:
    """How workers here begin; where they are forked, what they need is imported meanwhile."""
    if not sys.platform.startswith("linux"):
        return "spawn"
    given = {name: os.environ.get(name) for name in LEAN}
    forkserver.set_forkserver_preload([*IMPORTED])
    os.environ.update(LEAN)
    try:
        with _uninterrupted(inherit=True):
            forkserver.ensure_running()
    finally:
        for name, value in given.items():
            del os.environ[name]
            if value is not None:
                os.environ[name] = value
    return "forkserver"


@contextmanager
def _uninterrupted(*, inherit: bool) -> Iterator[None]:
    """Let Ctrl-C not reach the processes that are started here: this one ends them. Those that
    `inherit` what this one does with it ignore it, and so does this one meanwhile; otherwise it is
    raised here when they have started."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    caught: list[int] = []
    later = signal.SIG_IGN if inherit else lambda number, _: caught.append(number)
    before = signal.signal(signal.SIGINT, later)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if caught:
        signal.raise_signal(signal.SIGINT)


class _Dask:
    """Workers of a Dask scheduler, which runs again what a lost one was at."""

    def __init__(self, client: Any) -> None:
        self._client, self._executor = client, client.get_executor(pure=False)
        self._known, self._seen = 1, time.monotonic()
        _tell(f"dashboard {client.dashboard_link}")

    @property
    def workers(self) -> int:
        """Workers that are there now; they may come and go, but not all stay away."""
        if self._client.status == "running":
            with suppress(OSError):  # it is busy, or lost: the client is about to notice
                there = self._client.nthreads(callback_timeout=SECONDS_TO_ANSWER)
                self._known = max(1, len(there))
                self._seen = time.monotonic() if there else self._seen
        if time.monotonic() - self._seen > SECONDS_WITHOUT_WORKERS:
            raise AsperityError(
                f"the Dask scheduler has had no workers for {SECONDS_WITHOUT_WORKERS:.0f} s; start "
                "some and run the same again, which goes on where this ended"
            )
        if self._client.status != "running":
            raise _lost()
        return self._known

    def submit(self, *call: Any) -> Future[Any]:
        future: Future[Any] = self._executor.submit(*call)
        return future


class _Processes:
    """A pool of processes, made anew where one of them was lost."""

    def __init__(self, count: int, method: str) -> None:
        self.workers, self._method = count, method
        self._executor = self._new()

    def _new(self) -> Executor:
        return ProcessPoolExecutor(
            self.workers, get_context(self._method), initializer=_end_with_parent
        )

    def submit(self, *call: Any) -> Future[Any]:
        try:
            return self._executor.submit(*call)
        except BrokenExecutor:
            self._executor = self._new()
            return self._executor.submit(*call)

    def close(self) -> None:
        self._executor.shutdown(cancel_futures=True)


def _end_with_parent() -> None:
    """Let this process end with the one that started it, and without a traceback at Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)

    def watch() -> None:
        parent = parent_process()
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def run_in_batches(jobs: Sequence[Job], work: Work, pool: Pool) -> Iterator[tuple[Job, JobResult]]:
    """Run jobs in batches, begun in their order, and tell of each as it ends.

    What runs a batch, `work`, goes to the workers. A lost scheduler is an AsperityError.

    Notes
    -----
    Jobs of a batch that did not come back, as its worker was lost or by an error that nobody
    foresaw, are run one by one while no other runs, so that the one to blame is known; it fails.
    """
    waiting, suspects = deque(jobs), deque[Job]()
    flying: dict[Future[list[JobResult]], list[Job]] = {}
    fitting = 1
    while waiting or suspects or flying:
        most = IN_FLIGHT * pool.workers
        while waiting and not suspects and len(flying) < most:
            share = math.ceil(len(waiting) / most)
            batch = [waiting.popleft() for _ in range(min(share, fitting))]
            flying[pool.submit(work, batch)] = batch
        if not flying:
            job = suspects.popleft()
            yield job, _alone(job, work, pool)
            continue
        for future in _done(flying, pool):
            batch = flying.pop(future)
            if _error(future) is not None:
                suspects.extend(batch)
                continue
            found = future.result()
            yield from zip(batch, found, strict=True)
            seconds = sum(result.get("seconds", 0.0) for result in found) / len(found)
            fitting = max(1, int(SECONDS_OF_A_BATCH / max(seconds, LEAST_SECONDS)))


def _alone(job: Job, work: Work, pool: Pool) -> JobResult:
    """Run a job while no other runs; whatever ends its worker is its own fault."""
    (future,) = _done([pool.submit(work, [job])], pool)
    error = _error(future)
    if error is None:
        return future.result()[0]  # type: ignore[no-any-return]
    if isinstance(error, BrokenExecutor) or type(error).__name__ == "KilledWorker":
        return failure(AsperityError("its worker ended each time, perhaps for want of memory"))
    return failure(AsperityError(f"{type(error).__name__}: {error}"))


def _done(flying: Iterable[Future[Any]], pool: Pool) -> set[Future[Any]]:
    """Those of some batches that have ended, at least one."""
    while not (done := wait(flying, SECONDS_BETWEEN_LOOKS, FIRST_COMPLETED).done):
        _ = pool.workers  # refused if there are none any more
    return done


def _error(future: Future[Any]) -> BaseException | None:
    """Why a batch did not come back."""
    try:
        return future.exception()
    except CancelledError:
        raise _lost() from None


def _lost() -> AsperityError:
    return AsperityError(
        "the Dask scheduler was lost; run the same again, which goes on where this ended"
    )


def _tell(text: str) -> None:
    """A line about the run on standard error."""
    from tqdm import tqdm

    tqdm.write(f"asperity: {text}", file=sys.stderr)
