"""The compiled model with most disjunctions decided as given runs decide them.

Where runs satisfy a disjunction of predicates on states (a side of an obstacle, of another agent),
the alternative that they satisfy by most is the one that stays; where they don't, all stay. So of
runs of a whole team that nearly get along only what they violate is left to be decided, and what
else they do may move as far as the alternatives allow: a fix-and-solve neighbourhood (as RINS,
Danna, Rothberg, Le Pape, 2005, with the runs in place of a relaxation).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stlc.arrays import Ints
from stlc.ir.nodes import And, Const, Linear, Node, Or
from stlc.milp.compile import Compiled
from stlc.milp.model import Model
from stlc.solve.alone.run import Run
from stlc.solve.teams.couplings import MISS, value


def left_out(compiled: Compiled, runs: Mapping[str, Run]) -> Ints:
    """Columns (k,) of the alternatives that the runs leave: what decides their sides is that these
    are 0 (`decided`)."""
    best, others = set[int](), set[int]()
    for encoded in compiled.layout.encoded:
        for node, alternatives in encoded.choices:
            if not alternatives or not _is_plain(node):
                continue
            values = [value(alternative, runs) for alternative, _ in alternatives]
            first = int(np.argmax(values))
            if values[first] >= encoded.level.margin - MISS:
                best.add(alternatives[first][1])
                others.update(column for k, (_, column) in enumerate(alternatives) if k != first)
    return np.array(sorted(others - best), np.int64)


def decided(model: Model, columns: Ints) -> Model:
    """A model, of narrower bounds maybe, without these alternatives."""
    upper = model.col_upper.copy()
    upper[columns] = model.col_lower[columns]
    return replace(model, col_upper=upper)


def _is_plain(node: Node) -> bool:
    """Whether a formula has nothing but predicates on states and inputs."""
    todo = [node]
    while todo:
        part = todo.pop()
        if isinstance(part, And | Or):
            todo.extend(part.args)
        elif not isinstance(part, Const | Linear):
            return False
    return True
