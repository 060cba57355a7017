"""Models made within a limit: compiling looks at no clock of its own between its stages."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from typing import TypeVar

from stlc.backends.base import SolveOptions
from stlc.errors import InterruptedSolveError, NoPlanError
from stlc.solve.deadline import Deadline
from stlc.solve.supervise import Supervisor

T = TypeVar("T")
Stop = Callable[[], bool]


def by_deadline(make: Callable[[Stop], T], deadline: Deadline, grace: float | None = None) -> T:
    """What `make(should_stop)` returns or raises, if it is there by the deadline.

    `grace` [s] is what it may overrun before it is left behind in its thread; None waits until it
    looks at `should_stop`. Raises NoPlanError when the deadline comes first, InterruptedSolveError
    when somebody asked to stop.
    """
    if math.isinf(deadline.end) and deadline.should_stop is None:
        return make(lambda: False)
    supervisor = Supervisor(
        lambda asked: make(_either(deadline, asked)), deadline.bind(SolveOptions()), grace
    )
    found: T | None = None
    with suppress(InterruptedSolveError):  # `make` has looked, and ended itself
        found = supervisor.run()
    if found is not None:
        return found
    if supervisor.stopped or not deadline.passed():
        raise InterruptedSolveError("interrupted before the model was made")
    raise NoPlanError("the model was not made within the time limit")


def _either(deadline: Deadline, asked: SolveOptions) -> Stop:
    """Whether the time is over or the one who waits has left."""
    halted = asked.should_stop
    return lambda: deadline.passed() or (halted is not None and halted())
