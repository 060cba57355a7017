"""Runs on a dask.distributed cluster: one task a run, each in a process of its own there."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterator, Sequence

from stlc.bench.job import Job
from stlc.bench.record import Record
from stlc.bench.run import run_job
from stlc.solve.racing.cluster import Future, connect, distributed, result_of, stop_event

_POLL = 0.2  # s
_DEATHS = 5  # workers that may die under one run before it counts as failed


def run_on_cluster(
    address: str, jobs: Sequence[Job], should_stop: Callable[[], bool]
) -> Iterator[Record]:
    """Records as runs finish. A run whose worker dies is made again on another.

    Workers need the same sources of this package, and should have one thread each (`dask worker
    --nthreads 1`): threads of one worker run at once and disturb each other's times. SolverError
    when the cluster can't be reached, is lost, or a run kills its workers again and again.
    """
    word = f"stlc-bench-{uuid.uuid4().hex}"
    if not jobs:
        return
    with connect(address) as client:
        futures = {
            client.submit(
                run_remotely, job, word, key=f"{word}-{k}", priority=-k, retries=_DEATHS, pure=False
            ): job
            for k, job in enumerate(jobs)
        }
        try:
            yield from _gather(set(futures), futures, should_stop)
        finally:
            stop_event(word, client).set()


def run_remotely(job: Job, word: str) -> Record | None:
    """On a worker: make the run, unless the event `word` is set."""
    event = stop_event(word, distributed().get_client())
    return run_job(job, event.is_set)


def _gather(
    open_: set[Future], futures: dict[Future, Job], should_stop: Callable[[], bool]
) -> Iterator[Record]:
    """Records as their jobs end; a stop leaves the open ones running, for the caller to cancel."""
    while open_ and not should_stop():
        try:
            done = distributed().wait(open_, timeout=_POLL, return_when="FIRST_COMPLETED").done
        except TimeoutError:
            continue
        for future in done:
            if (record := _result(future, futures[future])) is not None:
                yield record
        open_ = open_ - done


def _result(future: Future, job: Job) -> Record | None:
    result = result_of(future, job.title)
    assert result is None or isinstance(result, Record)
    return result
