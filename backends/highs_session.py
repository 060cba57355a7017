"""HiGHS while it works: its thread pool, which the whole process shares, and its callbacks."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from stlc.backends.base import Progress
from stlc.backends.quiet import silence
from stlc.backends.support import Worker, finite
from stlc.milp.model import Model


class Scheduler:
    """HiGHS keeps one thread pool a process: it may only be resized while nothing is solved.

    Anybody in the process may have solved with another size since (PuLP, cvxpy, the user's own
    highspy), so that the size of an idle pool is never taken as known.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._active = 0
        self._size = 1

    @contextmanager
    def claim(self, threads: int = 1) -> Iterator[int]:
        """Yield the size of the pool: `threads`, unless a solve under way holds another."""
        with self._lock:
            if self._active == 0:
                _highspy().Highs.resetGlobalScheduler(True)  # takes less than a microsecond
                self._size = threads
            size = self._size
            self._active += 1
        try:
            yield size
        finally:
            with self._lock:
                self._active -= 1


SCHEDULER = Scheduler()


def _highspy() -> Any:
    import highspy

    return highspy


def new_highs() -> Any:
    """A `Highs` that prints nothing, its banner included."""
    with silence():
        h = _highspy().Highs()
        h.setOptionValue("log_to_console", False)
    return h


def listen(h: Any, worker: Worker, model: Model) -> None:
    """Bring interrupts in, progress and incumbents out."""

    def interrupt(event: Any) -> None:
        event.interrupt(worker.stopping())

    def progress(event: Any) -> None:
        worker.report(_progress(event.data_out))

    def incumbent(event: Any) -> None:
        out = event.data_out
        x = np.array(out.mip_solution, dtype=float)
        bound, nodes = finite(out.mip_dual_bound), int(out.mip_node_count)
        objective = finite(out.objective_function_value)
        worker.report(Progress(out.running_time, objective, bound, nodes, x))

    h.cbSimplexInterrupt.subscribe(interrupt)
    h.cbIpmInterrupt.subscribe(interrupt)
    h.cbMipInterrupt.subscribe(interrupt)
    if worker.options.on_progress is not None and model.integrality.any():
        h.cbMipLogging.subscribe(progress)
        h.cbMipImprovingSolution.subscribe(incumbent)


def _progress(out: Any) -> Progress:
    return Progress(
        out.running_time,
        finite(out.mip_primal_bound),
        finite(out.mip_dual_bound),
        int(out.mip_node_count),
    )
