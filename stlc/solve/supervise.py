"""A solve in a thread of its own, so that whoever waits for it can always leave.

Solvers look at their time limit and at a wish to stop when it suits them: HiGHS was seen to take
fourteen seconds, CBC never. The thread that waits stays in Python, takes reports as they come, and
leaves a solver behind that overruns by more than a grace.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from queue import Empty, SimpleQueue
from typing import Generic, TypeVar

from stlc.backends import support
from stlc.backends.base import Progress, SolveOptions
from stlc.backends.quiet import aloud
from stlc.solve.deadline import Deadline

T = TypeVar("T")

_POLL = 0.05  # s
_NAME = "stlc-solve"


@dataclass(frozen=True, slots=True)
class _End(Generic[T]):
    """The work is over: an answer or what it raised."""

    answer: T | None
    error: BaseException | None


@dataclass(slots=True)
class Supervisor(Generic[T]):
    """Runs `work(options)` for as long as it is wanted.

    `grace` [s] is granted after the time limit or a wish to stop; None waits for the solver.
    """

    work: Callable[[SolveOptions], T]
    options: SolveOptions
    grace: float | None = None
    stopped: bool = False  # somebody asked to stop
    _halt: threading.Event = field(default_factory=threading.Event)
    _queue: SimpleQueue[Progress | _End[T]] = field(default_factory=SimpleQueue)

    def run(self) -> T | None:
        """The answer; None when the work was left behind.

        `options.on_progress` is called in this thread; of several reports that wait, those whose
        point is not the newest come without it. What `work` raises is raised here. Where there are
        no threads the work is done at once, and keeps its limits as well as it can.
        """
        if not support.THREADS:
            return self.work(self.options)
        thread = threading.Thread(target=self._solve, name=_NAME, daemon=True)
        thread.start()
        try:
            return self._wait()
        finally:
            self._halt.set()
            if self.grace is None:
                thread.join()

    def _solve(self) -> None:
        asked = replace(self.options, on_progress=self._queue.put, should_stop=self._halt.is_set)
        try:
            self._queue.put(_End(self.work(asked), None))
        except BaseException as error:  # raised again in the thread that waits
            self._queue.put(_End(None, error))

    def _wait(self) -> T | None:
        """Deliver reports until the work answers, raises, or is left behind (None) after its
        grace."""
        deadline = Deadline.after(self.options.time_limit)
        while True:
            over = self._deliver(self._pending())
            if over is not None:
                if over.error is not None:
                    raise over.error
                return over.answer
            if not self.stopped and self._asked():
                self.stopped, deadline = True, deadline.within(0.0)
                self._halt.set()
            if self.grace is not None and deadline.left < -self.grace:
                return None

    def _asked(self) -> bool:
        return self.options.should_stop is not None and self.options.should_stop()

    def _pending(self) -> list[Progress | _End[T]]:
        found: list[Progress | _End[T]] = []
        try:
            found.append(self._queue.get(timeout=_POLL))
            while True:
                found.append(self._queue.get_nowait())
        except Empty:
            return found

    def _deliver(self, messages: list[Progress | _End[T]]) -> _End[T] | None:
        reports = [m for m in messages if isinstance(m, Progress)]
        points = [r for r in reports if r.incumbent is not None]
        if self.options.on_progress is not None:
            for report in reports:
                stale = report.incumbent is not None and report is not points[-1]
                with aloud():
                    self.options.on_progress(replace(report, incumbent=None) if stale else report)
        return next((m for m in messages if isinstance(m, _End)), None)


def left_behind() -> bool:
    """Is a solver still at work that nobody waits for?"""
    return any(t.name == _NAME and t.is_alive() for t in threading.enumerate())
