"""Race several backends (or encodings): the first certified proof wins, the rest are ended.

Each racer is a process of its own (spawned, never forked: HiGHS does not survive a fork), so one
that hangs, crashes or lies costs nothing but its share of the machine.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from queue import Empty, SimpleQueue
from typing import IO, cast

from stlc.backends.base import Progress, SolveOptions, Status
from stlc.errors import SolverError, UsageError
from stlc.milp.model import Model
from stlc.solve.certify import Certified
from stlc.solve.wire import Failure, Task, read_message, write_message

_POLL = 0.05  # s
_GRACE = 10.0  # s that a solver may overrun its own time limit
_PROOFS = (Status.OPTIMAL, Status.INFEASIBLE, Status.UNBOUNDED)


@dataclass(frozen=True, slots=True, eq=False)
class Racer:
    """One entrant. Callbacks and `should_stop` of its options belong to the race instead."""

    name: str  # such as 'highs:auto'
    backend: str
    model: Model
    options: SolveOptions = field(default_factory=SolveOptions)
    memory: int | None = None  # bytes


class Finish(Enum):
    """How a racer's part ended."""

    PROOF = "proof"  # a certified optimum, or a claim that there is none
    POINT = "point"  # a certified point, not proven optimal
    NOTHING = "nothing"  # its limits were reached without a point
    FAILED = "failed"  # crashed, refused by certification, out of memory or time
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


Report = Callable[[str, Progress], None]


def race(
    racers: Sequence[Racer],
    *,
    on_progress: Report | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> Race:
    """Run all racers at once on this machine. UsageError for none, or two of one name."""
    check_names(racers)
    queue: SimpleQueue[_Message] = SimpleQueue()
    entries = {racer.name: _Entry(racer, queue) for racer in racers}
    laps: dict[str, Lap] = {}
    try:
        while len(laps) < len(entries) and not _decided(laps):
            if should_stop is not None and should_stop():
                break
            _advance(entries, laps, queue, on_progress)
    finally:
        for entry in entries.values():
            entry.end()
    for name, entry in entries.items():
        laps.setdefault(name, Lap(name, Finish.ENDED, entry.seconds()))
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


def _decided(laps: dict[str, Lap]) -> bool:
    return any(lap.finish is Finish.PROOF for lap in laps.values())


_Message = tuple[str, object]


def _advance(
    entries: dict[str, _Entry],
    laps: dict[str, Lap],
    queue: SimpleQueue[_Message],
    on_progress: Report | None,
) -> None:
    """Take one message, or look for racers that are late."""
    try:
        name, message = queue.get(timeout=_POLL)
    except Empty:
        for name, entry in entries.items():
            if name not in laps and entry.late():
                entry.end()
                laps[name] = Lap(name, Finish.FAILED, entry.seconds(), None, "it overran its limit")
        return
    if name in laps:
        return
    match message:
        case Progress():
            if on_progress is not None:
                on_progress(name, message)
        case Certified():
            laps[name] = Lap(name, _finish(message), entries[name].seconds(), message)
        case Failure():
            laps[name] = Lap(name, Finish.FAILED, entries[name].seconds(), None, message.message)
        case _:
            laps[name] = Lap(
                name, Finish.FAILED, entries[name].seconds(), None, entries[name].why()
            )


def _finish(certified: Certified) -> Finish:
    if certified.status in _PROOFS:
        return Finish.PROOF
    return Finish.NOTHING if certified.x is None else Finish.POINT


class _Entry:
    """A racer's process, and the thread that reads what it says."""

    def __init__(self, racer: Racer, queue: SimpleQueue[_Message]) -> None:
        self._racer = racer
        self._began = time.monotonic()
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 (closed in `end`)
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "stlc.solve.racer"],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors,
                start_new_session=True,
            )  # fmt: skip
        except OSError as error:
            raise SolverError(f"cannot start racer {racer.name}: {error.strerror}") from error
        self._reader = threading.Thread(target=self._talk, args=(queue,), daemon=True)
        self._reader.start()

    def _talk(self, queue: SimpleQueue[_Message]) -> None:
        racer = self._racer
        options = replace(racer.options, on_progress=None, should_stop=None)
        task = Task(racer.model, racer.backend, options, racer.memory)
        try:
            write_message(cast("IO[bytes]", self._process.stdin), task)
            output = cast("IO[bytes]", self._process.stdout)
            while (message := read_message(output)) is not None:
                queue.put((racer.name, message))
        except (BrokenPipeError, ValueError):  # it died, or was ended while we read
            pass
        queue.put((racer.name, None))

    def seconds(self) -> float:
        """Since its start."""
        return time.monotonic() - self._began

    def late(self) -> bool:
        """Has it overrun its time limit by more than the grace?"""
        limit = self._racer.options.time_limit
        return limit is not None and self.seconds() > limit + _GRACE

    def why(self) -> str:
        """Why the process ended without an answer."""
        code = self._process.wait()
        self._errors.seek(0)
        said = self._errors.read().decode(errors="replace").strip().splitlines()
        cause = f"signal {-code}" if code < 0 else f"status {code}"
        memory = self._racer.memory
        hint = "" if memory is None else f" (its memory was limited to {memory / 2**20:.0f} MB)"
        return f"its process ended with {cause}{hint}" + (f": {said[-1]}" if said else "")

    def end(self) -> None:
        """End the process and its children, if it still runs."""
        if self._process.poll() is None:
            _signal(self._process, signal.SIGTERM)
            try:
                self._process.wait(1.0)
            except subprocess.TimeoutExpired:
                _signal(self._process, signal.SIGKILL)
                self._process.wait()
        self._reader.join(5.0)
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                _close(stream)
        self._errors.close()


def _signal(process: subprocess.Popen[bytes], number: signal.Signals) -> None:
    if hasattr(os, "killpg"):
        os.killpg(process.pid, number)
    else:
        process.terminate()


def _close(stream: IO[bytes]) -> None:
    try:
        stream.close()
    except BrokenPipeError:
        return  # it never read the rest of its task
