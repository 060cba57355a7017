"""One solve under way: from the strategies' claim to a plan, or to the error that fits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from stlc.arrays import Floats
from stlc.backends.base import Backend, Capability, Progress, Solution, SolveOptions, Status
from stlc.errors import (
    InfeasibleError,
    InterruptedSolveError,
    NoPlanError,
    SolverError,
)
from stlc.sense import Sense
from stlc.solve import tuning
from stlc.solve.deadline import Deadline, Stopwatch
from stlc.solve.events import (
    DiagnosticEvent,
    Listener,
    ProgressEvent,
    StatisticsEvent,
    StatusEvent,
)
from stlc.solve.incumbent import Incumbent
from stlc.solve.judge import Judge
from stlc.solve.outcome import Outcome, SolveSettings
from stlc.solve.supervise import Supervisor

if TYPE_CHECKING:
    from stlc.milp.compile import Compiled
    from stlc.mission import Mission
    from stlc.plan import Plan
    from stlc.solve.confirm import RefutedError
    from stlc.verify import Report

_INTERRUPTED = "interrupted before a plan was found"


@dataclass(slots=True)
class Job:
    """One solve under way."""

    mission: Mission
    settings: SolveSettings
    compiled: Compiled
    backend: Backend
    listen: Listener
    deadline: Deadline
    encoding: str
    watch: Stopwatch = field(default_factory=Stopwatch)
    judge: Judge = field(init=False)
    incumbent: Incumbent = field(init=False)
    _stopped: bool = False
    _refused: str | None = None

    def __post_init__(self) -> None:
        self.judge = Judge(self.mission, self.compiled, self.encoding)
        self.incumbent = Incumbent(
            self.judge.judge, self.listen, self.backend.name, self.backend.version(),
            self.settings.save_to, self.watch, self.mission.sense,
        )  # fmt: skip

    def run(self, compile_seconds: float) -> Outcome:
        """Solve and conclude; whoever interrupts gets the best verified plan so far."""
        self.listen(self._statistics())
        try:
            solution = self._solve()
            took = {"compile": compile_seconds, "solve": self.watch.seconds}
            self._tell_stop()
            if solution is not None and not self._is_kept(solution):
                return self._conclude(solution, took)
        except KeyboardInterrupt:
            self._stopped = True
            self._tell_stop()
        took = {"compile": compile_seconds, "solve": self.watch.seconds}
        return self._stand(took)

    def _tell_stop(self) -> None:
        if self._stopped:
            self.listen(StatusEvent("stop", "interrupted"))

    def _statistics(self) -> StatisticsEvent:
        m = self.compiled.model
        return StatisticsEvent(m.columns, m.binaries, m.rows, m.nonzeros, self.encoding)

    def _solve(self) -> Solution | None:
        """Run the strategy; its claims are not yet believed. None when it was left behind."""
        from stlc.solve.strategies import run_strategy

        self.listen(StatusEvent("solve", self.backend.version()))
        if self.settings.save_to and not Capability.INCUMBENTS & self.backend.capabilities:
            text = f"{self.backend.name} hands over no plan before it ends"
            self.listen(DiagnosticEvent("note", f"{text}: none can be saved on the way"))
        name, compiled, backend = self.settings.strategy, self.compiled, self.backend
        cluster = self.settings.cluster
        return self._supervise(
            lambda asked: run_strategy(name, compiled, backend, asked, cluster), self._options()
        )

    def _supervise(
        self, work: Callable[[SolveOptions], Solution], options: SolveOptions
    ) -> Solution | None:
        supervisor = Supervisor(work, options, self.settings.grace)
        try:
            solution = supervisor.run()
        finally:
            self._stopped = supervisor.stopped
        self._report_ignored(solution)
        return solution

    def _report_ignored(self, solution: Solution | None) -> None:
        for name in solution.ignored if solution is not None else ():
            if name not in ("on_progress", "should_stop"):
                text = f"{self.backend.name} can't honour `{name}`; it was left out"
                self.listen(DiagnosticEvent("warning", text))

    def _options(self) -> SolveOptions:
        """The settings in the backends' words; a start plan is completed to a point."""
        s = self.settings
        start = None if s.start is None else self._start(s.start)
        if start is not None:
            self.incumbent.take(start, self.compiled.model.objective(start))
        elif s.start is not None:
            text = "the start plan is no plan for this mission; it was left out"
            self.listen(DiagnosticEvent("warning", text))
        asked = SolveOptions(None, s.gap, s.threads, s.seed, start, extra=dict(s.extra))
        return replace(self.deadline.bind(asked), on_progress=self._on_progress)

    def _start(self, plan: Plan) -> Floats | None:
        """A point of the model with a plan's runs, or else near them; None without any."""
        from stlc.solve.mip_start import complete_start

        start = complete_start(self.compiled, plan)
        if start is not None or not Capability.START & self.backend.capabilities:
            return start
        from stlc.solve.near_start import near_start

        moment = self.deadline.share(tuning.NEAR.start_share, tuning.NEAR.start_seconds)
        start = near_start(self.compiled, plan, moment.left)
        if start is not None:
            self.listen(StatusEvent("start", "the start plan is none; one near it is"))
        return start

    def _on_progress(self, progress: Progress) -> None:
        self.listen(ProgressEvent.of(progress, self.mission.sense, self.watch.seconds))
        self.incumbent.raise_bound(progress.bound)
        if progress.incumbent is not None:
            x = progress.incumbent
            self.incumbent.take(x, self.compiled.model.objective(x))

    def _is_kept(self, solution: Solution) -> bool:
        """Stopped early, with nothing better than what was verified and saved already?"""
        if solution.status is Status.NO_SOLUTION:
            return self._stopped or self.incumbent.plan is not None
        worse = solution.objective is not None and solution.objective >= self.incumbent.objective
        return solution.status is Status.FEASIBLE and worse

    def _stand(self, took: dict[str, float]) -> Outcome:
        """What is in hand when the solver ended early or was left behind."""
        standing = self.incumbent.standing()
        if standing is None:
            if self._stopped:
                raise self._without(InterruptedSolveError, _INTERRUPTED, self.incumbent.bound)
            text = _no_plan(self.settings, self.backend.version())
            raise self._without(NoPlanError, text, self.incumbent.bound)
        plan, report, solution = standing
        took = {**took, "verify": self.incumbent.judged}
        plan = replace(plan, solve=replace(plan.solve, seconds=took))
        return self._hand_over(Outcome(plan, report, self.compiled, solution, took))

    def _conclude(self, solution: Solution, seconds: dict[str, float]) -> Outcome:
        """Turn the solver's claim into a certified plan, or into the error that fits."""
        match solution.status:
            case Status.INFEASIBLE:
                return self._doubt(solution, seconds)
            case Status.NO_SOLUTION:
                text = _no_plan(self.settings, solution.solver_version)
                raise self._without(NoPlanError, text, solution.bound)
            case Status.UNBOUNDED | Status.FAILED:
                text = f"{solution.solver_version} ended with '{solution.status.value}'"
                raise SolverError(f"{text}: {solution.message}" if solution.message else text)
            case Status.OPTIMAL | Status.FEASIBLE:
                return self._finish(solution, seconds)

    def _without(self, kind: type[NoPlanError], text: str, bound: float | None) -> NoPlanError:
        """The error of a solve that has a bound at most, said in the mission's sense."""
        limit = self.mission.sense.own(bound)
        if limit is None:
            return kind(text)
        word = "cost less" if self.mission.sense is Sense.MINIMIZE else "be worth more"
        return kind(f"{text}; no plan can {word} than {limit:.6g}", limit)

    def _finish(self, solution: Solution, seconds: dict[str, float]) -> Outcome:
        """A certified point as outcome: verified, with warnings told and a second opinion if asked
        for."""
        judging = Stopwatch()
        self.listen(StatusEvent("verify", "certifying the point, verifying the plan"))
        solution, plan, report = self._accepted(solution)
        seconds = {**seconds, "verify": judging.seconds}
        for warning in plan.certificate.warnings:
            self.listen(DiagnosticEvent("warning", warning))
        plan = replace(plan, solve=replace(plan.solve, seconds=seconds))
        confirmation = self._confirm(solution) if self.settings.confirm else None
        return self._hand_over(
            Outcome(plan, report, self.compiled, solution, seconds, confirmation)
        )

    def _accepted(self, solution: Solution) -> tuple[Solution, Plan, Report]:
        """The judged plan of a claim. Where certification refuses it, that of a plain solve to the
        least tolerances: with integers a tolerance off, rows can be kept that no integers keep."""
        from stlc.solve.certify import EXACT

        asked = self._options_asked()
        try:
            return solution, *self.judge.accept(solution, asked)
        except SolverError:
            if self.backend.name != "highs" or self.deadline.over():
                raise
            model, extra = self.compiled.model, {**self.settings.extra, **EXACT}
            exact = replace(self.deadline.bind(asked), extra=extra)
            again = self._supervise(lambda o: self.backend.solve(model, o), exact)
            if again is None or again.status not in (Status.OPTIMAL, Status.FEASIBLE):
                raise
            return again, *self.judge.accept(again, asked)

    def _hand_over(self, outcome: Outcome) -> Outcome:
        outcome = replace(outcome, refused=self._refused)
        if self.settings.save_to is not None:
            outcome.plan.write(self.settings.save_to)
        self.listen(StatusEvent("done", outcome.plan.solve.status))
        return outcome

    def _options_asked(self) -> SolveOptions:
        """Limits and gap alone: what a claim is held against."""
        s = self.settings
        return SolveOptions(s.time_limit, s.gap, s.threads, s.seed)

    def _confirm(self, solution: Solution) -> str:
        from stlc.solve.certify import certify
        from stlc.solve.confirm import confirm_optimal, second_opinion

        second = second_opinion(self.backend.name)
        if second is None:
            return "no second solver is installed"
        asked = self._options_asked()
        first = certify(self.compiled.model, solution, options=asked)
        return str(confirm_optimal(self.compiled.model, first, second, asked))

    def _doubt(self, solution: Solution, seconds: dict[str, float]) -> Outcome:
        """Hear a second solver on a claim that there is no plan."""
        from stlc.solve.confirm import contradicted, doubt, opinion

        if self.incumbent.plan is not None:
            self._refused = contradicted(solution)
            return self._stand(seconds)
        if not self.settings.doubted:
            said = solution.solver_version or solution.solver
            raise InfeasibleError(f"no run satisfies the mission ({said} says so)")
        asked = opinion(self._options_asked(), solution.seconds)
        return self._go_on(doubt(self.compiled.model, solution, asked), asked, seconds)

    def _go_on(
        self, refuted: RefutedError, asked: SolveOptions, seconds: dict[str, float]
    ) -> Outcome:
        """The second solver has found a plan: it is kept, and bettered if time allows."""
        self._refused = str(refuted)
        second = self.backend = refuted.by
        self.listen(DiagnosticEvent("warning", f"{refuted}; {second.version()} goes on from there"))
        self.incumbent.solver, self.incumbent.version = second.name, second.version()
        self.incumbent.take(refuted.x, self.compiled.model.objective(refuted.x))
        asked = replace(
            asked,
            start=refuted.x,
            on_progress=self._on_progress,
            should_stop=self.deadline.should_stop,
        )
        solution = self._supervise(lambda given: second.solve(self.compiled.model, given), asked)
        if solution is None or solution.x is None or self._is_kept(solution):
            return self._stand(seconds)
        return self._finish(solution, seconds)


def _no_plan(settings: SolveSettings, solver: str) -> str:
    limit = "" if settings.time_limit is None else f" within {settings.time_limit:g} s"
    return f"{solver} found no plan{limit}"
