"""When to end, and how long it has taken: values instead of clocks that are read everywhere."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from stlc.backends.base import SolveOptions

_LEAST = 0.01  # s: solvers take a limit of 0 for none


@dataclass(frozen=True, slots=True)
class Deadline:
    """A moment on the monotonic clock [s], infinite for none, or a wish to stop before it."""

    end: float = math.inf
    should_stop: Callable[[], bool] | None = None

    @staticmethod
    def after(seconds: float | None, should_stop: Callable[[], bool] | None = None) -> Deadline:
        """So many seconds from now, None for no limit."""
        end = math.inf if seconds is None else time.monotonic() + seconds
        return Deadline(end, should_stop)

    @staticmethod
    def of(options: SolveOptions) -> Deadline:
        """The limit and the wish to stop of a solve that begins now."""
        return Deadline.after(options.time_limit, options.should_stop)

    @property
    def left(self) -> float:
        """Seconds that are left, infinite without a limit, negative when it is over."""
        return self.end - time.monotonic()

    @property
    def limit(self) -> float | None:
        """A time limit for a solver that starts now [s]."""
        return None if math.isinf(self.end) else max(self.left, _LEAST)

    def passed(self) -> bool:
        """Whether the moment has come."""
        return self.left <= 0

    def over(self) -> bool:
        """Whether the moment has come or somebody asked to stop."""
        return self.passed() or (self.should_stop is not None and self.should_stop())

    def within(self, seconds: float) -> Deadline:
        """This deadline, or so many seconds from now if that is earlier."""
        return replace(self, end=min(self.end, time.monotonic() + seconds))

    def share(self, part: float, most: float = math.inf) -> Deadline:
        """Within a part (0..1) of what is left, and at most so many seconds."""
        return self.within(min(part * self.left, most))

    def bind(self, options: SolveOptions) -> SolveOptions:
        """The options of a solve that ends by this deadline."""
        return replace(options, time_limit=self.limit, should_stop=self.should_stop)


@dataclass(frozen=True, slots=True)
class Stopwatch:
    """Seconds since it was made."""

    began: float = field(default_factory=lambda: time.monotonic())

    @property
    def seconds(self) -> float:
        """Seconds since it was made."""
        return time.monotonic() - self.began
