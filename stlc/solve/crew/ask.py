"""One small solve that anybody may make: a model, a backend's name, limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from stlc.backends.base import Backend, Progress, Solution, SolveOptions, Status
from stlc.errors import SolverError
from stlc.milp.model import Model
from stlc.solve.deadline import Deadline


@dataclass(frozen=True, slots=True, eq=False)
class Ask:
    """Solve the model until a moment, or to its first point (`any_point`).

    Of `options` the gap, start, seed and the solver's own are meant. Every such solve has one
    thread, so that its answer depends on nothing else.
    """

    model: Model
    backend: Backend
    options: SolveOptions
    moment: Deadline
    any_point: bool = False

    def order(self) -> Order:
        """The same for another process, its limit counted from now."""
        options = replace(
            self.options, time_limit=self.moment.limit, threads=1, on_progress=None,
            should_stop=None,
        )  # fmt: skip
        return Order(self.model, self.backend.name, options, self.any_point)

    def answer(self) -> Solution:
        """The solve made here."""
        order = self.order()
        return solved(order.model, self.backend, order.options, self.any_point, self.moment.over)


@dataclass(frozen=True, slots=True, eq=False)
class Order:
    """What is sent to whoever makes a solve; it holds no callbacks."""

    model: Model
    backend: str
    options: SolveOptions
    any_point: bool


def carried_out(order: Order, should_stop: Callable[[], bool]) -> Solution:
    """An order as any process carries it out."""
    from stlc import backends

    try:
        backend = backends.get(order.backend)
    except SolverError as error:
        return Solution(Status.FAILED, message=str(error))
    return solved(order.model, backend, order.options, order.any_point, should_stop)


def solved(
    model: Model,
    backend: Backend,
    options: SolveOptions,
    any_point: bool,
    should_stop: Callable[[], bool],
) -> Solution:
    """The backend's answer; FAILED where it raises: one try of several."""
    first = _First(any_point, should_stop)
    report = first.see if any_point else None
    try:
        return backend.solve(model, replace(options, on_progress=report, should_stop=first.stop))
    except SolverError as error:
        return Solution(Status.FAILED, message=str(error))


@dataclass(slots=True)
class _First:
    """Stops at the first point where any will do."""

    any_point: bool
    should_stop: Callable[[], bool]
    seen: bool = field(default=False)

    def see(self, progress: Progress) -> None:
        """Note whether a report brings a point."""
        self.seen = self.seen or progress.incumbent is not None

    def stop(self) -> bool:
        """Whether the solve is to end."""
        return (self.any_point and self.seen) or self.should_stop()
