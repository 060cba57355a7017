"""What the adapters share: the trivial model, ignored options, a cancellable worker thread."""

from __future__ import annotations

import importlib.util
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from queue import Empty, SimpleQueue
from typing import Final

import numpy as np

from stlc.backends.base import (
    Backend,
    Capability,
    Floats,
    Progress,
    Solution,
    SolveOptions,
    Status,
)
from stlc.backends.quiet import aloud
from stlc.errors import SolverError
from stlc.milp.model import Model

_PAUSE = 0.1  # s between two reports without an incumbent
_POLL = 0.05  # s between two looks at `should_stop`


def missing(module: str, install: str) -> str | None:
    """None when `module` can be imported, else one sentence that says how to install it."""
    if importlib.util.find_spec(module) is not None:
        return None
    return f"{module} is not installed; run: pip install {install}"


def require(backend: Backend) -> None:
    """Raise SolverError with the install command when the backend cannot run here."""
    problem = backend.available()
    if problem is not None:
        raise SolverError(f"backend '{backend.name}': {problem}")


def ignored(backend: Backend, options: SolveOptions) -> tuple[str, ...]:
    """Names of the options that were asked for and lie outside the backend's capabilities."""
    can = backend.capabilities
    progress = Capability.PROGRESS | Capability.INCUMBENTS
    asked = (
        ("time_limit", options.time_limit is not None, Capability.TIME_LIMIT),
        ("gap", options.gap != SolveOptions().gap, Capability.GAP),
        ("threads", options.threads is not None, Capability.THREADS),
        ("seed", options.seed is not None, Capability.SEED),
        ("start", options.start is not None, Capability.START),
        ("on_progress", options.on_progress is not None, progress),
        ("should_stop", options.should_stop is not None, Capability.CANCEL),
        ("extra", bool(options.extra), Capability.EXTRA),
    )
    return tuple(name for name, wanted, needs in asked if wanted and not can & needs)


def trivial(backend: Backend, model: Model, options: SolveOptions) -> Solution | None:
    """The answer of a model without rows or without columns (CBC crashes on them), else None."""
    if model.columns and model.rows:
        return None
    lower, upper = model.col_lower, model.col_upper
    if model.integrality.any():
        lower = np.where(model.integrality, np.ceil(lower), lower)
        upper = np.where(model.integrality, np.floor(upper), upper)
    holds = np.all((model.row_lower <= 0) & (model.row_upper >= 0)) and np.all(lower <= upper)
    cheap = np.where(model.c > 0, lower, np.where(model.c < 0, upper, np.clip(0.0, lower, upper)))
    answer = Solution(
        Status.INFEASIBLE,
        solver=backend.name,
        solver_version=backend.version(),
        ignored=ignored(backend, options),
        message="the model has no rows" if model.columns else "the model has no columns",
    )
    if not holds:
        return answer
    if not np.all(np.isfinite(cheap)):
        return replace(answer, status=Status.UNBOUNDED)
    value = model.objective(cheap)
    return replace(answer, status=Status.OPTIMAL, x=cheap, objective=value, bound=value)


def infeasible_or_unbounded(backend: Backend, model: Model, options: SolveOptions) -> Status:
    """Tell the two apart for solvers that cannot: solve again without the objective."""
    if not model.c.any():
        return Status.INFEASIBLE
    quiet = replace(options, on_progress=None)
    free = replace(model, c=np.zeros(model.columns), offset=0.0)
    match backend.solve(free, quiet).status:
        case Status.OPTIMAL | Status.FEASIBLE:
            return Status.UNBOUNDED
        case Status.INFEASIBLE:
            return Status.INFEASIBLE
        case _:
            return Status.FAILED


def finite(value: float | None) -> float | None:
    """`value`, or None where a solver says infinity (or 1e20 and beyond) for 'not known'."""
    if value is None or not np.isfinite(value) or abs(value) >= 1e20:
        return None
    return float(value)


def claimed_bound(status: Status, objective: float | None, options: SolveOptions) -> float | None:
    """The bound that 'optimal within the gap' amounts to, for solvers that report none."""
    if status is not Status.OPTIMAL or objective is None:
        return None
    return objective - options.gap * abs(objective)


def point(values: object, columns: int, solver: str) -> Floats:
    """A solver's point as an array (columns,); SolverError when its length is wrong."""
    x = np.array(values, dtype=float)
    if x.shape != (columns,):
        raise SolverError(f"{solver} returned {x.size} values for {columns} columns")
    return x


THREADS: Final = sys.platform not in ("emscripten", "wasi")
"""Browsers have none: what would run in one runs at once, and is asked where it asks."""


@dataclass(slots=True)
class Worker:
    """Runs a solve in a thread; reports come out in the caller's thread, where Ctrl-C arrives.

    The solver's callbacks call `report` and ask `stopping`. An exception in the caller's thread
    (KeyboardInterrupt, one raised by `on_progress`) stops the solver before it goes on.
    """

    options: SolveOptions
    _events: SimpleQueue[Progress | None] = field(default_factory=SimpleQueue)
    _last: float = float("-inf")
    _stop: threading.Event = field(default_factory=threading.Event)

    def stopping(self) -> bool:
        """Has somebody asked to stop?"""
        if not THREADS:
            self._ask(None)
        return self._stop.is_set()

    def report(self, progress: Progress) -> None:
        """Hand one report to the caller's thread: every incumbent, the rest ten times a second."""
        if self.options.on_progress is None:
            return
        now = time.monotonic()
        if progress.incumbent is None and now - self._last < _PAUSE:
            return
        self._last = now
        if not THREADS:
            return self.options.on_progress(progress)
        self._events.put(progress)

    def run(self, work: Callable[[], None], cancel: Callable[[], None] | None = None) -> None:
        """Run `work` to its end; `cancel` is called once when it has to stop."""
        if not THREADS:
            return work()
        with ThreadPoolExecutor(1) as pool:
            future = pool.submit(work)
            future.add_done_callback(lambda _: self._events.put(None))
            try:
                self._deliver(cancel)
            finally:
                if not future.done():
                    self._halt(cancel)
        future.result()

    def _deliver(self, cancel: Callable[[], None] | None) -> None:
        """Calls back in the caller's thread, as events come, until the solver's has ended."""
        while True:
            try:
                event = self._events.get(timeout=_POLL)
            except Empty:
                self._ask(cancel)
                continue
            if event is None:
                return
            if self.options.on_progress is not None:
                with aloud():
                    self.options.on_progress(event)
            self._ask(cancel)

    def _ask(self, cancel: Callable[[], None] | None) -> None:
        should_stop = self.options.should_stop
        if should_stop is not None and not self.stopping() and should_stop():
            self._halt(cancel)

    def _halt(self, cancel: Callable[[], None] | None) -> None:
        self._stop.set()
        if cancel is not None:
            cancel()
