"""The convex hull of a disjunction of polytopes, by copies of its variables.

Alternatives P_i = {y : A_i y >= b_i}, y the signals and robustness columns they speak of, within
l <= y <= u. With literals sum_i z_i = P <= 1 and one copy y^i for each alternative,

    A_i y^i >= b_i z_i,    l z_i <= y^i <= u z_i,
    y - sum_i y^i  in  [l, u] (1 - P),             y = sum_i y^i where P = 1 always,

is the convex hull of the union (Balas, Disjunctive programming: properties of the convex hull of
feasible points, 1998): integral z gives y in the chosen P_i, and no relaxation of one disjunction
is tighter. It costs k copies of every variable, so it pays for few alternatives of few variables
whose faces have different directions; faces that alternatives share are exact already in
`choice.py`, without copies.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.ir.nodes import Linear
from stlc.milp.builder import ModelBuilder
from stlc.milp.formulas.choice import Direction, Faces
from stlc.milp.layout import Literals


class Hull:
    """Convex hull by copies of the variables (Balas)."""

    name: ClassVar[str] = "hull"

    def literals(self, builder: ModelBuilder, size: int) -> Literals:
        """One binary for each alternative."""
        return Literals(builder.binary("z", (size,)))

    def add_rows(
        self,
        faces: Faces,
        literals: Ints,
        predicates: Sequence[Sequence[Linear]],
        parents: Sequence[int],
    ) -> None:
        """Copies, their bounds and the faces over them."""
        demands = [faces.demands(own) for own in predicates]
        cols, lower, upper = _variables(faces, demands)
        shape = (len(literals), len(cols))
        copies = np.empty(shape, np.int64)  # constants alone need none, and have a demand too
        if len(cols):
            copies = faces.ctx.builder.add_columns(
                "copy", shape, np.minimum(lower, 0.0), np.maximum(upper, 0.0)
            )
        place = {int(c): k for k, c in enumerate(cols)}
        for z, own, copy in zip(literals, demands, copies, strict=True):
            for direction, demand in own.items():
                used, values = faces.expression(direction)
                faces.rows.add([*(copy[place[c]] for c in used), z], [*values, -demand], 0.0)
        _add_bounds(faces, literals, copies, lower, upper)
        _add_sums(faces, literals, copies, (cols, lower, upper), bool(parents))


def _variables(
    faces: Faces, demands: Sequence[dict[Direction, float]]
) -> tuple[Ints, Floats, Floats]:
    """Columns that the alternatives speak of, with their ranges."""
    found: dict[int, tuple[float, float]] = {}
    for direction in dict.fromkeys(d for own in demands for d in own):
        for signal, _ in direction.terms:
            low, high = faces.interval(signal)
            faces.check_size(high - low, direction.terms)
            found[faces.column(signal)] = (low, high)
        if direction.goal is not None:
            found[faces.rho[direction.goal]] = (direction.goal.low, direction.goal.high)
    ends = np.array(list(found.values()), dtype=float).reshape(-1, 2)
    return np.array(list(found), np.int64), ends[:, 0], ends[:, 1]


def _add_bounds(faces: Faces, z: Ints, copies: Ints, lower: Floats, upper: Floats) -> None:
    """l z_i <= y^i <= u z_i, left out where the copy's own bound says it."""
    for literal, row in zip(z, copies, strict=True):
        for copy, low, high in zip(row, lower, upper, strict=True):
            if low != 0.0:
                faces.rows.add([copy, literal], [1.0, -low], 0.0)
            if high != 0.0:
                faces.rows.add([copy, literal], [-1.0, high], 0.0)


def _add_sums(
    faces: Faces,
    z: Ints,
    copies: Ints,
    variables: tuple[Ints, Floats, Floats],
    optional: bool,
) -> None:
    """y = sum of its copies; below parents the rest lies in [l, u] (1 - sum z)."""
    for k, (col, low, high) in enumerate(zip(*variables, strict=True)):
        cols, minus = [col, *copies[:, k]], [-1.0] * len(z)
        if not optional:
            faces.rows.add(cols, [1.0, *minus], 0.0, 0.0)
            continue
        faces.rows.add([*cols, *z], [1.0, *minus, *np.full(len(z), low)], low)
        faces.rows.add([*cols, *z], [1.0, *minus, *np.full(len(z), high)], -np.inf, high)
