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
from stlc.milp.builder import ModelBuilder
from stlc.milp.model import Model
from stlc.milp.violations import exact_objective, violations

_TOLERANCE = 1e-5  # of rows, bounds and integers: the loosest default among solvers
INF = float("inf")


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


def _production() -> Model:
    """max 3x + 5y, x <= 4, 2y <= 12, 3x + 2y <= 18 (Hillier and Lieberman): 36 at (2, 6)."""
    b = ModelBuilder("production")
    x = b.add_columns("x", (2,), cost=[-3, -5])
    b.add_dense_rows("plant", x[None, [0, 0, 1]][:, :1], 1, -INF, 4)
    b.add_dense_rows("hall", x[None, 1:], 2, -INF, 12)
    b.add_dense_rows("line", x[None, :], [3, 2], -INF, 18)
    return b.build()


def knapsack(items: int = 12, rows: int = 3, seed: int = 1) -> Model:
    """A multi-dimensional knapsack; larger ones are hard enough for time limits."""
    rng = np.random.default_rng(seed)
    b = ModelBuilder("knapsack")
    take = b.binary("take", (items,), cost=-rng.integers(10, 99, items))
    weight = rng.integers(5, 60, (rows, items))
    cols = np.broadcast_to(take, weight.shape)
    b.add_dense_rows("capacity", cols, weight, -INF, weight.sum(axis=1) // 3)
    return b.build()


def _best_knapsack() -> float:
    """By enumeration."""
    model = knapsack()
    points = (np.arange(1 << model.columns)[:, None] >> np.arange(model.columns)) & 1
    weights = model.A @ points.T
    fits = (weights <= model.row_upper[:, None]).all(axis=0)
    return float((points[fits] @ model.c).min())


def _general_integers() -> Model:
    """min x + y, 3x + 5y >= 31, integers in [-3, 9]: 5 at (-3, 8)."""
    b = ModelBuilder("general")
    x = b.add_columns("x", (2,), -3, 9, integer=True, cost=1)
    b.add_dense_rows("cover", x[None, :], [3, 5], 31, INF)
    return b.build()


def _negative_integers() -> Model:
    """min x, 2x >= -7, x an integer without bounds: -3."""
    b = ModelBuilder("negative")
    x = b.add_columns("x", (1,), -INF, INF, integer=True, cost=1)
    b.add_dense_rows("floor", x[None, :], 2, -7, INF)
    return b.build()


def _free_columns() -> Model:
    """min |z - 4| + |w + 3| by free z = -1, w: 5 + 0."""
    b = ModelBuilder("free")
    z = b.add_columns("z", (2,), -INF, INF)
    t = b.add_columns("t", (2,), cost=1)
    target = np.array([4.0, -3.0])
    pair = np.stack([t, z], -1)
    b.add_dense_rows("above", pair, [1, -1], -target, INF)
    b.add_dense_rows("below", pair, [1, 1], target, INF)
    b.add_dense_rows("pin", z[None, :1], 1, -1, -1)
    return b.build()


def _fixed_columns() -> Model:
    """Columns fixed by their bounds, integer and continuous: 2.5 + 3 + 1."""
    b = ModelBuilder("fixed")
    x = b.add_columns("x", (1,), 2.5, 2.5, cost=1)
    n = b.add_columns("n", (1,), 3, 3, integer=True, cost=1)
    y = b.add_columns("y", (1,), 0, 9, cost=1)
    b.add_dense_rows("row", np.concatenate([x, n, y])[None, :], [1, 1, 1], 6.5, INF)
    return b.build()


def _equalities() -> Model:
    """x + y = 10, x - y = 3, integer slack: x = 6.5."""
    b = ModelBuilder("equalities")
    x = b.add_columns("x", (2,), cost=[1, 0])
    b.add_dense_rows("row", np.broadcast_to(x, (2, 2)), [[1, 1], [1, -1]], [10, 3], [10, 3])
    return b.build()


def _ranges() -> Model:
    """-2 <= x - y <= 5 and 1 <= x + 2y <= 8: max x + y is 7 (x = 6, y = 1)."""
    b = ModelBuilder("ranges")
    x = b.add_columns("x", (2,), 0, 10, cost=-1)
    b.add_dense_rows("row", np.broadcast_to(x, (2, 2)), [[1, -1], [1, 2]], [-2, 1], [5, 8])
    return b.build()


def _offset() -> Model:
    """The constant 100.25 belongs to objective and bound."""
    b = ModelBuilder("offset", offset=100.25)
    x = b.add_columns("x", (2,), 0, 5, integer=True, cost=[1, 2])
    b.add_dense_rows("row", x[None, :], [1, 1], 3, INF)
    return b.build()


def _big_m() -> Model:
    """Outside a box: x <= 2 or x >= 7 by a binary and M = 20; nearest to 5 is 7 at cost 2."""
    b = ModelBuilder("disjunction")
    x = b.add_columns("x", (1,), -10, 10)
    side = b.binary("side", (1,))
    t = b.add_columns("t", (1,), cost=1)
    pair = np.concatenate([x, side])[None, :]
    b.add_dense_rows("left", pair, [1, -20], -INF, 2)
    b.add_dense_rows("right", pair, [1, -20], -13, INF)
    b.add_dense_rows("over", np.concatenate([t, x])[None, :], [1, -1], -5, INF)
    b.add_dense_rows("under", np.concatenate([t, x])[None, :], [1, 1], 5, INF)
    return b.build()


def _duplicates() -> Model:
    """Entries given twice add up: 2x <= 8 by x + x."""
    b = ModelBuilder("duplicates")
    x = b.add_columns("x", (1,), cost=-1)
    b.add_rows("row", [0, 0], [x[0], x[0]], [1.0, 1.0], -INF, 8)
    return b.build()


def _infeasible_lp() -> Model:
    b = ModelBuilder("infeasible")
    x = b.add_columns("x", (2,), 0, 1, cost=1)
    b.add_dense_rows("row", x[None, :], [1, 1], 3, INF)
    return b.build()


def _infeasible_mip() -> Model:
    """2x + 4y = 1 has rational points but no integer one."""
    b = ModelBuilder("parity")
    x = b.add_columns("x", (2,), -9, 9, integer=True, cost=1)
    b.add_dense_rows("row", x[None, :], [2, 4], 1, 1)
    return b.build()


def _unbounded() -> Model:
    b = ModelBuilder("unbounded")
    x = b.add_columns("x", (2,), cost=[-1, 0.5])
    b.add_dense_rows("row", x[None, :], [1, -1], -INF, 5)
    return b.build()


def _empty() -> Model:
    return ModelBuilder("empty", offset=2.0).build()


def _rowless() -> Model:
    b = ModelBuilder("rowless", offset=1.0)
    b.add_columns("x", (3,), -2.5, 4, cost=[1, -1, 0])
    b.add_columns("n", (1,), -2.5, 4, integer=True, cost=1)
    return b.build()


def _unused() -> Model:
    """Columns in no row, an empty row, a free row."""
    b = ModelBuilder("unused")
    x = b.add_columns("x", (3,), 1, 4, cost=[1, -1, 0])
    b.add_rows("row", [0, 2], [x[0], x[0]], [1.0, 1.0], [2, -1, -INF], INF, count=3)
    return b.build()


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


def _hard() -> Model:
    return knapsack(200, 30)


CASES = (
    Case("feasible LP", _production, Status.OPTIMAL, -36.0),
    Case("feasible MILP", knapsack, Status.OPTIMAL, _best_knapsack()),
    Case("general integers", _general_integers, Status.OPTIMAL, 5.0),
    Case("negative integers", _negative_integers, Status.OPTIMAL, -3.0),
    Case("free columns", _free_columns, Status.OPTIMAL, 5.0),
    Case("fixed columns", _fixed_columns, Status.OPTIMAL, 6.5),
    Case("equality rows", _equalities, Status.OPTIMAL, 6.5),
    Case("two-sided rows", _ranges, Status.OPTIMAL, -7.0),
    Case("offset", _offset, Status.OPTIMAL, 103.25),
    Case("big-M disjunction", _big_m, Status.OPTIMAL, 2.0),
    Case("duplicates add up", _duplicates, Status.OPTIMAL, -4.0),
    Case("infeasible LP", _infeasible_lp, Status.INFEASIBLE),
    Case("infeasible MILP", _infeasible_mip, Status.INFEASIBLE),
    Case("unbounded", _unbounded, Status.UNBOUNDED),
    Case("empty model", _empty, Status.OPTIMAL, 2.0),
    Case("no rows", _rowless, Status.OPTIMAL, -7.5),
    Case("unused columns, empty rows", _unused, Status.OPTIMAL, -2.0),
    Case("time limit", _hard, Status.FEASIBLE, extra=_limit, needs=Capability.TIME_LIMIT),
    Case("start", knapsack, Status.OPTIMAL, extra=_start),
    Case("options honoured or reported", knapsack, Status.OPTIMAL, extra=_options),
    Case("incumbents", knapsack, Status.OPTIMAL, extra=_incumbents, needs=Capability.INCUMBENTS),
    Case("cancel", _hard, Status.FEASIBLE, extra=_cancel, needs=Capability.CANCEL),
)
