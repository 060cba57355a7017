"""The HiGHS inside SciPy, by `scipy.optimize.milp`: no start, callback, seed or threads."""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass, replace
from typing import Any, ClassVar, cast

from stlc.backends.base import Capability, Solution, SolveOptions, Status
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
from stlc.milp.model import Model


@dataclass(frozen=True, slots=True)
class ScipyMilp:
    """`scipy.optimize.milp`; SciPy bundles an older HiGHS than highspy."""

    name: ClassVar[str] = "scipy"
    capabilities: ClassVar[Capability] = (
        Capability.TIME_LIMIT | Capability.GAP | Capability.NODES | Capability.EXTRA
    )

    def available(self) -> str | None:
        """None when SciPy can be imported."""
        return missing("scipy", "scipy")

    @quietly
    def version(self) -> str:
        """Such as 'SciPy 1.17.1'."""
        import scipy

        return f"SciPy {scipy.__version__} (milp)"

    @quietly
    def solve(self, model: Model, options: SolveOptions) -> Solution:
        """Minimise. `extra` takes SciPy's own `node_limit` and `presolve`."""
        require(self)
        if (answer := trivial(self, model, options)) is not None:
            return answer
        began = time.perf_counter()
        result = _run(model, options)
        if result.status == 2 and "presolve" not in options.extra:
            result = _without_presolve(model, options, result)
        status = _status(result)
        if status is None:
            status = infeasible_or_unbounded(self, model, options)
        has_point = result.x is not None and status in (Status.OPTIMAL, Status.FEASIBLE)
        is_mip = bool(model.integrality.any())
        bound = finite(result.get("mip_dual_bound"))
        if not is_mip and status is Status.OPTIMAL:
            bound = float(result.fun)
        return Solution(
            status,
            point(result.x, model.columns, "SciPy") if has_point else None,
            float(result.fun) + model.offset if has_point else None,
            None if bound is None or result.status == 2 else bound + model.offset,
            result.get("mip_node_count") if is_mip else None,
            time.perf_counter() - began,
            self.name,
            self.version(),
            ignored(self, options),
            str(result.message),
        )


def _without_presolve(model: Model, options: SolveOptions, first: Any) -> Any:
    """SciPy's HiGHS 1.12 calls some feasible missions infeasible: ask again, without presolve."""
    again = _run(model, replace(options, extra={**options.extra, "presolve": False}))
    return first if again.status in (1, 2) else again  # at a limit the first verdict stands


def _run(model: Model, options: SolveOptions) -> Any:
    """scipy's own result; options that it doesn't know are errors instead of warnings."""
    from scipy.optimize import Bounds, LinearConstraint, milp

    settings: dict[str, Any] = {"mip_rel_gap": options.gap, **options.extra}
    if options.time_limit is not None:
        settings["time_limit"] = options.time_limit
    rows = [LinearConstraint(model.A, model.row_lower, model.row_upper)] if model.rows else []
    with warnings.catch_warnings():
        warnings.simplefilter("error", category=RuntimeWarning)  # unknown options are refused
        return milp(
            model.c,
            integrality=model.integrality,
            bounds=Bounds(model.col_lower, model.col_upper),
            constraints=rows,
            options=cast(Any, settings),
        )


def _status(result: Any) -> Status | None:
    """None where SciPy's status 4 hides 'infeasible or unbounded'."""
    match result.status:
        case 0:
            return Status.OPTIMAL
        case 1:
            return Status.NO_SOLUTION if result.x is None else Status.FEASIBLE
        case 2:
            return Status.INFEASIBLE
        case 3:
            return Status.UNBOUNDED
        case _ if "unbounded or infeasible" in str(result.message).lower():
            return None
        case _:
            return Status.FAILED
