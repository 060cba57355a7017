"""HiGHS by highspy: the embedded default solver. Arrays go over in one `passModel` call."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from stlc.backends.base import Capability, Solution, SolveOptions, Status
from stlc.backends.highs_session import SCHEDULER, listen, new_highs
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


def _highspy() -> Any:
    import highspy

    return highspy


@dataclass(frozen=True, slots=True)
class Highs:
    """HiGHS >= 1.15.1 (1.14.0 returned wrong optima)."""

    name: ClassVar[str] = "highs"
    capabilities: ClassVar[Capability] = ~Capability.NONE

    def available(self) -> str | None:
        """None when highspy can be imported."""
        return missing("highspy", "'highspy>=1.15.1'")

    @quietly
    def version(self) -> str:
        """Such as 'HiGHS 1.15.1'."""
        return f"HiGHS {new_highs().version()}"

    @quietly
    def solve(self, model: Model, options: SolveOptions) -> Solution:
        """Minimise. SolverError on any error status of HiGHS; solver options through `extra`."""
        require(self)
        if (answer := trivial(self, model, options)) is not None:
            return answer
        began = time.perf_counter()
        with SCHEDULER.claim(options.workers) as threads:
            h, worker = _loaded(model), Worker(options)
            _configure(h, model, options, threads)
            listen(h, worker, model)
            worker.run(lambda: _check(h.run(), "run"))
            found = self._read(h, model, options, threads, time.perf_counter() - began)
        if options.start is None or not _is_belied(model, found):
            return found
        return self.solve(model, _afresh(options, found))

    def _read(
        self, h: Any, model: Model, options: SolveOptions, threads: int, seconds: float
    ) -> Solution:
        """The answer, without points that HiGHS keeps with statuses that don't vouch for them."""
        info, has_point = h.getInfo(), _has_point(h)
        status = _status(h, has_point)
        if status is None:
            status = infeasible_or_unbounded(self, model, options)
        has_point = has_point and status in (Status.OPTIMAL, Status.FEASIBLE)
        is_mip = bool(model.integrality.any())
        bound = info.mip_dual_bound if is_mip else info.objective_function_value
        known = is_mip or status is Status.OPTIMAL
        return Solution(
            status,
            point(h.getSolution().col_value, model.columns, "HiGHS") if has_point else None,
            info.objective_function_value if has_point else None,
            finite(bound) if known and status is not Status.INFEASIBLE else None,
            int(info.mip_node_count) if is_mip else None,
            seconds,
            self.name,
            self.version(),
            ignored(self, options) + (() if options.threads in (None, threads) else ("threads",)),
            h.modelStatusToString(h.getModelStatus()),
        )


def _is_belied(model: Model, found: Solution) -> bool:
    """Whether the point has another objective than is claimed of it.

    HiGHS 1.16.0 may hand back the start with the objective of a better point that it found.
    """
    if found.x is None or found.objective is None:
        return False
    value = model.objective(found.x)
    return abs(value - found.objective) > 1e-5 * (1.0 + abs(value) + float(np.abs(found.x).max()))


def _afresh(options: SolveOptions, found: Solution) -> SolveOptions:
    """What is asked of a second solve: no start, in the time that is left."""
    left = options.time_limit
    left = None if left is None else max(left - found.seconds, 0.01)
    return replace(options, start=None, time_limit=left)


def _check(status: Any, what: str) -> None:
    if status == _highspy().HighsStatus.kError:
        raise SolverError(f"HiGHS reported an error in {what}")


def _loaded(model: Model) -> Any:
    """HiGHS with the model; its row-wise matrix is ours as it stands."""
    hs, A = _highspy(), model.A
    h = new_highs()
    status = h.passModel(
        model.columns, model.rows, A.nnz, int(hs.MatrixFormat.kRowwise),
        int(hs.ObjSense.kMinimize), model.offset, model.c, model.col_lower, model.col_upper,
        model.row_lower, model.row_upper, A.indptr.astype(np.int32), A.indices.astype(np.int32),
        A.data, model.integrality.astype(np.int32),
    )  # fmt: skip
    _check(status, "passModel")
    return h


def _configure(h: Any, model: Model, options: SolveOptions, threads: int) -> None:
    """Options, the user's last, and the start; a refused one is a SolverError that names it."""
    values: dict[str, object] = {"mip_rel_gap": options.gap, "threads": threads}
    if options.time_limit is not None:
        values["time_limit"] = float(options.time_limit)
    if options.seed is not None:
        values["random_seed"] = options.seed
    for key, value in (values | options.extra).items():
        _check(h.setOptionValue(key, value), f"option {key} = {value!r}")
    if options.start is not None:
        columns = np.arange(len(options.start), dtype=np.int32)
        within = np.clip(options.start, model.col_lower, model.col_upper)  # or it is refused
        _check(h.setSolution(len(columns), columns, within), "setSolution")


def _has_point(h: Any) -> bool:
    return bool(h.getInfo().primal_solution_status == _highspy().kSolutionStatusFeasible)


def _status(h: Any, has_point: bool) -> Status | None:
    """None when HiGHS cannot tell infeasible from unbounded."""
    claims = _highspy().HighsModelStatus
    match h.getModelStatus():
        case claims.kOptimal:
            return Status.OPTIMAL
        case claims.kInfeasible:
            return Status.INFEASIBLE
        case claims.kUnbounded:
            return Status.UNBOUNDED
        case claims.kUnboundedOrInfeasible:
            return None
        case (
            claims.kTimeLimit
            | claims.kInterrupt
            | claims.kSolutionLimit
            | claims.kIterationLimit
            | claims.kObjectiveBound
            | claims.kObjectiveTarget
        ):
            return Status.FEASIBLE if has_point else Status.NO_SOLUTION
        case _:
            return Status.FAILED
