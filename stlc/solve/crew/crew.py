"""Jobs that need small solves, several at once where there are hands for them.

A job is a generator: it yields what it asks (`Ask`), is sent the answers, and returns what came of
them. Jobs know nothing of each other, so that their results are the same whoever makes the solves
and in whatever order these end; only limits of time tell fast machines from slow ones.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from stlc.backends.base import Solution, Status
from stlc.solve.crew.ask import Ask

T = TypeVar("T")
_GRACE = 2.0  # s that a solve may overrun its limit
Job = Generator[Ask, Solution, T]


class Hands(Protocol):
    """Processes that carry out orders."""

    @property
    def size(self) -> int:
        """How many orders they carry out at once."""

    def give(self, number: int, ask: Ask) -> None:
        """Begin with an order; `number` tells it from the others."""

    def take(self) -> list[tuple[int, Solution | None]]:
        """What has ended within a moment; None for what they could not do."""

    def drop(self) -> None:
        """Leave what is under way."""

    def close(self) -> None:
        """Go home."""


@dataclass(frozen=True, slots=True)
class Crew:
    """Drives jobs, here or by `hands`."""

    hands: Hands | None = None

    @property
    def size(self) -> int:
        """How many solves are made at once."""
        return 1 if self.hands is None else max(self.hands.size, 1)

    def drive(self, jobs: Sequence[Job[T]]) -> list[T]:
        """The results of jobs, in their order. A later job begins when hands are free."""
        if self.hands is None or len(jobs) < 2:
            return [_alone(job) for job in jobs]
        return _Shift(self.hands, jobs).run()


@contextmanager
def crew_of(workers: int, cluster: str | None) -> Iterator[Crew]:
    """Hands on the cluster of that address, or so many processes of this machine, or nobody else.

    SolverError when the cluster can't be reached."""
    if cluster is None and workers < 2:
        yield Crew()
        return
    hands = _hands(workers, cluster)
    try:
        yield Crew(hands)
    finally:
        hands.close()


def _hands(workers: int, cluster: str | None) -> Hands:
    if cluster is None:
        from stlc.solve.crew.processes import Processes

        return Processes(workers)
    from stlc.solve.crew.cluster import Remote

    return Remote(cluster)


def _alone(job: Job[T]) -> T:
    """A job's result, every solve made here."""
    try:
        ask = next(job)
        while True:
            ask = job.send(ask.answer())
    except StopIteration as end:
        return end.value  # type: ignore[no-any-return]  # what the job returns


class _Shift(Generic[T]):
    """Jobs under way: those with an open question, and those that have not begun."""

    def __init__(self, hands: Hands, jobs: Sequence[Job[T]]) -> None:
        self._hands, self._jobs = hands, jobs
        self._results: dict[int, T] = {}
        self._ready: deque[tuple[int, Ask]] = deque()
        self._begun = 0
        self._open: dict[int, Ask] = {}

    def run(self) -> list[T]:
        """All results."""
        while len(self._results) < len(self._jobs):
            self._hand_out()
            for number, solution in self._hands.take() if self._open else ():
                self._settle(number, solution)
            self._leave_if_over()
        return [self._results[k] for k in range(len(self._jobs))]

    def _hand_out(self) -> None:
        """Give orders to free hands: jobs that have begun come first."""
        while len(self._open) < self._hands.size and (self._ready or self._may_begin()):
            if not self._ready:
                self._begun += 1
                self._go_on(self._begun - 1, None)
                continue
            number, ask = self._ready.popleft()
            self._open[number] = ask
            self._hands.give(number, ask)

    def _may_begin(self) -> bool:
        return self._begun < len(self._jobs)

    def _settle(self, number: int, solution: Solution | None) -> None:
        """Take an answer; what the hands could not do is done here."""
        ask = self._open.pop(number)
        self._go_on(number, ask.answer() if solution is None else solution)

    def _go_on(self, number: int, solution: Solution | None) -> None:
        job = self._jobs[number]
        try:
            ask = next(job) if solution is None else job.send(solution)
        except StopIteration as end:
            self._results[number] = end.value
        else:
            self._ready.append((number, ask))

    def _leave_if_over(self) -> None:
        """Whoever is asked to stop waits for nobody."""
        if self._open and all(_asked_to_stop(ask) for ask in self._open.values()):
            self._hands.drop()
            for number in list(self._open):
                self._settle(number, Solution(Status.NO_SOLUTION))


def _asked_to_stop(ask: Ask) -> bool:
    """Whether its moment is long over, or somebody asked to stop before it."""
    moment = ask.moment
    return moment.left < -_GRACE or (moment.should_stop is not None and moment.should_stop())
