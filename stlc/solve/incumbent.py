"""The best certified and verified plan while a solver is still at work."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from stlc.backends.base import Floats, Solution, Status, relative_gap
from stlc.errors import OutputError, SolverError
from stlc.files import is_stream
from stlc.sense import Sense
from stlc.solve.deadline import Stopwatch
from stlc.solve.events import DiagnosticEvent, Listener, SolutionEvent

if TYPE_CHECKING:
    from stlc.plan import Plan
    from stlc.verify import Report

Judge = Callable[[Solution], "tuple[Plan, Report]"]


@dataclass(slots=True)
class Incumbent:
    """Judges incumbents as they come and saves the best at once, so that an end loses nothing.

    `judge` certifies a claim and verifies its plan; `bound` is the best that was reported.
    """

    judge: Judge
    listen: Listener
    solver: str
    version: str
    save_to: Path | None
    watch: Stopwatch  # since the solve began
    sense: Sense = Sense.MINIMIZE  # of events and plans; `objective` and `bound` are minimised
    objective: float = float("inf")
    bound: float | None = None
    plan: Plan | None = None
    report: Report | None = None
    claim: Solution | None = None
    judged: float = 0.0  # s that certifying and verifying the best plan took
    _complained: bool = False

    def raise_bound(self, bound: float | None) -> None:
        """Take note of a bound."""
        if bound is not None and (self.bound is None or bound > self.bound):
            self.bound = bound

    def take(self, x: Floats, objective: float) -> None:
        """Keep a point (n,) that is better, if it can be certified and verified."""
        if objective >= self.objective:
            return
        seconds = self.watch.seconds
        claim = Solution(
            Status.FEASIBLE, x, objective, self._sound(objective), seconds=seconds,
            solver=self.solver, solver_version=self.version,
        )  # fmt: skip
        judging = Stopwatch()
        try:
            plan, report = self.judge(claim)
        except SolverError:
            return  # refused by certification: simply not kept; the final answer is judged aloud
        if not report.ok:
            return
        self.judged = judging.seconds
        self.objective, self.plan, self.report, self.claim = objective, plan, report, claim
        saved = self._save(plan)
        self.listen(
            SolutionEvent(seconds, self.sense.own(objective), str(self.save_to) if saved else None)
        )

    def _sound(self, objective: float) -> float | None:
        return None if self.bound is None else min(self.bound, objective)

    def _save(self, plan: Plan) -> bool:
        """A disk that is full now may not be later: say so once, and let the solver work on.

        A pipe gets the last plan alone.
        """
        if self.save_to is None or is_stream(self.save_to):
            return False
        try:
            plan.write(self.save_to)
        except OutputError as error:
            if not self._complained:
                self.listen(DiagnosticEvent("warning", f"the plan is not saved: {error}"))
            self._complained = True
            return False
        return True

    def standing(self) -> tuple[Plan, Report, Solution] | None:
        """The best plan, its gap by the best bound; None without one."""
        if self.plan is None or self.report is None or self.claim is None:
            return None
        bound = self._sound(self.objective)
        seconds = self.watch.seconds
        claim = replace(self.claim, bound=bound, seconds=seconds)
        gap = relative_gap(self.objective, bound)
        info = replace(self.plan.solve, bound=self.sense.own(bound), gap=gap)
        return replace(self.plan, solve=info), self.report, claim
