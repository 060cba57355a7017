"""From a checked mission to a certified, verified plan.

compile -> backend -> certify against the Model -> decode -> verify against the mission -> Plan.
No answer is shown before both checks; a point that the Model accepts and the verifier refuses is
our own disagreement (exit 70), never a plan.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stlc import backends
from stlc.backends.base import Backend, Floats, Progress, Solution, SolveOptions, Status
from stlc.errors import DisagreementError, InfeasibleError, NoPlanError, SolverError
from stlc.solve.events import (
    DiagnosticEvent,
    Listener,
    ProgressEvent,
    SolutionEvent,
    StatisticsEvent,
    StatusEvent,
    ignore,
)

if TYPE_CHECKING:
    from stlc.milp.compile import Compiled, CompileOptions
    from stlc.mission import Mission
    from stlc.plan import Plan
    from stlc.verify import Report


@dataclass(frozen=True, slots=True)
class SolveSettings:
    """How to solve. Limits in seconds, gap relative; the same words for every backend.

    `strategy` "auto" may bound and search ahead of the solver, "milp" is one plain solve.
    `save_to` is kept up to date with the best verified plan while the solver works.
    """

    backend: str = "highs"
    compile: CompileOptions | None = None
    strategy: str = "auto"
    time_limit: float | None = None
    gap: float = 1e-4
    threads: int | None = None
    seed: int | None = None
    start: Plan | None = None
    confirm: bool = False
    save_to: Path | None = None
    extra: dict[str, object] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Outcome:
    """A certified plan and how it was come by. `confirmation` is a second solver's word."""

    plan: Plan
    report: Report
    compiled: Compiled
    solution: Solution
    seconds: dict[str, float]
    confirmation: str | None = None

    def as_dict(self) -> dict[str, Any]:
        """What `stlc solve --json` prints."""
        info, m = self.plan.solve, self.compiled.model
        return {
            "status": info.status,
            "objective": info.objective,
            "bound": info.bound,
            "gap": info.gap,
            "backend": info.backend,
            "solver_version": info.solver,
            "encoding": info.encoding,
            "columns": m.columns,
            "binaries": m.binaries,
            "rows": m.rows,
            "nonzeros": m.nonzeros,
            "nodes": self.solution.nodes,
            "seconds": self.seconds,
            "verified": self.report.ok,
            "robustness": {r.name: r.robustness for r in self.plan.requirements},
            "ignored": list(self.solution.ignored),
            "confirmation": self.confirmation,
        }


def solve_mission(
    mission: Mission,
    settings: SolveSettings | None = None,
    listen: Listener = ignore,
    should_stop: Callable[[], bool] | None = None,
) -> Outcome:
    """Plan a mission.

    Raises InfeasibleError (confirmed by a second solver), NoPlanError at a limit with nothing in
    hand, SolverError when the solver is missing, fails or its answer is refused, and
    DisagreementError when the verifier refuses what the Model accepts.
    """
    from stlc.milp.compile import compile_mission
    from stlc.milp.encodings import encoding_label

    settings = settings or SolveSettings()
    backend = backends.get(settings.backend)
    began = time.perf_counter()
    listen(StatusEvent("compile", mission.source.name))
    compiled = compile_mission(mission, settings.compile)
    now = time.perf_counter()
    label = encoding_label(settings.compile)
    job = _Job(mission, settings, compiled, backend, listen, should_stop, now, label)
    listen(job.statistics())
    solution = job.solve()
    took = {"compile": now - began, "solve": time.perf_counter() - now}
    return job.conclude(solution, took)


def judge_point(
    mission: Mission,
    compiled: Compiled,
    solution: Solution,
    options: SolveOptions | None = None,
    encoding: str = "auto",
) -> tuple[Plan, Report]:
    """Certify a point against the Model, decode it, verify the plan.

    SolverError when certification refuses the point; the verifier's verdict is in the report.
    """
    from stlc.plan import SolveInfo, make_plan
    from stlc.solve.certify import certify
    from stlc.verify import verify

    certified = certify(compiled.model, solution, options=options)
    if certified.x is None:
        raise SolverError(f"{solution.solver} gave no point")
    run = compiled.decode(certified.x)
    info = SolveInfo(
        certified.status.value, certified.objective, certified.bound, certified.gap,
        solution.solver, solution.solver_version, encoding,
    )  # fmt: skip
    plan = make_plan(mission, run.states, run.inputs, info)
    report = verify(mission, plan, compiled.channels)
    return report.annotate(plan, certified.as_dict()), report


@dataclass(slots=True)
class _Job:
    """One solve under way, with the cost of the best verified plan so far."""

    mission: Mission
    settings: SolveSettings
    compiled: Compiled
    backend: Backend
    listen: Listener
    should_stop: Callable[[], bool] | None
    began: float
    encoding: str
    best: float = float("inf")

    def statistics(self) -> StatisticsEvent:
        """Sizes of the model."""
        m = self.compiled.model
        return StatisticsEvent(m.columns, m.binaries, m.rows, m.nonzeros, self.encoding)

    def solve(self) -> Solution:
        """Run the strategy; its claims are not yet believed."""
        from stlc.solve.strategy import run_strategy

        self.listen(StatusEvent("solve", self.backend.version()))
        solution = run_strategy(self.settings.strategy, self.compiled, self.backend, self.options())
        for name in solution.ignored:
            if name not in ("on_progress", "should_stop"):
                text = f"{solution.solver} can't honour `{name}`; it was left out"
                self.listen(DiagnosticEvent("warning", text))
        return solution

    def options(self) -> SolveOptions:
        """The settings in the backends' words; a start plan is completed to a point."""
        from stlc.solve.start import complete_start

        s = self.settings
        start = None if s.start is None else complete_start(self.compiled, s.start)
        if s.start is not None and start is None:
            text = "the start plan is no plan for this mission; it was left out"
            self.listen(DiagnosticEvent("warning", text))
        return SolveOptions(
            s.time_limit, s.gap, s.threads, s.seed, start, self._on_progress, self.should_stop,
            dict(s.extra),
        )  # fmt: skip

    def _on_progress(self, progress: Progress) -> None:
        seconds = time.perf_counter() - self.began
        where = (progress.objective, progress.bound, progress.gap, progress.nodes)
        self.listen(ProgressEvent(seconds, *where))
        if progress.incumbent is not None:
            self._keep(progress.incumbent, progress.bound, seconds)

    def _keep(self, x: Floats, bound: float | None, seconds: float) -> None:
        """Certify, verify and save an incumbent while the solver goes on."""
        objective = self.compiled.model.objective(x)
        if self.settings.save_to is None or objective >= self.best:
            return
        claim = Solution(
            Status.FEASIBLE, x, objective, bound, seconds=seconds, solver=self.backend.name,
            solver_version=self.backend.version(),
        )  # fmt: skip
        try:
            plan, report = self._judge(claim)
        except SolverError:
            return  # refused by certification: simply not kept; the final answer is judged aloud
        if not report.ok:
            return
        self.best = objective
        plan.write(self.settings.save_to)
        self.listen(SolutionEvent(seconds, objective, str(self.settings.save_to)))

    def _judge(self, solution: Solution, asked: SolveOptions | None = None) -> tuple[Plan, Report]:
        return judge_point(self.mission, self.compiled, solution, asked, self.encoding)

    def conclude(self, solution: Solution, seconds: dict[str, float]) -> Outcome:
        """Turn the solver's claim into a certified plan, or into the error that fits."""
        match solution.status:
            case Status.INFEASIBLE:
                raise self._infeasible(solution)
            case Status.NO_SOLUTION:
                raise NoPlanError(_no_plan(self.settings, solution))
            case Status.UNBOUNDED | Status.FAILED:
                text = f"{solution.solver_version} ended with '{solution.status.value}'"
                raise SolverError(f"{text}: {solution.message}" if solution.message else text)
            case Status.OPTIMAL | Status.FEASIBLE:
                return self._finish(solution, seconds)

    def _finish(self, solution: Solution, seconds: dict[str, float]) -> Outcome:
        began = time.perf_counter()
        self.listen(StatusEvent("verify", "certifying the point, verifying the plan"))
        plan, report = self._judge(solution, self.options_asked())
        seconds = {**seconds, "verify": time.perf_counter() - began}
        if not report.ok:
            raise DisagreementError(
                "the plan satisfies the compiled model but not the mission; this is a bug in "
                f"stlc:\n{report.text()}"
            )
        for warning in plan.certificate.get("warnings", ()):
            self.listen(DiagnosticEvent("warning", warning))
        plan = replace(plan, solve=replace(plan.solve, seconds=seconds))
        confirmation = self._confirm(solution) if self.settings.confirm else None
        if self.settings.save_to is not None:
            plan.write(self.settings.save_to)
        self.listen(StatusEvent("done", plan.solve.status))
        return Outcome(plan, report, self.compiled, solution, seconds, confirmation)

    def options_asked(self) -> SolveOptions:
        """Limits and gap alone: what a claim is held against."""
        s = self.settings
        return SolveOptions(s.time_limit, s.gap, s.threads, s.seed)

    def _confirm(self, solution: Solution) -> str:
        from stlc.solve.certify import certify, confirm_optimal, second_opinion

        second = second_opinion(solution.solver)
        if second is None:
            return "no second solver is installed"
        asked = self.options_asked()
        first = certify(self.compiled.model, solution, options=asked)
        return str(confirm_optimal(self.compiled.model, first, second, asked))

    def _infeasible(self, solution: Solution) -> Exception:
        from stlc.solve.certify import confirm_infeasible

        confirmed = confirm_infeasible(self.compiled.model, solution)
        return InfeasibleError(f"no run satisfies the mission ({confirmed})")


def _no_plan(settings: SolveSettings, solution: Solution) -> str:
    limit = "" if settings.time_limit is None else f" within {settings.time_limit:g} s"
    bound = "" if solution.bound is None else f"; no plan can cost less than {solution.bound:.6g}"
    return f"{solution.solver_version} found no plan{limit}{bound}"
