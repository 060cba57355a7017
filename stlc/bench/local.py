"""Runs on this machine, a few at a time."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait

from stlc.bench.job import Job
from stlc.bench.record import Record
from stlc.bench.run import run_job

_POLL = 0.2  # s


def run_local(
    jobs: Sequence[Job], workers: int, should_stop: Callable[[], bool]
) -> Iterator[Record]:
    """Records as runs finish, `workers` at once. More than one at a time disturb each other's
    times. When the caller leaves or `should_stop` says so, all processes are ended."""
    ended = threading.Event()
    with ThreadPoolExecutor(workers) as pool:
        open_: set[Future[Record | None]] = {pool.submit(_unless, ended, job) for job in jobs}
        try:
            while open_ and not should_stop():
                done, open_ = wait(open_, _POLL, FIRST_COMPLETED)
                for future in done:
                    if (record := future.result()) is not None:
                        yield record
        finally:
            ended.set()


def _unless(ended: threading.Event, job: Job) -> Record | None:
    return None if ended.is_set() else run_job(job, ended.is_set)
