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

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from stlc.ir.nodes import Linear, Node, Signal
from stlc.milp.builder import ModelBuilder
from stlc.milp.model import Floats, Ints

Terms = tuple[tuple[Signal, float], ...]


@dataclass(slots=True)
class Alternative:
    """What one disjunct demands: predicates, and nodes that need literals of their own."""

    atoms: dict[Linear, None] = field(default_factory=dict)
    others: dict[Node, None] = field(default_factory=dict)


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
