"""What every backend must do. Third parties run it on their own:

    from stlc.backends.conformance import CASES, Case

    @pytest.mark.parametrize("case", CASES, ids=str)
    def test_conforms(case: Case) -> None:
        case.check(MyBackend())

A case asks for the optimum and certifies the point; solution vectors are never compared.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from stlc.backends.base import Backend, Capability, Progress, Solution, SolveOptions, Status
from stlc.backends.conformance_models import (
    best_knapsack,
    big_m,
    duplicates,
    empty,
    equalities,
    fixed_columns,
    free_columns,
    general_integers,
    hard,
    infeasible_lp,
    infeasible_mip,
    knapsack,
    negative_integers,
    offset,
    production,
    ranges,
    rowless,
    unbounded,
    unused,
)
from stlc.milp.model import Model
from stlc.milp.violations import exact_objective, violations

_TOLERANCE = 1e-5  # of rows, bounds and integers: the loosest default among solvers


@dataclass(frozen=True, slots=True)
class Case:
    """One model, what it must come to, and the options it is asked under."""

    name: str
    build: Callable[[], Model]
    status: Status
    objective: float | None = None
    options: SolveOptions = field(default_factory=lambda: SolveOptions(time_limit=60.0))
    extra: Callable[[Backend, Model], None] | None = None
    needs: Capability = Capability.NONE

    def __str__(self) -> str:
        return self.name

    def applies(self, backend: Backend) -> bool:
        """Does the backend offer what the case is about?"""
        return self.needs in backend.capabilities

    def check(self, backend: Backend) -> None:
        """AssertionError (or SolverError) when the backend does not conform."""
        if not self.applies(backend):
            return
        model = self.build()
        if self.extra is not None:
            self.extra(backend, model)
            return
        solution = backend.solve(model, self.options)
        assert solution.status is self.status, f"{solution.status} instead of {self.status}"
        assert solution.solver
        assert solution.solver_version
        if self.objective is None:
            assert self.status is not Status.OPTIMAL
            return
        value = _checked(model, solution)
        error = abs(value - self.objective)
        assert error <= 1e-6 + self.options.gap * abs(self.objective), value


def _checked(model: Model, solution: Solution) -> float:
    """The exact objective of an answer's point, its integers rounded; AssertionError where the
    point breaks the model by more than solvers promise, or is worth something else."""
    assert solution.x is not None, "no point"
    assert solution.x.shape == (model.columns,)
    x = np.where(model.integrality == 1, np.round(solution.x), solution.x)
    assert np.abs(x - solution.x).max(initial=0.0) <= _TOLERANCE, "integers are off"
    found = violations(model, np.clip(x, model.col_lower, model.col_upper))
    assert max(found.rows_relative, found.bounds_relative) <= _TOLERANCE, found.describe()
    value = exact_objective(model, x)
    assert solution.objective is not None
    assert abs(value - solution.objective) <= _TOLERANCE * (1 + abs(value))
    return value


def _limit(backend: Backend, model: Model) -> None:
    """A time limit ends the work; what is claimed then can be certified, and is not optimal."""
    asked = SolveOptions(time_limit=1.0)
    solution = backend.solve(model, asked)
    assert solution.status in (Status.FEASIBLE, Status.NO_SOLUTION), solution.status
    assert solution.seconds < 20
    if solution.x is not None:
        value = _checked(model, solution)
        assert solution.bound is None or solution.bound <= value + 1e-6


def _start(backend: Backend, model: Model) -> None:
    """A start is taken or reported, and does not spoil the optimum; it may be off its bounds by
    as much as solvers' own answers are."""
    first = backend.solve(model, SolveOptions(time_limit=60.0))
    assert first.x is not None
    off = first.x + np.where(first.x > 0.5, 5e-7, -5e-7)
    again = backend.solve(model, SolveOptions(time_limit=60.0, start=off))
    assert again.objective is not None
    assert first.objective is not None
    assert abs(again.objective - first.objective) <= 2e-4 * abs(first.objective)
    assert ("start" in again.ignored) != bool(backend.capabilities & Capability.START)


def _options(backend: Backend, model: Model) -> None:
    """Every option is honoured or listed as ignored."""
    asked = SolveOptions(
        time_limit=60.0, gap=1e-3, threads=1, seed=7, start=np.zeros(model.columns),
        on_progress=lambda _: None, should_stop=lambda: False,
    )  # fmt: skip
    solution = backend.solve(model, asked)
    can = backend.capabilities
    progress = Capability.PROGRESS | Capability.INCUMBENTS
    pairs = {
        "time_limit": Capability.TIME_LIMIT, "gap": Capability.GAP, "threads": Capability.THREADS,
        "seed": Capability.SEED, "start": Capability.START, "on_progress": progress,
        "should_stop": Capability.CANCEL,
    }  # fmt: skip
    for name, capability in pairs.items():
        assert (name in solution.ignored) != bool(can & capability), name


def _incumbents(backend: Backend, model: Model) -> None:
    """Each incumbent handed over while solving can be certified; the last is the answer's."""
    seen: list[Progress] = []
    solution = backend.solve(model, SolveOptions(time_limit=60.0, on_progress=seen.append))
    points = [p for p in seen if p.incumbent is not None]
    assert points, "no incumbent was handed over"
    for p in points:
        claim = replace(
            solution, status=Status.FEASIBLE, x=p.incumbent, objective=p.objective, bound=None
        )
        _checked(model, claim)
    assert solution.objective is not None
    assert points[-1].objective is not None
    assert abs(points[-1].objective - solution.objective) <= 1e-3 * abs(solution.objective)


def _cancel(backend: Backend, model: Model) -> None:
    """`should_stop` ends the work within seconds."""
    calls = iter(range(10**9))
    asked = SolveOptions(time_limit=30.0, should_stop=lambda: next(calls) > 5)
    solution = backend.solve(model, asked)
    assert solution.status in (Status.FEASIBLE, Status.NO_SOLUTION), solution.status
    assert solution.seconds < 15


CASES = (
    Case("feasible LP", production, Status.OPTIMAL, -36.0),
    Case("feasible MILP", knapsack, Status.OPTIMAL, best_knapsack()),
    Case("general integers", general_integers, Status.OPTIMAL, 5.0),
    Case("negative integers", negative_integers, Status.OPTIMAL, -3.0),
    Case("free columns", free_columns, Status.OPTIMAL, 5.0),
    Case("fixed columns", fixed_columns, Status.OPTIMAL, 6.5),
    Case("equality rows", equalities, Status.OPTIMAL, 6.5),
    Case("two-sided rows", ranges, Status.OPTIMAL, -7.0),
    Case("offset", offset, Status.OPTIMAL, 103.25),
    Case("big-M disjunction", big_m, Status.OPTIMAL, 2.0),
    Case("duplicates add up", duplicates, Status.OPTIMAL, -4.0),
    Case("infeasible LP", infeasible_lp, Status.INFEASIBLE),
    Case("infeasible MILP", infeasible_mip, Status.INFEASIBLE),
    Case("unbounded", unbounded, Status.UNBOUNDED),
    Case("empty model", empty, Status.OPTIMAL, 2.0),
    Case("no rows", rowless, Status.OPTIMAL, -7.5),
    Case("unused columns, empty rows", unused, Status.OPTIMAL, -2.0),
    Case("time limit", hard, Status.FEASIBLE, extra=_limit, needs=Capability.TIME_LIMIT),
    Case("start", knapsack, Status.OPTIMAL, extra=_start),
    Case("options honoured or reported", knapsack, Status.OPTIMAL, extra=_options),
    Case("incumbents", knapsack, Status.OPTIMAL, extra=_incumbents, needs=Capability.INCUMBENTS),
    Case("cancel", hard, Status.FEASIBLE, extra=_cancel, needs=Capability.CANCEL),
)
