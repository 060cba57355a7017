"""CBC through PuLP: its own bundled binary, by explicit path."""

from __future__ import annotations

import gc
import os
import subprocess
import tempfile
import time
import warnings
from dataclasses import dataclass
from functools import cache
from math import isfinite
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from stlc.backends import cbc_log
from stlc.backends.base import Capability, Floats, Solution, SolveOptions, Status
from stlc.backends.support import (
    claimed_bound,
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

    def version(self) -> str:
        """Such as 'CBC 2.10.3 (PuLP 3.3.2)'."""
        from importlib.metadata import version

        return f"{_binary_version(bundled_cbc())} (PuLP {version('pulp')})"

    def solve(self, model: Model, options: SolveOptions) -> Solution:
        """Minimise. `extra` are command line options of CBC, name to value."""
        require(self)
        if (answer := trivial(self, model, options)) is not None:
            return answer
        began = time.perf_counter()
        problem, variables = build(model, options.start)
        log = _run(problem, options, integer=bool(model.integrality.any()))
        status = _status(problem)
        if status is Status.UNBOUNDED or (status is Status.INFEASIBLE and "unbounded" in log):
            status = infeasible_or_unbounded(self, model, options)
        has_point = status in (Status.OPTIMAL, Status.FEASIBLE)
        x = point([v.varValue for v in variables], model.columns, "CBC") if has_point else None
        objective = None if x is None else model.objective(x)
        bound = cbc_log.bound(log) if has_point else None
        return Solution(
            status,
            x,
            objective,
            claimed_bound(status, objective, options) if bound is None else bound + model.offset,
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


def build(model: Model, start: Floats | None = None) -> tuple[Any, list[Any]]:
    """PuLP's problem and its variables in our order."""
    collecting = gc.isenabled()
    gc.disable()  # a million new objects, none of them garbage: collection doubles the time
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", category=DeprecationWarning)  # what PuLP 4 will drop
            return _problem(model, start)
    finally:
        if collecting:
            gc.enable()


def _problem(model: Model, start: Floats | None) -> tuple[Any, list[Any]]:
    import pulp

    problem = pulp.LpProblem("model", pulp.LpMinimize)
    variables = _variables(model, start)
    problem.addVariables(variables)
    used = np.flatnonzero(model.c)
    problem.setObjective(pulp.LpAffineExpression({variables[j]: model.c[j] for j in used.tolist()}))
    table, A = np.array(variables, dtype=object), model.A
    entries, values, pointers = table[A.indices].tolist(), A.data.tolist(), A.indptr.tolist()
    bounds = zip(model.row_lower.tolist(), model.row_upper.tolist(), strict=True)
    unused = dict.fromkeys(table[np.bincount(A.indices, minlength=model.columns) == 0], 0.0)
    for i, (low, high) in enumerate(bounds):
        a, b = pointers[i], pointers[i + 1]
        sides = _sides(low, high)
        row = pulp.LpAffineExpression(dict(zip(entries[a:b], values[a:b], strict=True)))
        if unused and sides:  # PuLP's MPS leaves them out but states their bounds: CBC refuses
            row.update(unused)
            unused = {}
        for sense, side in sides:
            problem.addConstraint(pulp.LpConstraint(row, sense, f"r{i}{'elu'[sense]}", side))
    return problem, variables


def _sides(low: float, high: float) -> list[tuple[int, float]]:
    """PuLP's sense (-1 <=, 0 =, 1 >=) and right-hand side of each half of a row."""
    if low == high:
        return [(0, low)]
    return [(s, v) for s, v in ((-1, high), (1, low)) if isfinite(v)]


def _variables(model: Model, start: Floats | None) -> list[Any]:
    import pulp

    lower, upper = (
        [v if isfinite(v) else None for v in bounds.tolist()]
        for bounds in (model.col_lower, model.col_upper)
    )
    kinds = [pulp.LpInteger if i else pulp.LpContinuous for i in model.integrality.tolist()]
    width = len(str(model.columns))  # PuLP sorts variables by name
    made = [
        pulp.LpVariable(f"x{j:0{width}d}", lower[j], upper[j], kinds[j])
        for j in range(model.columns)
    ]
    if start is not None:
        for variable, value in zip(made, np.asarray(start).tolist(), strict=True):
            variable.varValue = value
    return made


def _run(problem: Any, options: SolveOptions, *, integer: bool) -> str:
    import pulp

    extra = [f"{key} {value}" for key, value in options.extra.items()]
    if options.seed is not None:
        extra += [f"randomSeed {options.seed}", f"randomCbcSeed {options.seed}"]
    with tempfile.TemporaryDirectory(prefix="stlc-") as folder:
        log = Path(folder) / "cbc.log"
        solver = pulp.COIN_CMD(
            path=bundled_cbc(), msg=False, mip=integer, timeLimit=options.time_limit,
            gapRel=options.gap, threads=options.threads, options=extra, logPath=str(log),
            warmStart=options.start is not None,
        )  # fmt: skip
        solver.tmpDir = folder
        try:
            problem.solve(solver)
        except pulp.PulpSolverError as error:
            raise SolverError(f"PuLP: {error}") from error
        return log.read_text(errors="replace")


def _status(problem: Any) -> Status:
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


def _claim(problem: Any) -> str:
    import pulp

    return str(pulp.LpSolution[problem.sol_status])
