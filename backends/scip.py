"""SCIP by pyscipopt. It reads our own LP file: faster than MPS, much faster than expressions."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
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
    require,
    trivial,
)
from stlc.errors import SolverError
from stlc.files import scratch_folder
from stlc.milp.model import Model
from stlc.milp.writers.lp import lp_chunks
from stlc.milp.writers.names import plain_texts


@dataclass(frozen=True, slots=True)
class Scip:
    """SCIP 10; it has returned points off integrality as 'optimal', so certify them."""

    name: ClassVar[str] = "scip"
    capabilities: ClassVar[Capability] = ~Capability.NONE

    def available(self) -> str | None:
        """None when pyscipopt can be imported."""
        return missing("pyscipopt", "'stlc[scip]'")

    @quietly
    def version(self) -> str:
        """Such as 'SCIP 10.0.2 (PySCIPOpt 6.3.0)'."""
        from importlib.metadata import version

        scip = _scip().Model()
        numbers = f"{scip.getMajorVersion()}.{scip.getMinorVersion()}.{scip.getTechVersion()}"
        return f"SCIP {numbers} (PySCIPOpt {version('pyscipopt')})"

    @quietly
    def solve(self, model: Model, options: SolveOptions) -> Solution:
        """Minimise. `extra` are SCIP's parameters; SolverError for unknown ones."""
        require(self)
        if (answer := trivial(self, model, options)) is not None:
            return answer
        answer = self._solve(model, options)
        doubtful = answer.status is Status.INFEASIBLE or _is_wrong(model, answer.x)
        if not doubtful or _PRESOLVE in options.extra:
            return answer
        return self._without_presolve(model, options, answer)

    def _without_presolve(self, model: Model, options: SolveOptions, first: Solution) -> Solution:
        """SCIP's presolve lost plans that need every metre, and integrality: ask again."""
        left = options.time_limit
        if left is not None:
            left = max(left - first.seconds, 0.1)
        extra = {**options.extra, _PRESOLVE: 0}
        try:
            again = self._solve(model, replace(options, time_limit=left, extra=extra))
        except SolverError:  # it has nothing to say against its first answer
            return first
        if again.x is None:
            return first
        return replace(again, seconds=first.seconds + again.seconds)

    def _solve(self, model: Model, options: SolveOptions) -> Solution:
        """Solves without the GIL in a thread, so that progress and stops come through."""
        began = time.perf_counter()
        scip = _loaded(model)
        columns = _columns(scip, model)
        _configure(scip, options)
        if options.start is not None:
            _start(scip, columns, options.start)
        worker = Worker(options)
        _listen(scip, columns, worker)
        worker.run(lambda: _optimize(scip), scip.interruptSolve)
        status = _status(scip)
        if status is None:
            status = infeasible_or_unbounded(self, model, options)
        has_point = status in (Status.OPTIMAL, Status.FEASIBLE)
        bound = finite(scip.getDualbound())
        return Solution(
            status,
            _point(scip, columns, scip.getBestSol()) if has_point else None,
            scip.getSolObjVal(scip.getBestSol()) if has_point else None,
            bound if has_point or status is Status.NO_SOLUTION else None,
            int(scip.getNTotalNodes()),
            time.perf_counter() - began,
            self.name,
            self.version(),
            ignored(self, options),
            str(scip.getStatus()),
        )


_PRESOLVE = "presolving/maxrounds"
# Multi-aggregation in SCIP 10.0.2 forgets that a binary is one: 'optimal' points with a binary at
# 0.5 or a row violated by 1, in models of `until`. Without it none was seen.
_SOUND = {"presolving/donotmultaggr": True}
_GROSS = 1e-4


def _is_wrong(model: Model, x: Floats | None) -> bool:
    """Is an integer or a row off by more than tolerances explain?"""
    if x is None:
        return False
    fraction = np.abs(x - np.round(x))[model.integrality == 1]
    activity = model.A @ x
    rows = np.maximum(model.row_lower - activity, activity - model.row_upper)
    size = 1 + abs(model.A) @ np.abs(x)
    return bool(max(np.max(fraction, initial=0.0), np.max(rows / size, initial=0.0)) > _GROSS)


def _scip() -> Any:
    import pyscipopt

    return pyscipopt


def _optimize(scip: Any) -> None:
    """Solve; SolverError for what SCIP itself fails in, which comes as a plain Exception.

    SCIP 10.0.2 ends some infeasible models with 'unspecified error' when presolve is off and the
    seed isn't 0.
    """
    try:
        scip.optimizeNogil()
    except Exception as error:
        if not str(error).startswith("SCIP: "):
            raise
        raise SolverError(f"SCIP failed ({str(error).removeprefix('SCIP: ')})") from error


def _loaded(model: Model) -> Any:
    scip = _scip().Model()
    scip.hideOutput()
    with scratch_folder() as folder:
        path = folder / "model.lp"
        with path.open("wb") as stream:
            stream.writelines(lp_chunks(model, *plain_texts(model)))
        scip.readProblem(str(path))
    return scip


def _columns(scip: Any, model: Model) -> list[Any]:
    """SCIP's variables in our order (the column of the constant, if any, is left out)."""
    by_name = {v.name: v for v in scip.getVars()}
    return [by_name[f"c{j}"] for j in range(model.columns)]


def _configure(scip: Any, options: SolveOptions) -> None:
    """Parameters, the user's last; one that SCIP refuses is a SolverError that names it."""
    values: dict[str, object] = {
        "limits/gap": options.gap, "lp/threads": options.workers, **_SOUND
    }  # fmt: skip
    if options.time_limit is not None:
        values["limits/time"] = float(options.time_limit)
    if options.seed is not None:
        values["randomization/randomseedshift"] = options.seed
    for key, value in (values | options.extra).items():
        try:
            scip.setParam(key, value)
        except (KeyError, ValueError, TypeError, LookupError) as error:
            raise SolverError(f"SCIP refuses the parameter {key} = {value!r}: {error}") from error


def _start(scip: Any, columns: list[Any], start: Floats) -> None:
    solution = scip.createSol()
    for variable, value in zip(columns, start.tolist(), strict=True):
        scip.setSolVal(solution, variable, value)
    scip.addSol(solution)


def _listen(scip: Any, columns: list[Any], worker: Worker) -> None:
    """Hands each new incumbent to the worker, with bound and nodes at that time."""
    if worker.options.on_progress is None:
        return

    def found(scip: Any, event: Any) -> None:
        best = scip.getBestSol()
        worker.report(
            Progress(
                scip.getSolvingTime(),
                finite(scip.getSolObjVal(best)),
                finite(scip.getDualbound()),
                int(scip.getNTotalNodes()),
                _point(scip, columns, best),
            )
        )

    scip.attachEventHandlerCallback(found, [_scip().SCIP_EVENTTYPE.BESTSOLFOUND])


def _point(scip: Any, columns: list[Any], solution: Any) -> Floats:
    return np.array([scip.getSolVal(solution, v) for v in columns], dtype=float)


def _status(scip: Any) -> Status | None:
    """None when SCIP cannot tell infeasible from unbounded."""
    match scip.getStatus():
        case "optimal" | "gaplimit":
            return Status.OPTIMAL
        case "infeasible":
            return Status.INFEASIBLE
        case "unbounded":
            return Status.UNBOUNDED
        case "inforunbd":
            return None
        case str(claim) if claim.endswith("limit") or claim == "userinterrupt":
            return Status.FEASIBLE if scip.getNSols() else Status.NO_SOLUTION
        case _:
            return Status.FAILED
