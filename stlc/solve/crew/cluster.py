"""Hands on a dask.distributed cluster: one task an order."""

from __future__ import annotations

import threading
import uuid
from typing import Any

from stlc.backends.base import Solution
from stlc.solve.crew.ask import Ask, Order, carried_out
from stlc.solve.racing.cluster import connect, distributed, stop_event

_POLL = 0.05  # s
_WATCH = 0.5  # s between looks at whether a task is still wanted
_DEATHS = 5  # workers that may die under one order before it is carried out by who asked


class Remote:
    """The workers of the scheduler at an address, which need the same version of this package.

    An order whose worker dies goes to another; one that the cluster gives up on is carried out by
    who asked. SolverError when the cluster can't be reached."""

    def __init__(self, address: str) -> None:
        self._client = connect(address)
        self._word = f"stlc-crew-{uuid.uuid4().hex}"
        self._open: dict[Any, int] = {}

    @property
    def size(self) -> int:
        """Threads of all workers that are there now, one at least."""
        return max(sum(int(threads) for threads in self._client.nthreads().values()), 1)

    def give(self, number: int, ask: Ask) -> None:
        """As a task."""
        future = self._client.submit(
            run_remotely, ask.order(), self._word, pure=False, retries=_DEATHS
        )
        self._open[future] = number

    def take(self) -> list[tuple[int, Solution | None]]:
        """What has ended within a moment; None for an order that the cluster gave up on."""
        try:
            waited = distributed().wait(
                list(self._open), timeout=_POLL, return_when="FIRST_COMPLETED"
            )
        except TimeoutError:
            return []
        return [(self._open.pop(future), _result(future)) for future in waited.done]

    def drop(self) -> None:
        """Ask the tasks to stop; later ones watch another word."""
        stop_event(self._word, self._client).set()
        self._word = f"stlc-crew-{uuid.uuid4().hex}"
        self._open.clear()

    def close(self) -> None:
        """Ask all tasks to stop and leave the cluster."""
        if self._open:
            self.drop()
        self._client.close()


def _result(future: Any) -> Solution | None:
    found = future.result() if future.status == "finished" else None
    return found if isinstance(found, Solution) else None


def run_remotely(order: Order, word: str) -> Solution:
    """On a worker: carry out the order, or stop when the event `word` is set."""
    event = stop_event(word, distributed().get_client())
    over, done = threading.Event(), threading.Event()
    threading.Thread(target=_watch, args=(event, over, done), daemon=True).start()
    try:
        return carried_out(order, over.is_set)
    finally:
        done.set()


def _watch(event: Any, over: threading.Event, done: threading.Event) -> None:
    """Set `over` once the event of the cluster is set, until the task is done."""
    while not done.wait(_WATCH):
        if event.is_set():
            over.set()
            return
