"""HiGHS through CVXPY: one vector variable with bounds and integer attributes, rows as A @ x."""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from stlc.backends.base import Capability, Solution, SolveOptions, Status
from stlc.backends.highs_session import SCHEDULER
from stlc.backends.quiet import quietly
from stlc.backends.support import (
    finite,
    ignored,
    infeasible_or_unbounded,
    missing,
    point,
    require,
    trivial,
)
from stlc.errors import SolverError
from stlc.milp.model import Model


@dataclass(frozen=True, slots=True)
class Cvxpy:
    """CVXPY with its HiGHS interface."""

    name: ClassVar[str] = "cvxpy"
    capabilities: ClassVar[Capability] = (
        Capability.TIME_LIMIT
        | Capability.GAP
        | Capability.THREADS
        | Capability.SEED
        | Capability.NODES
        | Capability.EXTRA
    )

    def available(self) -> str | None:
        """None when CVXPY can be imported."""
        return missing("cvxpy", "'stlc[cvxpy]'")

    @quietly
    def version(self) -> str:
        """Such as 'HiGHS 1.15.1 (CVXPY 1.9.3)'."""
        from importlib.metadata import version

        return f"HiGHS {version('highspy')} (CVXPY {version('cvxpy')})"

    @quietly
    def solve(self, model: Model, options: SolveOptions) -> Solution:
        """Minimise. `extra` are HiGHS's options; SolverError when CVXPY refuses one."""
        require(self)
        if (answer := trivial(self, model, options)) is not None:
            return answer
        began = time.perf_counter()
        problem, x = _problem(model)
        with SCHEDULER.claim(options.workers) as threads:
            _run(problem, options, threads)
        info = problem.solver_stats.extra_stats if problem.solver_stats is not None else None
        # At a limit without an incumbent CVXPY hands out x = 0: only HiGHS's own info tells.
        feasible = info is not None and info.primal_solution_status == 2
        status = _status(problem.status, feasible)
        if status is None:
            status = infeasible_or_unbounded(self, model, options)
        has_point = status in (Status.OPTIMAL, Status.FEASIBLE)
        is_mip = bool(model.integrality.any())
        bound = finite(info.mip_dual_bound) if is_mip and info is not None else None
        if not is_mip and status is Status.OPTIMAL:
            bound = float(problem.value) - model.offset
        return Solution(
            status,
            point(x.value, model.columns, "CVXPY") if has_point else None,
            float(problem.value) if has_point else None,
            None if bound is None or status is Status.INFEASIBLE else bound + model.offset,
            int(info.mip_node_count) if is_mip and info is not None else None,
            time.perf_counter() - began,
            self.name,
            self.version(),
            ignored(self, options) + (() if options.threads in (None, threads) else ("threads",)),
            str(problem.status),
        )


def _problem(model: Model) -> tuple[Any, Any]:
    """The problem and its variable x; rows with two sides are given as two inequalities."""
    import cvxpy as cp

    integers = np.flatnonzero(model.integrality)
    attributes: dict[str, Any] = {"integer": (integers,)} if len(integers) else {}
    x = cp.Variable(model.columns, bounds=[model.col_lower, model.col_upper], **attributes)
    equal = model.row_lower == model.row_upper
    below, above = ~equal & np.isfinite(model.row_upper), ~equal & np.isfinite(model.row_lower)
    rows = []
    if equal.any():
        rows.append(model.A[equal] @ x == model.row_upper[equal])
    if below.any():
        rows.append(model.A[below] @ x <= model.row_upper[below])
    if above.any():
        rows.append(model.A[above] @ x >= model.row_lower[above])
    return cp.Problem(cp.Minimize(model.c @ x + model.offset), rows), x


def _run(problem: Any, options: SolveOptions, threads: int) -> None:
    """Solves in place; `options.extra` goes to HiGHS as it is. SolverError where CVXPY refuses."""
    import cvxpy as cp

    settings: dict[str, object] = {
        "mip_rel_gap": options.gap, "threads": threads, **options.extra
    }  # fmt: skip
    if options.time_limit is not None:
        settings["time_limit"] = float(options.time_limit)
    if options.seed is not None:
        settings["random_seed"] = options.seed
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", category=UserWarning)  # the status says the same
            problem.solve(solver=cp.HIGHS, **settings)
    except (cp.error.SolverError, ValueError) as error:
        raise SolverError(f"CVXPY: {error}") from error


def _status(claim: str, feasible: bool) -> Status | None:
    """None when HiGHS cannot tell infeasible from unbounded."""
    match claim:
        case "optimal":
            return Status.OPTIMAL
        case "infeasible":
            return Status.INFEASIBLE
        case "unbounded":
            return Status.UNBOUNDED
        case "infeasible_or_unbounded":
            return None
        case "user_limit":
            return Status.FEASIBLE if feasible else Status.NO_SOLUTION
        case _:
            return Status.FAILED
