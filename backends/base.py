"""What a backend is: a thin adapter between our Model and one solver."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum, Flag, auto
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from stlc.milp.model import Model

Floats = NDArray[np.float64]


class Capability(Flag):
    """What a backend can do besides solving a MILP."""

    NONE = 0
    START = auto()  # takes a MIP start
    PROGRESS = auto()  # reports bound and gap while it works
    INCUMBENTS = auto()  # hands over each improving point while it works
    TIME_LIMIT = auto()
    GAP = auto()
    THREADS = auto()
    SEED = auto()
    NODES = auto()  # reports its node count
    CANCEL = auto()  # stops within about a second when `should_stop` says so
    EXTRA = auto()  # takes the solver's own options


class Status(Enum):
    """What the solver claims; nothing here is believed before certification."""

    OPTIMAL = "optimal"  # proven within the gap asked for
    FEASIBLE = "feasible"  # stopped at a limit with a point in hand
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    NO_SOLUTION = "no_solution"  # stopped at a limit with none
    FAILED = "failed"


def relative_gap(objective: float | None, bound: float | None) -> float | None:
    """|objective - bound| / max(|objective|, 1e-10), None where either is unknown."""
    if objective is None or bound is None:
        return None
    return abs(objective - bound) / max(abs(objective), 1e-10)


@dataclass(frozen=True, slots=True)
class Progress:
    """One report from a solver at work. `incumbent` is a point (n,) when a new one was found."""

    seconds: float
    objective: float | None
    bound: float | None
    nodes: int | None
    incumbent: Floats | None = None

    @property
    def gap(self) -> float | None:
        """Relative gap, if objective and bound are known."""
        return relative_gap(self.objective, self.bound)


@dataclass(frozen=True, slots=True)
class SolveOptions:
    """The same words for every backend. Limits in seconds; gap relative."""

    time_limit: float | None = None
    gap: float = 1e-4
    threads: int | None = None  # None: one, so that a plan repeats on every machine
    seed: int | None = None
    start: Floats | None = None  # (n,) MIP start
    on_progress: Callable[[Progress], None] | None = None
    should_stop: Callable[[], bool] | None = None
    extra: dict[str, object] = field(default_factory=dict)  # solver's own options, passed through

    @property
    def workers(self) -> int:
        """Threads as a number: solvers are always told, since their own choices differ."""
        return self.threads or 1


@dataclass(frozen=True, slots=True)
class Solution:
    """What came back. `x` (n,) or None; `objective` and `bound` include the model's offset."""

    status: Status
    x: Floats | None = None
    objective: float | None = None
    bound: float | None = None
    nodes: int | None = None
    seconds: float = 0.0
    solver: str = ""
    solver_version: str = ""
    ignored: tuple[str, ...] = ()  # options this backend could not honour
    message: str = ""

    @property
    def gap(self) -> float | None:
        """Relative gap |objective - bound| / max(|objective|, 1e-10), if both are known."""
        return relative_gap(self.objective, self.bound)


@runtime_checkable
class Backend(Protocol):
    """One solver. `solve` raises SolverError when the solver itself fails."""

    @property
    def name(self) -> str:
        """The word a person selects it by, such as `highs`."""

    @property
    def capabilities(self) -> Capability:
        """What it can do besides solving; every other option is listed in `Solution.ignored`."""

    def available(self) -> str | None:
        """None when it can run here, else one sentence with the command that installs it."""

    def version(self) -> str:
        """Solver and its version, such as 'HiGHS 1.15.1'."""

    def solve(self, model: Model, options: SolveOptions) -> Solution:
        """Minimise the model."""
