"""CBC by python-mip: its own C interface, filled with whole arrays in one call."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np

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
from stlc.errors import SolverError
from stlc.milp.model import Model

# Parts of CBC's C interface that python-mip's own declarations leave out.
_DECLARATIONS = """
void Cbc_loadProblem(void *model, const int numcols, const int numrows, const int *start,
    const int *index, const double *value, const double *collb, const double *colub,
    const double *obj, const double *rowlb, const double *rowub);
int Cbc_getNodeCount(void *model);
const char *Cbc_getVersion(void);
"""


@dataclass(frozen=True, slots=True)
class PythonMip:
    """The development CBC that python-mip 2 brings along."""

    name: ClassVar[str] = "mip"
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
        """None when python-mip can be imported."""
        return missing("mip", "'stlc[mip]'")

    @quietly
    def version(self) -> str:
        """Such as 'CBC devel (python-mip 2.0.0)'."""
        from importlib.metadata import version

        ffi, lib = _cbc()
        return f"CBC {ffi.string(lib.Cbc_getVersion()).decode()} (python-mip {version('mip')})"

    @quietly
    def solve(self, model: Model, options: SolveOptions) -> Solution:
        """Minimise. `extra` are CBC's parameters, set by name; CBC ignores unknown ones."""
        require(self)
        if (answer := trivial(self, model, options)) is not None:
            return answer
        began = time.perf_counter()
        mip = _loaded(model, options)
        claim = mip.optimize(max_seconds=_seconds(options))
        status = _STATUS.get(claim.name, Status.FAILED)
        if status is Status.UNBOUNDED and model.integrality.any() and model.c.any():
            status = infeasible_or_unbounded(self, model, options)  # only its relaxation is
        has_point = status in (Status.OPTIMAL, Status.FEASIBLE)
        bound = finite(mip.objective_bound) if has_point or status is Status.NO_SOLUTION else None
        return Solution(
            status,
            _point(mip, model) if has_point else None,
            mip.objective_value + model.offset if has_point else None,
            None if bound is None else bound + model.offset,
            _cbc()[1].Cbc_getNodeCount(mip.solver._model) if model.integrality.any() else None,
            time.perf_counter() - began,
            self.name,
            self.version(),
            ignored(self, options),
            claim.name.lower().replace("_", " "),
        )


_STATUS = {
    "OPTIMAL": Status.OPTIMAL,
    "FEASIBLE": Status.FEASIBLE,
    "INFEASIBLE": Status.INFEASIBLE,
    "INT_INFEASIBLE": Status.INFEASIBLE,
    "UNBOUNDED": Status.UNBOUNDED,
    "NO_SOLUTION_FOUND": Status.NO_SOLUTION,
}


@cache
def _cbc() -> tuple[Any, Any]:
    import mip.cbc

    if not mip.cbc.has_cbc:
        raise SolverError("python-mip could not load its CBC library")
    # Looked up first: a mip.Model that is garbage collected inside `cdef` would look it up while
    # cffi holds its lock, and wait for ever.
    _ = mip.cbc.cbclib.Cbc_deleteModel
    mip.cbc.ffi.cdef(_DECLARATIONS, override=True)
    return mip.cbc.ffi, mip.cbc.cbclib


def _seconds(options: SolveOptions) -> float:
    return float("inf") if options.time_limit is None else options.time_limit


def _loaded(model: Model, options: SolveOptions) -> Any:
    """The model by CBC's own C interface, in blocks: python-mip takes one coefficient at a time."""
    import mip

    ffi, lib = _cbc()
    target = mip.Model(sense=mip.MINIMIZE, solver_name=mip.CBC)  # it would pick Gurobi otherwise
    target.verbose = 0
    cbc, A = target.solver._model, model.A.tocsc()
    starts, rows = A.indptr.astype(np.int32), A.indices.astype(np.int32)
    doubles = [
        np.ascontiguousarray(v, dtype=float)
        for v in (
            A.data, model.col_lower, model.col_upper, model.c, model.row_lower, model.row_upper
        )
    ]  # fmt: skip
    lib.Cbc_loadProblem(
        cbc, model.columns, model.rows, ffi.from_buffer("int[]", starts),
        ffi.from_buffer("int[]", rows), *(ffi.from_buffer("double[]", d) for d in doubles),
    )  # fmt: skip
    for column in np.flatnonzero(model.integrality).tolist():
        lib.Cbc_setInteger(cbc, column)
    target.vars.update_vars(model.columns)
    target.constrs.update_constrs(model.rows)
    _configure(target, options)
    return target


def _configure(target: Any, options: SolveOptions) -> None:
    """Gap, threads, seed, parameters of CBC by name, and the start."""
    target.max_mip_gap = options.gap
    if options.workers > 1:
        target.threads = options.workers
    if options.seed is not None:
        target.seed = options.seed
    ffi, lib = _cbc()
    serial = {"threads": 0} if options.workers == 1 else {}  # 1 would be a thread and its master
    for key, value in (serial | options.extra).items():
        lib.Cbc_setParameter(target.solver._model, key.encode(), str(value).encode())
    if options.start is not None:
        columns = np.arange(len(options.start), dtype=np.int32)
        lib.Cbc_setMIPStartI(
            target.solver._model, len(columns), ffi.from_buffer("int[]", columns),
            ffi.from_buffer("double[]", np.ascontiguousarray(options.start, dtype=float)),
        )  # fmt: skip


def _point(target: Any, model: Model) -> Any:
    ffi, lib = _cbc()
    values = lib.Cbc_getColSolution(target.solver._model)
    if values == ffi.NULL:
        raise SolverError("CBC claims a solution but returned no point")
    return point(ffi.unpack(values, model.columns), model.columns, "CBC")
