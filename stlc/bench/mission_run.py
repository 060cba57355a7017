"""What a run of a mission does and measures; the clock starts when its text is read.

The same steps as `stlc solve`: compile, strategy and backend, certification, verification. The
first incumbent that passes both checks is timed; later ones are not checked, so as not to slow the
solver down.
"""

from __future__ import annotations

import json
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from stlc import backends
from stlc.api import loads
from stlc.backends.base import Progress, Solution, SolveOptions, Status
from stlc.bench.job import Figure, Job, Point, Tell, Update
from stlc.bench.machine import cpu_seconds
from stlc.errors import InfeasibleError, MissionError, SolverError, StlcError
from stlc.files import scratch_folder
from stlc.milp.compile import Compiled, compile_mission
from stlc.milp.encodings import compile_options
from stlc.mission import Mission
from stlc.solve.statistics import lp_bound

if TYPE_CHECKING:
    from stlc.milp.model import Model

LP_SECONDS = 20.0  # at most, for the relaxation bound
LP_NONZEROS = 5_000_000  # beyond, HiGHS needs longer to begin than it may take


def run_mission(job: Job, tell: Tell) -> None:
    """Make the run; whatever ends it becomes a status."""
    run = _Run(job, tell)
    try:
        run.make()
    except InfeasibleError as error:
        run.send(status="infeasible", message=_line(error), proof=run.seconds())
    except MissionError as error:
        tell(Update({"status": "failed", "message": _line(error)}))
    except StlcError as error:
        tell(Update({"status": "failed", "message": _line(error)}))


def _line(error: StlcError) -> str:
    return str(error).partition("\n")[0][:300]


@dataclass(slots=True)
class _Run:
    job: Job
    tell: Tell
    began: float = field(default_factory=time.perf_counter)
    first: float | None = None

    def seconds(self) -> float:
        """Since the text was first read."""
        return time.perf_counter() - self.began

    def send(self, **fields: Any) -> None:
        """Tell what is known."""
        self.tell(Update(fields))

    def make(self) -> None:
        """Compiles, solves and judges; the first repetition adds the LP relaxation's bound."""
        mission = self._read()
        compiled = self._compile(mission)
        load_solvers(self.job.config.backend)
        began, cpu = time.perf_counter(), cpu_seconds()
        solution = self._solve(mission, compiled)
        self.send(
            solver_seconds=time.perf_counter() - began, cpu_seconds=cpu_seconds() - cpu,
            nodes=solution.nodes, solver=solution.solver_version,
            bound=mission.sense.own(solution.bound),
        )  # fmt: skip
        self._judge(mission, compiled, solution)
        if self.job.repeat == 0:
            bound = relaxation(compiled.model, self.job.limits.seconds)
            self.send(lp_bound=mission.sense.own(bound))

    def _read(self) -> Mission:
        with scratch_folder() as folder:
            for name, data in self.job.files.items():
                folder.joinpath(name).write_bytes(data)
            main = self.job.main
            text = self.job.files[main].decode()
            mission = loads(text, name=main, folder=folder)
        self.send(read_seconds=self.seconds(), sense=mission.sense.value)
        return mission

    def _compile(self, mission: Mission) -> Compiled:
        """The compiled mission; sends the model's size and the seconds of passes and encoding."""
        config = self.job.config
        began = time.perf_counter()
        compiled = compile_mission(mission, compile_options(config.encoding, config.disabled))
        took = time.perf_counter() - began
        passes = {p.name: round(p.seconds, 6) for p in compiled.stats.passes}
        self.send(
            compile_seconds=took, passes_seconds=sum(passes.values()),
            encode_seconds=took - sum(passes.values()), pass_seconds=json.dumps(passes),
            **sizes(compiled.model),
        )  # fmt: skip
        return compiled

    def _solve(self, mission: Mission, compiled: Compiled) -> Solution:
        """Runs the strategy and tells progress, in the mission's own sense."""
        from stlc.solve.strategies import run_strategy

        def report(progress: Progress) -> None:
            own = mission.sense.own
            objective, bound = own(progress.objective), own(progress.bound)
            self.tell(Point(progress.seconds, objective, bound, progress.nodes))
            if progress.incumbent is not None and self.first is None:
                self._check_first(mission, compiled, progress)

        config = self.job.config
        options = solve_options(self.job, report)
        return run_strategy(config.strategy, compiled, backends.get(config.backend), options)

    def _check_first(self, mission: Mission, compiled: Compiled, progress: Progress) -> None:
        """Notes an incumbent's time as the first plan's, once it is certified and verified."""
        from stlc.solve.judge import Judge

        x = progress.incumbent
        assert x is not None
        value = compiled.model.objective(x)
        claim = Solution(Status.FEASIBLE, x, value, progress.bound, solver=self.job.config.backend)
        try:
            _, report = Judge(mission, compiled).judge(claim)
        except SolverError:
            return  # refused by certification: the next incumbent is tried
        if report.ok:
            self.first = self.seconds()
            self.send(first_plan=self.first)

    def _judge(self, mission: Mission, compiled: Compiled, solution: Solution) -> None:
        """Certify and verify the answer; what was claimed is only then a figure."""
        from stlc.solve.judge import Judge

        if solution.x is None:
            proven = solution.status is Status.INFEASIBLE
            self.send(**no_point(solution), proof=self.seconds() if proven else None)
            return
        began = time.perf_counter()
        try:
            plan, report = Judge(mission, compiled).judge(solution, solve_options(self.job))
        except SolverError as error:
            self.send(status="refused", message=_line(error))
            return
        if not report.ok:
            self.send(status="refused", message="the verifier refuses the plan")
            return
        info = plan.solve
        self.send(
            status=info.status, objective=info.objective, bound=info.bound, gap=info.gap,
            certified=True, verify_seconds=time.perf_counter() - began,
            first_plan=self.seconds() if self.first is None else self.first,
        )  # fmt: skip
        if info.status == Status.OPTIMAL.value:
            self.send(proof=self.seconds())


def load_solvers(backend: str) -> None:
    """Load the backend, and the HiGHS of the searches ahead of it: that is no solver's time."""
    from stlc.milp.builder import ModelBuilder

    builder = ModelBuilder("nothing")
    builder.binary("x", (1,))
    model = builder.build()
    for name in {"highs", backend}:
        backends.get(name).solve(model, SolveOptions(threads=1))


def solve_options(job: Job, report: Any = None) -> SolveOptions:
    """A job's limits in the backends' words.

    A repeat is solved with its number as random seed (the first with the solver's own default):
    branch and bound varies by more than the clock does.
    """
    limits, seed = job.limits, job.repeat or None
    return SolveOptions(limits.seconds, limits.gap, limits.threads, seed, on_progress=report)


def no_point(solution: Solution) -> dict[str, Figure]:
    """Status and message of an answer without a point."""
    match solution.status:
        case Status.INFEASIBLE:
            return {"status": "infeasible", "message": "claimed by the solver"}
        case Status.NO_SOLUTION:
            return {"status": "no_plan", "message": solution.message}
        case _:
            return {"status": "failed", "message": solution.message or solution.status.value}


def sizes(model: Model) -> dict[str, int]:
    """Columns, binaries, rows, nonzeros."""
    return {
        "columns": model.columns,
        "binaries": model.binaries,
        "rows": model.rows,
        "nonzeros": model.nonzeros,
    }


def relaxation(model: Model, limit: float) -> float | None:
    """Optimum of the LP relaxation by HiGHS, None when it is too large or takes too long."""
    if model.nonzeros > LP_NONZEROS:
        return None
    try:
        return lp_bound(model, min(limit, LP_SECONDS))
    except SolverError:
        return None
