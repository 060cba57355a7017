"""A peer's model, given as MPS, solved by the same backend under the same limits as ours."""

from __future__ import annotations

import lzma
import time
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np

from stlc import backends
from stlc.backends.base import Progress, Solution, Status
from stlc.backends.highs_session import new_highs
from stlc.bench.job import Figure, Job, Point, Tell, Update
from stlc.bench.machine import cpu_seconds
from stlc.bench.mission_run import load_solvers, no_point, relaxation, sizes, solve_options
from stlc.errors import SolverError, StlcError, UsageError
from stlc.files import scratch_folder
from stlc.milp.model import Block, Model, Origin
from stlc.solve.certify import certify


def run_peer(job: Job, tell: Tell) -> None:
    """Make the run. Certification is against the peer's own rows; there is no mission to verify."""
    try:
        _run(job, tell)
    except StlcError as error:
        tell(Update({"status": "failed", "message": str(error)[:300]}))


def _run(job: Job, tell: Tell) -> None:
    """Solves a model that another tool wrote; the clock starts before it is read."""
    began = time.perf_counter()
    model = model_of(job.files[job.main], job.main)
    tell(Update({"read_seconds": time.perf_counter() - began, **sizes(model)}))

    def report(progress: Progress) -> None:
        at = (progress.seconds, progress.objective, progress.bound, progress.nodes)
        tell(Point(*at))
        if progress.incumbent is not None and not firsts:
            firsts.append(time.perf_counter() - began)
            tell(Update({"first_plan": firsts[0]}))

    firsts: list[float] = []
    load_solvers(job.config.backend)
    started, cpu = time.perf_counter(), cpu_seconds()
    solution = backends.get(job.config.backend).solve(model, solve_options(job, report))
    times = {"solver_seconds": time.perf_counter() - started, "cpu_seconds": cpu_seconds() - cpu}
    answer = {"nodes": solution.nodes, "solver": solution.solver_version, "bound": solution.bound}
    tell(Update({**times, **answer}))
    tell(Update(_certified(job, model, solution)))
    ended = time.perf_counter() - began
    if solution.status is Status.OPTIMAL:
        tell(Update({"proof": ended}))
    if solution.x is not None and not firsts:
        tell(Update({"first_plan": ended}))
    if job.repeat == 0:
        tell(Update({"lp_bound": relaxation(model, job.limits.seconds)}))


def _certified(job: Job, model: Model, solution: Solution) -> dict[str, Figure]:
    """Figures of the answer once certified against the model; there is no mission to verify."""
    if solution.x is None:
        return no_point(solution)
    try:
        answer = certify(model, solution, options=solve_options(job))
    except SolverError as error:
        return {"status": "refused", "message": str(error)[:300]}
    return {
        "status": answer.status.value, "objective": answer.objective, "bound": answer.bound,
        "gap": answer.gap, "certified": True,
    }  # fmt: skip


def model_of(data: bytes, name: str) -> Model:
    """The model of an MPS file (`.mps`, `.mps.gz`, `.mps.xz`), read by HiGHS.

    UsageError when it can't be read, or maximises (the sign of its optimum would not compare).
    """
    highspy: Any = import_module("highspy")
    if name.endswith(".xz"):
        data, name = lzma.decompress(data), name.removesuffix(".xz")
    h = new_highs()
    with scratch_folder() as folder:
        path = folder.joinpath("model.mps.gz" if name.endswith(".gz") else "model.mps")
        path.write_bytes(data)
        if h.readModel(str(path)) == highspy.HighsStatus.kError:
            raise UsageError(f"HiGHS cannot read {name}")
    lp = h.getLp()
    if lp.sense_ == highspy.ObjSense.kMaximize:
        raise UsageError(f"{name} maximises; write it as a minimisation")
    return _from_highs(lp, name)


def _from_highs(lp: Any, name: str) -> Model:
    """A Model of what HiGHS has read: sides, bounds and kinds as they are, names left out."""
    from scipy.sparse import csc_matrix, csr_matrix

    highspy: Any = import_module("highspy")
    a = lp.a_matrix_
    parts = (np.array(a.value_), np.array(a.index_), np.array(a.start_))
    shape = (lp.num_row_, lp.num_col_)
    rowwise = a.format_ == highspy.MatrixFormat.kRowwise
    matrix = csr_matrix(parts, shape) if rowwise else csc_matrix(parts, shape).tocsr()
    matrix.sort_indices()
    integer = [t == highspy.HighsVarType.kInteger for t in lp.integrality_]
    origin = Origin(name)
    model = Model(
        np.array(lp.col_cost_), lp.offset_, matrix, np.array(lp.row_lower_),
        np.array(lp.row_upper_), np.array(lp.col_lower_), np.array(lp.col_upper_),
        np.zeros(lp.num_col_, np.uint8), (Block("x", 0, (lp.num_col_,), origin),),
        (Block("row", 0, (lp.num_row_,), origin),), "peer",
    )  # fmt: skip
    return replace(model, integrality=np.array(integer, np.uint8)) if integer else model
