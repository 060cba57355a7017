"""Race several backends (or encodings): the first certified proof wins, the rest are ended.

Each racer is a process of its own (spawned, never forked: HiGHS does not survive a fork), so one
that hangs, crashes or lies costs nothing but its share of the machine.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from queue import Empty, SimpleQueue

from stlc.backends.base import Progress, Solution, SolveOptions, Status
from stlc.errors import SolverError, UsageError
from stlc.milp.compile import Compiled
from stlc.milp.model import Model
from stlc.solve.certify import Certified, certify
from stlc.solve.racing.child import Child
from stlc.solve.racing.messages import Failure, Task

_POLL = 0.05  # s
_GRACE = 10.0  # s that a solver may overrun its own time limit
_PROOFS = (Status.OPTIMAL, Status.INFEASIBLE, Status.UNBOUNDED)


@dataclass(frozen=True, slots=True, eq=False)
class Racer:
    """One entrant: a strategy and a backend for a compiled mission, or a backend for a bare model.

    Callbacks and `should_stop` of its options belong to the race instead.
    """

    name: str  # such as 'highs:auto'
    backend: str
    work: Compiled | Model
    options: SolveOptions = field(default_factory=SolveOptions)
    memory: int | None = None  # bytes
    strategy: str = "auto"  # of a compiled mission

    @property
    def model(self) -> Model:
        """The model that answers are certified against."""
        return self.work if isinstance(self.work, Model) else self.work.model


class Finish(Enum):
    """How a racer's part ended."""

    PROOF = "proof"  # a certified optimum, or a claim that there is none
    POINT = "point"  # a certified point, not proven optimal
    NOTHING = "nothing"  # its limits were reached without a point
    FAILED = "failed"  # missing, crashed, refused by certification, out of memory
    ENDED = "ended"  # terminated because the race was decided


@dataclass(frozen=True, slots=True, eq=False)
class Lap:
    """What one racer achieved."""

    name: str
    finish: Finish
    seconds: float
    certified: Certified | None = None
    message: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Race:
    """`winner` is the first proof, else the best certified point, else None."""

    winner: Lap | None
    laps: tuple[Lap, ...]

    def text(self) -> str:
        """One line for each racer."""
        return "\n".join(
            f"  {lap.name:24} {lap.finish.value:8} {lap.seconds:7.1f} s  {lap.message}".rstrip()
            for lap in self.laps
        )


Report = Callable[[str, Progress], None]


def race(
    racers: Sequence[Racer],
    *,
    on_progress: Report | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> Race:
    """Run all racers at once on this machine. UsageError for none, or two of one name.

    Without a proof, the last point of a racer that was stopped or died counts, if it is certified.
    """
    check_names(racers)
    queue: SimpleQueue[_Message] = SimpleQueue()
    entries = {racer.name: (racer, _start(racer, queue)) for racer in racers}
    laps: dict[str, Lap] = {}
    points: dict[str, Progress] = {}

    def report(name: str, progress: Progress) -> None:
        """Keep a racer's latest point, and hand its progress on."""
        if progress.incumbent is not None:
            points[name] = progress
        if on_progress is not None:
            on_progress(name, progress)

    try:
        while len(laps) < len(entries) and not _decided(laps):
            if should_stop is not None and should_stop():
                break
            _advance(entries, laps, queue, report)
    finally:
        for _, child in entries.values():
            child.end()
    for name, (_, child) in entries.items():
        laps.setdefault(name, Lap(name, Finish.ENDED, child.seconds()))
    if not _decided(laps):
        laps |= {name: _salvaged(entries[name][0], laps[name], p) for name, p in points.items()}
    return Race(best(laps.values()), tuple(laps[racer.name] for racer in racers))


def check_names(racers: Sequence[Racer]) -> None:
    """UsageError unless there is a racer and all names differ."""
    names = [racer.name for racer in racers]
    if not names:
        raise UsageError("a race needs at least one racer")
    if len(set(names)) < len(names):
        raise UsageError(f"two racers have one name: {', '.join(names)}")


def best(laps: Iterable[Lap]) -> Lap | None:
    """The first proof of `laps`, in the order of finishing, else the best certified point."""
    ordered = sorted(laps, key=lambda lap: lap.seconds)
    proofs = [lap for lap in ordered if lap.finish is Finish.PROOF]
    if proofs:
        return proofs[0]
    points = [lap for lap in ordered if lap.finish is Finish.POINT]
    return min(points, key=_objective, default=None)


def _objective(lap: Lap) -> float:
    value = lap.certified.objective if lap.certified is not None else None
    return float("inf") if value is None else value


def _salvaged(racer: Racer, lap: Lap, last: Progress) -> Lap:
    """The last point of a racer that has no answer of its own."""
    if lap.finish in (Finish.PROOF, Finish.POINT) or last.incumbent is None:
        return lap
    value = racer.model.objective(last.incumbent)
    bound = None if last.bound is None else min(last.bound, value)
    claim = Solution(
        Status.FEASIBLE, last.incumbent, value, bound, last.nodes, lap.seconds, racer.backend
    )
    try:
        certified = certify(racer.model, claim)
    except SolverError:
        return lap
    return Lap(lap.name, Finish.POINT, lap.seconds, certified, lap.message or "stopped")


def _decided(laps: dict[str, Lap]) -> bool:
    return any(lap.finish is Finish.PROOF for lap in laps.values())


_Message = tuple[str, object]
_OVERRAN = "it overran its limit"


def _advance(
    entries: dict[str, tuple[Racer, Child]],
    laps: dict[str, Lap],
    queue: SimpleQueue[_Message],
    report: Report,
) -> None:
    """Take one message, or look for racers that are late."""
    try:
        name, message = queue.get(timeout=_POLL)
    except Empty:
        for name, (racer, child) in entries.items():
            if name not in laps and _late(racer, child):
                child.end()
                laps[name] = Lap(
                    name, Finish.NOTHING, child.seconds(), None, "it overran its limit"
                )
        return
    if name in laps:
        return
    _, child = entries[name]
    match message:
        case Progress():
            report(name, message)
        case Certified():
            laps[name] = Lap(name, _finish(message), child.seconds(), message)
        case Failure():
            laps[name] = Lap(name, Finish.FAILED, child.seconds(), None, message.message)
        case _:
            laps[name] = Lap(name, Finish.FAILED, child.seconds(), None, child.why())


def _finish(certified: Certified) -> Finish:
    if certified.status in _PROOFS:
        return Finish.PROOF
    return Finish.NOTHING if certified.x is None else Finish.POINT


def _start(racer: Racer, queue: SimpleQueue[_Message]) -> Child:
    options = replace(racer.options, on_progress=None, should_stop=None)
    task = Task(racer.work, racer.backend, options, racer.memory, racer.strategy)

    def tell(message: object | None) -> None:
        """Put a racer's message into the queue under its name."""
        queue.put((racer.name, message))

    return Child("stlc.solve.racing.racer", f"racer {racer.name}", task, tell, racer.memory)


def _late(racer: Racer, child: Child) -> bool:
    """Has it overrun its time limit by more than the grace?"""
    limit = racer.options.time_limit
    return limit is not None and child.seconds() > limit + _GRACE
