"""One disjunction as rows: the alternatives, what each demands, and the shared-face hull.

Alternatives i = 1..k with literals z_i, sum_i z_i = P (the sum of the parent literals, 1 at the
top: exactly one alternative is taken, which loses no run). Alternative i demands a'x >= v_i for
some directions a; a direction that several alternatives share becomes one row

    a'x - s rho  >=  sum_i v_i z_i  +  w (1 - P),     v_i = w where i demands nothing of a,

with w the least value of a'x - s rho over the ranges. Every single big-M row
a'x - s rho >= v_i - (v_i - w)(1 - z_i) is implied by it (v_j >= w), and where all alternatives
share their directions, as the faces of boxes do, it is the convex hull projected on a'x
(Balas, Disjunctive programming, 1979; the aggregation is due to z_i <= 1 = sum z).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stlc.analysis.bounds import value_range
from stlc.analysis.goals import Goal, Level
from stlc.arrays import Floats, Ints
from stlc.errors import MissionError
from stlc.ir.nodes import Linear, Node, Role, Signal, Terms
from stlc.milp.big_m import LARGEST, TooLargeM
from stlc.milp.builder import ModelBuilder
from stlc.milp.context import Context

_TINY = 1e-7  # coefficients below a solver's tolerance only harm


@dataclass(slots=True)
class Alternative:
    """What one disjunct demands: predicates, and nodes that need literals of their own."""

    atoms: dict[Linear, None] = field(default_factory=dict)
    others: dict[Node, None] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Direction:
    """The expression a'x, less s rho where a robustness column has to be reached."""

    terms: Terms
    unit: str
    goal: Goal | None


@dataclass(slots=True)
class RowBlock:
    """Rows collected as triplets, added to the builder in one go."""

    rows: list[Ints] = field(default_factory=list)
    cols: list[Ints] = field(default_factory=list)
    values: list[Floats] = field(default_factory=list)
    lower: list[float] = field(default_factory=list)
    upper: list[float] = field(default_factory=list)

    def add(
        self, cols: Sequence[int], values: Sequence[float], lower: float, upper: float = np.inf
    ) -> None:
        """One row lower <= values @ x[cols] <= upper."""
        self.rows.append(np.full(len(cols), len(self.lower)))
        self.cols.append(np.asarray(cols, dtype=np.int64))
        self.values.append(np.asarray(values, dtype=float))
        self.lower.append(lower)
        self.upper.append(upper)

    def flush(self, builder: ModelBuilder, name: str) -> None:
        """Hand the rows over."""
        if self.lower:
            builder.add_rows(
                name,
                np.concatenate(self.rows),
                np.concatenate(self.cols),
                np.concatenate(self.values),
                np.array(self.lower),
                np.array(self.upper),
                count=len(self.lower),
            )


@dataclass(slots=True)
class Faces:
    """Predicates of one requirement as directions and demands; what encodings write rows with."""

    ctx: Context
    rho: Mapping[Goal, int]
    level: Level
    rows: RowBlock = field(default_factory=RowBlock)
    _least: dict[Direction, float] = field(default_factory=dict)

    def demands(self, predicates: Iterable[Linear]) -> dict[Direction, float]:
        """v for each direction: the predicates hold at their level where a'x - s rho >= v."""
        found: dict[Direction, float] = {}
        for p in predicates:
            asks: list[tuple[Goal | None, float]] = [(g, -p.constant) for g in self.level.goals]
            if self.level.needs_margin(p.unit):
                asks.append((None, self.level.margin - p.constant))
            for goal, demand in asks:
                direction = Direction(p.terms, p.unit, goal)
                found[direction] = max(found.get(direction, -np.inf), demand)
        return found

    def expression(self, direction: Direction) -> tuple[list[int], list[float]]:
        """Columns and coefficients of a'x - s rho."""
        cols = [self.column(signal) for signal, _ in direction.terms]
        values = [value for _, value in direction.terms]
        if direction.goal is not None:
            cols.append(self.rho[direction.goal])
            values.append(-direction.goal.scale(direction.unit))
        return cols, values

    def least(self, direction: Direction) -> float:
        """w: the least value of the expression over the ranges."""
        if direction not in self._least:
            goal = direction.goal
            low = value_range(Linear(direction.terms, 0.0), self.ctx.ranges)[0]
            self._least[direction] = low - (
                0.0 if goal is None else goal.scale(direction.unit) * goal.high
            )
        return self._least[direction]

    def hold(self, predicates: Iterable[Linear]) -> None:
        """The predicates hold."""
        for direction, demand in self.demands(predicates).items():
            self.rows.add(*self.expression(direction), demand)

    def shared(self, literals: Sequence[int], predicates: Sequence[Iterable[Linear]]) -> None:
        """Alternative i holds where literal i is 1, one row for each direction.

        The literals exclude one another; a single one gives the big-M rows of that literal.
        """
        groups: dict[Direction, dict[int, float]] = {}
        for column, own in zip(literals, predicates, strict=True):
            for direction, demand in self.demands(own).items():
                groups.setdefault(direction, {})[int(column)] = demand
        for direction, demanded in groups.items():
            least = self.least(direction)
            binding = {z: v for z, v in demanded.items() if v > least + _TINY}
            if not binding:
                continue
            self.check_size(max(binding.values()) - least, direction.terms)
            cols, values = self.expression(direction)
            values += [least - v for v in binding.values()]
            self.rows.add([*cols, *binding], values, least)

    def check_size(self, big: float, terms: Terms) -> None:
        """MissionError where a predicate's range is too wide for a solver's arithmetic."""
        if big < LARGEST:
            return
        origin = self.ctx.builder.origin
        name = origin.label.removeprefix("require ")
        signals = ", ".join(self._written(signal) for signal, _ in terms)
        raise MissionError([TooLargeM(span=origin.span, name=name, signals=signals, size=big)])

    def _written(self, signal: Signal) -> str:
        """A signal as missions write it."""
        model = self.ctx.agent(signal.owner).dynamics
        names = model.states if signal.role is Role.STATE else model.inputs
        return f"{signal.owner}.{names[signal.index]}"

    def column(self, signal: Signal) -> int:
        """Column of a signal."""
        block = self.ctx.states if signal.role is Role.STATE else self.ctx.inputs
        return int(block[signal.owner][signal.shift, signal.index])

    def interval(self, signal: Signal) -> tuple[float, float]:
        """Range of a signal."""
        return value_range(Linear(((signal, 1.0),), 0.0), self.ctx.ranges)
