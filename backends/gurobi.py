"""Gurobi by gurobipy, with its licence as found; parameters (remote ones too) by `extra`."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from stlc.backends.base import Capability, Floats, Progress, Solution, SolveOptions, Status
from stlc.backends.quiet import quietly
from stlc.backends.support import (
    Worker,
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

# Parameters of the environment: they say where to solve, and must be set before it starts.
_REMOTE = ("ComputeServer", "ServerPassword", "CloudAccessID", "CloudSecretKey", "CloudPool",
           "CSManager", "CSAPIAccessID", "CSAPISecret", "CSRouter", "CSGroup", "CSPriority",
           "TokenServer", "TSPort", "WLSAccessID", "WLSSecret", "LicenseID", "Username",
           "WorkerPool", "WorkerPassword")  # fmt: skip


@dataclass(frozen=True, slots=True)
class Gurobi:
    """Gurobi; the licence that comes with gurobipy solves up to 2000 columns and rows."""

    name: ClassVar[str] = "gurobi"
    capabilities: ClassVar[Capability] = ~Capability.NONE

    def available(self) -> str | None:
        """None when gurobipy can be imported."""
        return missing("gurobipy", "'stlc[gurobi]'")

    @quietly
    def version(self) -> str:
        """Such as 'Gurobi 13.0.3'."""
        import gurobipy

        return "Gurobi " + ".".join(str(part) for part in gurobipy.gurobi.version())

    @quietly
    def solve(self, model: Model, options: SolveOptions) -> Solution:
        """Minimise. SolverError for a licence that is missing or too small, or a refused option."""
        import gurobipy

        require(self)
        if (answer := trivial(self, model, options)) is not None:
            return answer
        began = time.perf_counter()
        try:
            with _environment(options) as env, gurobipy.Model(env=env) as grb:
                worker = Worker(options)
                x = _load(grb, model, options)
                report = _listener(worker, x)
                worker.run(lambda: grb.optimize(report), grb.terminate)
                return self._read(grb, x, model, options, began)
        except gurobipy.GurobiError as error:
            raise SolverError(f"Gurobi: {error}") from error

    def _read(
        self, grb: Any, x: Any, model: Model, options: SolveOptions, began: float
    ) -> Solution:
        """The answer; a bound is taken only where Gurobi's status makes it one."""
        status = _status(grb)
        if status is None:
            status = infeasible_or_unbounded(self, model, options)
        has_point = status in (Status.OPTIMAL, Status.FEASIBLE)
        bound = finite(grb.ObjBound) if has_point or status is Status.NO_SOLUTION else None
        return Solution(
            status,
            point(x.X, model.columns, "Gurobi") if has_point else None,
            float(grb.ObjVal) if has_point else None,
            bound,
            int(grb.NodeCount) if grb.IsMIP else None,
            time.perf_counter() - began,
            self.name,
            self.version(),
            ignored(self, options),
            f"Gurobi status {grb.Status}",
        )


def _environment(options: SolveOptions) -> Any:
    import gurobipy

    settings: dict[str, Any] = {"OutputFlag": 0}
    settings |= {key: value for key, value in options.extra.items() if key in _REMOTE}
    return gurobipy.Env(params=settings)


def _load(grb: Any, model: Model, options: SolveOptions) -> Any:
    """Columns, rows and parameters into `grb`; a row with two sides becomes two."""
    kinds = np.where(model.integrality == 1, "I", "C")
    x = grb.addMVar(model.columns, lb=model.col_lower, ub=model.col_upper, obj=model.c, vtype=kinds)
    grb.ObjCon = model.offset
    low, high = np.isfinite(model.row_lower), np.isfinite(model.row_upper)
    equal = model.row_lower == model.row_upper
    for mask, sense, side in (
        (equal, "=", model.row_upper), (high & ~equal, "<", model.row_upper),
        (low & ~equal, ">", model.row_lower),
    ):  # fmt: skip
        if mask.any():
            grb.addMConstr(model.A[mask], x, sense, side[mask])
    if options.start is not None:
        x.Start = options.start
    grb.setParam("MIPGap", options.gap)
    asked = (
        ("TimeLimit", options.time_limit),
        ("Threads", options.workers),
        ("Seed", options.seed),
    )
    for key, value in (*asked, *options.extra.items()):
        if value is not None and key not in _REMOTE:
            grb.setParam(key, value)
    return x


def _listener(worker: Worker, x: Any) -> Any:
    """The callback: hands on incumbents and progress, and ends the run when asked to."""
    from gurobipy import GRB

    def heard(grb: Any, where: int) -> None:
        if worker.stopping():
            grb.terminate()
        if where == GRB.Callback.MIPSOL:
            worker.report(_incumbent(grb, x, GRB.Callback))
        elif where == GRB.Callback.MIP:
            worker.report(_progress(grb, GRB.Callback))

    return heard


def _incumbent(grb: Any, x: Any, codes: Any) -> Progress:
    point: Floats = np.array(grb.cbGetSolution(x), dtype=float)
    return Progress(
        grb.cbGet(codes.RUNTIME), finite(grb.cbGet(codes.MIPSOL_OBJ)),
        finite(grb.cbGet(codes.MIPSOL_OBJBND)), int(grb.cbGet(codes.MIPSOL_NODCNT)), point,
    )  # fmt: skip


def _progress(grb: Any, codes: Any) -> Progress:
    return Progress(
        grb.cbGet(codes.RUNTIME), finite(grb.cbGet(codes.MIP_OBJBST)),
        finite(grb.cbGet(codes.MIP_OBJBND)), int(grb.cbGet(codes.MIP_NODCNT)),
    )  # fmt: skip


def _status(grb: Any) -> Status | None:
    """None when Gurobi cannot tell infeasible from unbounded."""
    from gurobipy import GRB

    match grb.Status:
        case GRB.OPTIMAL:
            return Status.OPTIMAL
        case GRB.INFEASIBLE:
            return Status.INFEASIBLE
        case GRB.UNBOUNDED:
            # Gurobi says so of a MILP by its relaxation alone.
            return None if grb.IsMIP else Status.UNBOUNDED
        case GRB.INF_OR_UNBD:
            return None
        case GRB.NUMERIC | GRB.LOADED | GRB.INPROGRESS:
            return Status.FAILED
        case _:
            return Status.FEASIBLE if grb.SolCount else Status.NO_SOLUTION
