"""One job: its process is started, listened to, and ended when it overruns its limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from queue import Empty, SimpleQueue

from stlc.backends.base import relative_gap
from stlc.bench.job import Done, Figure, Job, Point, Update
from stlc.bench.record import Record, record_of
from stlc.errors import SolverError
from stlc.solve.racing.child import Child

_POLL = 0.1  # s
_MARK = 60.0  # s of the solver at which the gap is read
_POINTS = 200  # of the trace that are kept
_START, _REST = 30.0, 3.0  # s to start and compile; limits that all other work may take


def run_job(job: Job, should_stop: Callable[[], bool] = lambda: False) -> Record | None:
    """Make one run; None when it was asked to stop.

    The process is ended after 30 s and three time limits (the solver's own limit is one; reading,
    compiling, certifying and the relaxation bound share the rest). SolverError when the process
    runs other code than the job was made for: its figures would be called by the wrong name.
    """
    queue: SimpleQueue[object | None] = SimpleQueue()
    child = Child("stlc.bench.worker", job.title, job, queue.put, job.limits.memory)
    known = _Known(job)
    try:
        while not known.complete:
            if should_stop():
                return None
            if child.seconds() > _START + _REST * job.limits.seconds:
                known.fail("out_of_time", "its process was ended")
                break
            _listen(queue, known, child)
    finally:
        child.end()
    return known.record(child.seconds())


@dataclass(slots=True)
class _Known:
    """What a job's process has told so far."""

    job: Job
    fields: dict[str, Figure] = field(default_factory=dict)
    trace: list[Point] = field(default_factory=list)
    complete: bool = False

    def take(self, message: object | None, why: Callable[[], str]) -> None:
        """Take one message; None is the end of a process that didn't say it was done."""
        match message:
            case Update():
                self.fields |= message.fields
                if self.fields.get("code", self.job.code) != self.job.code:
                    raise SolverError(_OTHER_CODE)
            case Point():
                self.trace.append(message)
            case Done():
                self.complete = True
            case _:
                text = why()
                limited = self.job.limits.memory is not None
                status = "out_of_memory" if limited and "bad_alloc" in text else "failed"
                self.fail(status, text[:300])
                self.complete = True

    def fail(self, status: str, message: str) -> None:
        """It ended early; an answer that was certified by then stays one."""
        self.fields = {"status": status, "message": message, **self.fields}

    def record(self, wall: float) -> Record:
        """The finished run."""
        fields = dict(self.fields)
        if "status" not in fields:
            fields |= {"status": "failed", "message": "it gave no answer"}
        fields.pop("code", None)
        fields["gap_60"] = _gap_at_mark(self.trace, fields)
        points = tuple((p.seconds, p.objective, p.bound, p.nodes) for p in _thinned(self.trace))
        when = datetime.now(UTC).isoformat(timespec="seconds")
        return record_of(self.job, {**fields, "wall_seconds": wall, "finished": when}, points)


_OTHER_CODE = (
    "a worker runs other sources of stlc than this command (were they changed meanwhile, or is "
    "another version installed there?); finished runs are kept, start again to go on"
)


def _listen(queue: SimpleQueue[object | None], known: _Known, child: Child) -> None:
    try:
        known.take(queue.get(timeout=_POLL), child.why)
    except Empty:
        return


def _gap_at_mark(trace: list[Point], fields: dict[str, Figure]) -> float | None:
    """The gap after 60 s of the solver, or at the end of a run that ended before."""
    ended, gap = fields.get("solver_seconds"), fields.get("gap")
    if isinstance(ended, float) and ended <= _MARK and isinstance(gap, float | int):
        return float(gap)
    gaps = [relative_gap(p.objective, p.bound) for p in trace if p.seconds <= _MARK]
    return next((gap for gap in reversed(gaps) if gap is not None), None)


def _thinned(points: list[Point]) -> list[Point]:
    """At most `_POINTS`, evenly chosen, the last among them."""
    if len(points) <= _POINTS:
        return points
    step = (len(points) - 1) / (_POINTS - 1)
    return [points[round(k * step)] for k in range(_POINTS)]
