"""A race on a dask.distributed cluster: one task a racer, each in a process of its own there.

dask's `cancel` does not stop a running solve, so the tasks watch a shared event instead.
"""

from __future__ import annotations

import pickle
import uuid
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any, Protocol

from stlc.backends.base import Progress
from stlc.errors import SolverError
from stlc.solve.deadline import Deadline
from stlc.solve.racing.race import Finish, Lap, Race, Racer, Report, best, check_names, race

_POLL = 0.2  # s
_TIMEOUT = 10.0  # s to reach the scheduler
_LAST_WORD = 5.0  # s for racers that were told to stop to send their last points


class Future(Protocol):
    """A task of dask's, as far as its result is concerned."""

    status: str

    def result(self) -> object:
        """What it made."""

    def exception(self) -> BaseException | None:
        """What it raised."""


def result_of(future: Future, what: str) -> object:
    """What a task made that has ended. SolverError, which says `what`, where it made nothing."""
    if future.status == "finished":
        return future.result()
    cause = future.exception() if future.status == "error" else future.status
    raise SolverError(f"the cluster gave up on {what}: {cause}")


def race_on_cluster(
    address: str,
    racers: Sequence[Racer],
    *,
    on_progress: Report | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> Race:
    """Race on the workers of the scheduler at `address` (such as tcp://host:8786).

    Each worker needs the same version of this package. SolverError when the cluster can't be
    reached or `distributed` is not installed.
    """
    check_names(racers)
    with connect(address) as client:
        word = f"stlc-race-{uuid.uuid4().hex}"
        futures = {
            client.submit(run_remotely, racer, word, pure=False, retries=0): racer.name
            for racer in racers
        }
        laps: dict[str, Lap] = {}
        reports = _Reports(word, client, on_progress)
        try:
            _gather(futures, laps, reports, should_stop)
        finally:
            stop_event(word, client).set()
        if not _decided(laps):
            _gather(futures, laps, reports, Deadline.after(_LAST_WORD).over)
        reports.close()
        ended = [Lap(r.name, Finish.ENDED, 0.0) for r in racers if r.name not in laps]
        everyone = laps | {lap.name: lap for lap in ended}
        return Race(best(laps.values()), tuple(everyone[r.name] for r in racers))


def run_remotely(racer: Racer, word: str) -> Lap:
    """On a worker: race one racer alone until it is done or the event `word` is set."""
    client = distributed().get_client()
    stop, queue = stop_event(word, client), _queue(word, client)

    def tell(name: str, progress: Progress) -> None:
        """Send progress to the caller's queue."""
        queue.put(pickle.dumps((name, progress)))

    return race([racer], on_progress=tell, should_stop=stop.is_set).laps[0]


def connect(address: str) -> Any:
    """A client of the scheduler at `address`. SolverError when it cannot be had."""
    try:
        return distributed().Client(address, timeout=_TIMEOUT)
    except (OSError, ValueError) as error:
        raise SolverError(f"cannot reach the cluster at {address}: {error}") from error


def distributed() -> Any:
    """The package. SolverError when it is not installed."""
    try:
        return import_module("distributed")
    except ImportError as error:
        raise SolverError("a cluster needs: pip install 'stlc[cluster]'") from error


def stop_event(word: str, client: Any) -> Any:
    """The cluster-wide event of that name; set, it asks the tasks that watch it to stop."""
    return distributed().Event(word, client=client)


def _queue(word: str, client: Any) -> Any:
    return distributed().Queue(word, client=client)


class _Reports:
    """Progress that the racers put into a queue of the cluster."""

    def __init__(self, word: str, client: Any, tell: Report | None) -> None:
        self._queue, self._tell = _queue(word, client), tell

    def deliver(self) -> None:
        """Pass on what waits."""
        for data in self._queue.get(batch=True):
            name, progress = pickle.loads(data)
            if self._tell is not None:
                self._tell(name, progress)

    def close(self) -> None:
        """No more of it."""
        self._queue.close()


def _decided(laps: dict[str, Lap]) -> bool:
    return any(lap.finish is Finish.PROOF for lap in laps.values())


def _gather(
    futures: dict[Any, str],
    laps: dict[str, Lap],
    reports: _Reports,
    should_stop: Callable[[], bool] | None,
) -> None:
    """Put laps in as they finish, until one is a proof, all are in, or somebody says stop."""
    open_ = {future for future, name in futures.items() if name not in laps}
    while open_ and not _decided(laps):
        if should_stop is not None and should_stop():
            return
        reports.deliver()
        try:
            done = distributed().wait(open_, timeout=_POLL, return_when="FIRST_COMPLETED").done
        except TimeoutError:
            continue
        for future in done:
            name = futures[future]
            failed = future.status != "finished"
            text = f"the worker failed: {future.exception()}" if failed else ""
            laps[name] = Lap(name, Finish.FAILED, 0.0, None, text) if failed else future.result()
        open_ -= done
