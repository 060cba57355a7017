"""What a strategy is: one step of a solve, which answers or hands on what it has learnt.

Strategies run in the order of `stlc.solve.strategies.STRATEGIES`. Each takes the work as it
stands (a compiled mission, the best point known, a proven bound) and returns either a Solution,
which ends the solve, or the work with more known. All that a strategy may do to the model is to
add rows that cut off no plan better than the incumbent, so every point stays a point of the
compiled mission. What is where in the model, it learns from the receipts in `Compiled.layout`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from stlc.arrays import Floats
from stlc.backends.base import Backend, Capability, Progress, Solution, SolveOptions, Status
from stlc.milp.compile import Compiled
from stlc.mission import TermKind
from stlc.solve.alone.run import LoneRun
from stlc.solve.crew.crew import Crew
from stlc.solve.deadline import Deadline, Stopwatch

LIMITED = Capability.TIME_LIMIT | Capability.GAP
"""What a backend must know to be one step of a search."""


@dataclass(frozen=True, slots=True, eq=False)
class Work:
    """A solve under way.

    `options.start` is the best point known (n,), found by `finder` ("" for one that was given);
    `bound` is proven for all plans; `lone` are the agents of a team alone; `crew` makes the small
    solves of searches.
    """

    compiled: Compiled
    backend: Backend
    options: SolveOptions
    deadline: Deadline
    bound: float = -math.inf
    nodes: int = 0
    finder: str = ""
    lone: tuple[LoneRun, ...] = ()
    crew: Crew = field(default_factory=Crew)
    watch: Stopwatch = field(default_factory=Stopwatch)

    @staticmethod
    def of(
        compiled: Compiled, backend: Backend, options: SolveOptions, crew: Crew | None = None
    ) -> Work:
        """Work that begins now."""
        return Work(compiled, backend, options, Deadline.of(options), crew=crew or Crew())

    @property
    def x(self) -> Floats | None:
        """The incumbent (n,)."""
        return self.options.start

    @property
    def value(self) -> float:
        """Objective of the incumbent, infinite without one."""
        return math.inf if self.x is None else self.compiled.model.objective(self.x)

    @property
    def kinds(self) -> set[TermKind]:
        """What the objective is made of."""
        return {term.kind for term in self.compiled.mission.objective if term.weight != 0}

    @property
    def seconds(self) -> float:
        """Since it began."""
        return self.watch.seconds

    def can(self, wanted: Capability) -> bool:
        """Whether the backend has all these capabilities."""
        return self.backend.capabilities & wanted == wanted

    def asked(self) -> SolveOptions:
        """Options of a solve by the backend that may take all the time that is left."""
        start = self.x if self.can(Capability.START) else None
        return replace(self.deadline.bind(self.options), start=start)

    def with_point(self, x: Floats | None, finder: str) -> Work:
        """With a point of the model (n,), if it is better than the incumbent; it is reported."""
        if x is None or self.compiled.model.objective(x) >= self.value:
            return self
        found = replace(self, options=replace(self.options, start=x), finder=finder)
        found.report(x)
        return found

    def with_bound(self, bound: float) -> Work:
        """With a bound on all plans, if it is better."""
        return replace(self, bound=bound) if bound > self.bound else self

    def report(self, x: Floats | None = None) -> None:
        """Tell where the solve stands, with a new point if there is one."""
        if self.options.on_progress is not None:
            value = None if self.x is None else self.value
            known = min(self.bound, self.value) if math.isfinite(self.bound) else None
            self.options.on_progress(Progress(self.seconds, value, known, self.nodes, x))

    def proven(self) -> bool:
        """Whether the bound proves the incumbent within the gap (and rounding)."""
        slack = max(self.options.gap * abs(self.value), 1e-7) if self.x is not None else 0.0
        return self.x is not None and self.bound >= self.value - slack

    def answer(self, message: str = "") -> Solution:
        """What is known, in a backend's words."""
        status = Status.FEASIBLE if self.x is not None else Status.NO_SOLUTION
        found = self.x is not None
        version = self.backend.version()
        return Solution(
            Status.OPTIMAL if self.proven() else status,
            self.x,
            self.value if found else None,
            min(self.bound, self.value) if math.isfinite(self.bound) else None,
            self.nodes,
            self.seconds,
            self.backend.name,
            f"{self.finder} over {version}" if self.finder else version,
            message=message,
        )

    def without_plan(self, by: str = "") -> Solution:
        """The answer that there is no plan, and what says so if it is not the backend."""
        return Solution(
            Status.INFEASIBLE, solver=self.backend.name, seconds=self.seconds,
            solver_version=by or self.backend.version(),
        )  # fmt: skip

    def concluded(self, found: Solution) -> Solution:
        """A solver's answer, with the incumbent and the bound that were known before it."""
        if found.status not in (Status.OPTIMAL, Status.FEASIBLE, Status.NO_SOLUTION):
            return found
        bound = self.bound if found.bound is None else max(self.bound, found.bound)
        nodes = self.nodes + found.nodes if found.nodes is not None else self.nodes or None
        if found.x is not None and found.objective is not None and found.objective <= self.value:
            known = min(bound, found.objective) if math.isfinite(bound) else None
            slack = self.options.gap * abs(found.objective) + 1e-9
            proven = known is not None and known >= found.objective - slack
            status = Status.OPTIMAL if proven else found.status
            return replace(found, status=status, bound=known, nodes=nodes, seconds=self.seconds)
        if self.x is None:
            known = bound if math.isfinite(bound) else None
            return replace(found, bound=known, nodes=nodes, seconds=self.seconds)
        kept = replace(self, bound=bound, nodes=nodes or 0).answer(found.message)
        proven = found.status is Status.OPTIMAL or kept.status is Status.OPTIMAL
        return replace(
            kept, status=Status.OPTIMAL if proven else Status.FEASIBLE, ignored=found.ignored
        )


@dataclass(frozen=True, slots=True)
class Strategy:
    """One step. `applies` is cheap and looks at the work alone; `run` answers or hands on.

    `heeds_caps`: it may run where the mission has caps, rows that several agents' costs share.
    """

    name: str
    applies: Callable[[Work], bool]
    run: Callable[[Work], Work | Solution]
    heeds_caps: bool = False
