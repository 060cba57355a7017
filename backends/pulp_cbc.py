"""CBC through PuLP: its own bundled binary, by explicit path."""

from __future__ import annotations

import os
import subprocess
import time
from dataclasses import dataclass
from functools import cache
from typing import ClassVar

from stlc.backends import cbc_log
from stlc.backends.base import Capability, Solution, SolveOptions, Status
from stlc.backends.pulp_model import FileProblem
from stlc.backends.quiet import quietly
from stlc.backends.support import (
    claimed_bound,
    ignored,
    infeasible_or_unbounded,
    missing,
    require,
    trivial,
)
from stlc.errors import SolverError
from stlc.files import scratch_folder
from stlc.milp.model import Model


@dataclass(frozen=True, slots=True)
class PulpCbc:
    """PuLP 3.3 with the CBC 2.10 that it brings along."""

    name: ClassVar[str] = "pulp"
    capabilities: ClassVar[Capability] = (
        Capability.START
        | Capability.TIME_LIMIT
        | Capability.GAP
        | Capability.THREADS
        | Capability.SEED
        | Capability.NODES
        | Capability.EXTRA
    )

    def available(self) -> str | None:
        """None when PuLP can be imported and its CBC binary may be run."""
        problem = missing("pulp", "'stlc[pulp]'")
        if problem is None and not os.access(bundled_cbc(), os.X_OK):
            return "PuLP's CBC binary is not executable; run: pip install --force-reinstall pulp"
        return problem

    @quietly
    def version(self) -> str:
        """Such as 'CBC 2.10.3 (PuLP 3.3.2)'."""
        from importlib.metadata import version

        return f"{_binary_version(bundled_cbc())} (PuLP {version('pulp')})"

    @quietly
    def solve(self, model: Model, options: SolveOptions) -> Solution:
        """Minimise. `extra` are command line options of CBC, name to value."""
        require(self)
        if (answer := trivial(self, model, options)) is not None:
            return answer
        began = time.perf_counter()
        problem = FileProblem(model, options.start)
        log = _run(problem, options)
        status = _status(problem)
        if status is Status.UNBOUNDED or (status is Status.INFEASIBLE and "unbounded" in log):
            status = infeasible_or_unbounded(self, model, options)
        has_point = status in (Status.OPTIMAL, Status.FEASIBLE)
        x = problem.x if has_point else None
        objective = None if x is None else model.objective(x)
        bound = cbc_log.bound(log) if has_point else None
        return Solution(
            status,
            x,
            objective,
            claimed_bound(status, objective, options) if bound is None else bound,
            cbc_log.nodes(log),
            time.perf_counter() - began,
            self.name,
            self.version(),
            ignored(self, options),
            _claim(problem),
        )


def bundled_cbc() -> str:
    """Path of the CBC binary inside the PuLP package (never one found on PATH)."""
    from pulp.apis.coin_api import pulp_cbc_path

    return str(pulp_cbc_path)


@cache
def _binary_version(path: str) -> str:
    run = subprocess.run([path, "-quit"], capture_output=True, text=True, timeout=30, check=False)
    return cbc_log.version(run.stdout)


def _run(problem: FileProblem, options: SolveOptions) -> str:
    import pulp

    threads = options.workers if options.workers > 1 else 0  # 1 would be a thread and its master
    extra = [f"threads {threads}", *(f"{key} {value}" for key, value in options.extra.items())]
    if options.seed is not None:
        extra += [f"randomSeed {options.seed}", f"randomCbcSeed {options.seed}"]
    with scratch_folder() as folder:
        log = folder / "cbc.log"
        solver = pulp.COIN_CMD(
            path=bundled_cbc(), msg=False, mip=bool(problem.model.integrality.any()),
            timeLimit=options.time_limit, gapRel=options.gap, threads=None,
            options=extra, logPath=str(log), warmStart=options.start is not None,
        )  # fmt: skip
        solver.tmpDir = folder
        try:
            solver.actualSolve(problem)
        except pulp.PulpSolverError as error:
            raise SolverError(f"PuLP: {error}") from error
        return log.read_text(errors="replace")


def _status(problem: FileProblem) -> Status:
    """PuLP's `status` says Optimal at a time limit; `sol_status` tells the truth.

    The other way round for CBC's 'Integer infeasible', which `sol_status` does not know.
    """
    if problem.status == -1:
        return Status.INFEASIBLE
    match problem.sol_status:
        case 1:
            return Status.OPTIMAL
        case 2:
            return Status.FEASIBLE
        case 0:
            return Status.NO_SOLUTION
        case -1:
            return Status.INFEASIBLE
        case -2:
            return Status.UNBOUNDED
        case _:
            return Status.FAILED


def _claim(problem: FileProblem) -> str:
    import pulp

    return str(pulp.LpSolution[problem.sol_status])
