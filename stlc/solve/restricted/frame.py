"""The compiled model with bounds drawn in: all that the relaxation has ruled out is fixed.

Whatever the relaxation does not know stays in the model, so a restricted model holds exactly the
plans of the mission that lie within the bounds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.milp.compile import Compiled
from stlc.milp.model import Model
from stlc.solve.relaxation.link_costs import Touching
from stlc.solve.relaxation.problem import Problem
from stlc.solve.restricted.free_choices import fix_free_choices, groups_of
from stlc.solve.states.layers import Layer

_SLACK = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Reduced:
    """`model` over the columns `kept` of the full model; the others have the values `fixed`."""

    model: Model
    kept: Ints
    fixed: Floats
    rows: Ints  # of the full model; the cutoff row, if any, comes after them

    def lift(self, x: Floats) -> Floats:
        """A point of the full model."""
        full = self.fixed.copy()
        full[self.kept] = x
        return full


@dataclass(frozen=True, slots=True, eq=False)
class PairBlock:
    """Pair columns (k, l) at a step: of `cells` of both bodies, numbered as the problem's.

    `beside`: ends whose cell may be another than the state's, on a border.
    """

    step: int
    cells: tuple[Ints, Ints]
    columns: Ints
    beside: tuple[bool, bool]


class Frame:
    """A compiled model and where the parts of the problem stand in it."""

    def __init__(self, compiled: Compiled, problem: Problem) -> None:
        self.compiled, self.problem, self.model = compiled, problem, compiled.model
        self._csc = compiled.model.A.tocsc()
        self.blocks = self._pair_blocks()
        self._touching = Touching.of(np.frombuffer(problem.key).reshape(-1, 4))
        self._groups = groups_of(compiled, self._csc)
        self.dynamics = [compiled.layout.dynamics[b.name] for b in problem.bodies]

    def _pair_blocks(self) -> Mapping[tuple[int, int], tuple[PairBlock, ...]]:
        """The model's cell-pair columns by agents (numbered as bodies, in order), from receipts."""
        index = {b.name: i for i, b in enumerate(self.problem.bodies)}
        found: dict[tuple[int, int], list[PairBlock]] = {}
        for made in self.compiled.layout.pairs:
            if made.partition != self.problem.key or any(e not in index for e in made.ends):
                continue
            ends = (index[made.ends[0]], index[made.ends[1]])
            cells, columns, beside = made.cells, made.columns, made.beside
            if ends[0] > ends[1]:
                ends, cells, columns, beside = ends[::-1], cells[::-1], columns.T, beside[::-1]
            found.setdefault(ends, []).append(PairBlock(made.step, cells, columns, beside))
        return {k: tuple(v) for k, v in found.items()}

    def bounds(self) -> tuple[Floats, Floats]:
        """Copies of the model's column bounds."""
        return self.model.col_lower.copy(), self.model.col_upper.copy()

    def confine(self, lower: Floats, upper: Floats, agent: int, t: int, box: Floats) -> None:
        """Draw in position and rate of an agent at a step; box (2, 4) as in `Layer.bounds`."""
        body = self.problem.bodies[agent]
        states = self.compiled.states[body.name][t]
        for axis, (p_lo, p_hi, w_lo, w_hi) in zip(body.axes, box, strict=True):
            _draw_in(lower, upper, int(states[axis.state]), p_lo, p_hi)
            if axis.speed is not None:
                ends = (w_lo / axis.gain, w_hi / axis.gain)
                _draw_in(lower, upper, int(states[axis.speed]), *ends)

    def choose(self, upper: Floats, agent: int, taken: Sequence[int]) -> None:
        """Rule out all alternatives of an agent's choice but those taken."""
        for j, place in enumerate(self.problem.bodies[agent].places):
            if j not in taken:
                upper[place.column] = 0.0

    def keep_pairs(
        self, upper: Floats, pair: tuple[int, int], alive: Sequence[Bools], taken: bool = False
    ) -> None:
        """Rule out pair columns; alive[t] is (n, n) over the problem's cells, for t = 0..T: cells
        that agents are in, or (`taken`) that tables may take."""
        for block in self.blocks.get(pair, ()):
            live = self._on_partition(alive[block.step])
            if any(block.beside) and not taken:
                live = self._touching.around(live, block.beside)
            dead = ~live[np.ix_(*block.cells)]
            upper[block.columns[dead]] = 0.0

    def _on_partition(self, alive: Bools) -> Bools:
        owner = self.problem.owner
        count = int(owner.max()) + 1
        if np.array_equal(owner, np.arange(count)):
            return alive
        i, j = np.nonzero(alive)
        out = np.zeros((count, count), bool)
        out[owner[i], owner[j]] = True
        return out

    def narrowed(
        self, taken: Sequence[Sequence[int]], rows: Sequence[Sequence[Layer]],
        alive: Mapping[tuple[int, int], Sequence[Bools]], taken_cells: bool = False,
    ) -> tuple[Floats, Floats]:  # fmt: skip
        """Column bounds with each agent's alternatives, layers 0..T and cell pairs drawn in; see
        `keep_pairs`."""
        lower, upper = self.bounds()
        for n, row in enumerate(rows):
            self.choose(upper, n, taken[n])
            for t, layer in enumerate(row[1:], start=1):
                self.confine(lower, upper, n, t, layer.bounds())
        for pair, cells in alive.items():
            self.keep_pairs(upper, pair, cells, taken_cells)
        return lower, upper

    def reduce(self, lower: Floats, upper: Floats, cutoff: float = np.inf) -> Reduced | None:
        """Without fixed columns and empty rows, with objective <= cutoff; None if infeasible."""
        model = self.model
        if (lower > upper + _SLACK).any():
            return None
        upper = np.maximum(lower, upper)
        fix_free_choices(model, self._groups, lower, upper)
        kept = np.flatnonzero(upper > lower)
        gone = upper <= lower
        fixed = np.where(gone, lower, 0.0)
        part = self._csc[:, kept].tocsr()
        shift = model.A @ fixed if fixed.any() else np.zeros(model.rows)
        row_lower, row_upper = model.row_lower - shift, model.row_upper - shift
        filled = np.diff(part.indptr) > 0
        if ((row_lower > _SLACK) | (row_upper < -_SLACK))[~filled].any():
            return None
        rows = np.flatnonzero(filled)
        part, row_lower, row_upper = part[rows], row_lower[rows], row_upper[rows]
        c, offset = model.c[kept], model.offset + float(model.c @ fixed)
        if np.isfinite(cutoff):
            part, row_lower, row_upper = _with_row(part, c, row_lower, row_upper, cutoff - offset)
        return Reduced(
            replace(
                model, c=c, offset=offset, A=part, row_lower=row_lower, row_upper=row_upper,
                col_lower=lower[kept], col_upper=upper[kept],
                integrality=model.integrality[kept], col_blocks=(), row_blocks=(),
            ),
            kept, fixed, rows,
        )  # fmt: skip


def _draw_in(lower: Floats, upper: Floats, column: int, low: float, high: float) -> None:
    lower[column] = max(lower[column], low)
    upper[column] = min(upper[column], high)
    if upper[column] < lower[column] <= upper[column] + _SLACK:
        upper[column] = lower[column]


def _with_row(
    part: Any, c: Floats, row_lower: Floats, row_upper: Floats, limit: float
) -> tuple[Any, Floats, Floats]:
    from scipy.sparse import csr_matrix, vstack

    part = vstack([part, csr_matrix(c[None, :])], format="csr")
    part.eliminate_zeros()
    return part, np.append(row_lower, -np.inf), np.append(row_upper, limit)


@dataclass(frozen=True, slots=True, eq=False)
class Relaxed:
    """LP relaxation over the full model's rows and columns. value inf: infeasible.

    duals (m,), reduced (n,) costs and the point x (n,); zero where dropped.
    """

    value: float
    duals: Floats
    reduced: Floats
    x: Floats


def relax(frame: Frame, reduced: Reduced, seconds: float) -> Relaxed | None:
    """Solve the LP relaxation with HiGHS; None when it ended otherwise than solved."""
    import highspy

    h = _solved(reduced.model, seconds)
    n, m = frame.model.columns, frame.model.rows
    duals, costs, x = np.zeros(m), np.zeros(n), reduced.fixed.copy()
    status = h.getModelStatus()
    if status == highspy.HighsModelStatus.kInfeasible:
        return Relaxed(np.inf, duals, costs, x)
    if status != highspy.HighsModelStatus.kOptimal:
        return None
    solution = h.getSolution()
    duals[reduced.rows] = np.array(solution.row_dual)[: len(reduced.rows)]
    costs[reduced.kept] = np.array(solution.col_dual)
    x[reduced.kept] = np.array(solution.col_value)
    return Relaxed(h.getInfo().objective_function_value, duals, costs, x)


def _solved(model: Model, seconds: float) -> Any:
    """HiGHS after it has solved the LP relaxation, within so many seconds."""
    import highspy

    from stlc.backends.highs_session import SCHEDULER, new_highs

    h, A = new_highs(), model.A
    h.setOptionValue("time_limit", max(0.1, seconds))
    h.passModel(
        model.columns, model.rows, A.nnz, int(highspy.MatrixFormat.kRowwise),
        int(highspy.ObjSense.kMinimize), model.offset, model.c, model.col_lower, model.col_upper,
        model.row_lower, model.row_upper, A.indptr.astype(np.int32), A.indices.astype(np.int32),
        A.data, np.zeros(model.columns, np.int32),
    )  # fmt: skip
    with SCHEDULER.claim() as threads:
        h.setOptionValue("threads", threads)
        h.run()
    return h


def potentials(frame: Frame, bodies: Sequence[int], duals: Floats) -> Floats:
    """pi (bodies, T+1, 2, 2): pi_t = A' y_{t+1} from the duals of the dynamics rows."""
    problem = frame.problem
    pi = np.zeros((len(bodies), problem.steps + 1, 2, 2))
    for k, i in enumerate(bodies):
        body = problem.bodies[i]
        y = duals[frame.dynamics[i]][1:]
        for d, axis in enumerate(body.axes):
            pi[k, 1 : problem.steps, d, 0] = y[:, axis.state]
            if axis.speed is not None:
                pi[k, 1 : problem.steps, d, 1] = y[:, axis.state] + y[:, axis.speed] / axis.gain
    return pi
