"""The compiled model with most disjunctions decided as given runs decide them.

Where runs satisfy a disjunction of predicates on states (a side of an obstacle, of another agent),
the alternative that they satisfy by most is the one that stays; where they don't, all stay. So of
runs of a whole team that nearly get along only what they violate is left to be decided, and what
else they do may move as far as the alternatives allow: a fix-and-solve neighbourhood (as RINS,
Danna, Rothberg, Le Pape, 2005, with the runs in place of a relaxation).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from stlc.ir.nodes import And, Const, Linear, Node, Or
from stlc.milp.compile import Compiled
from stlc.milp.layout import Encoded
from stlc.milp.model import Model
from stlc.solve.alone.run import Run
from stlc.solve.teams.couplings import MISS, value

Alternatives = tuple[tuple[Node, int], ...]


def decided(compiled: Compiled, model: Model, runs: Mapping[str, Run]) -> Model:
    """`model` (the compiled one, or one with narrower bounds) with the sides of the runs."""
    best, others = set[int](), set[int]()
    for encoded in compiled.layout.encoded:
        for alternatives in _satisfied(encoded, runs):
            values = [value(node, runs) for node, _ in alternatives]
            first = int(np.argmax(values))
            best.add(alternatives[first][1])
            others.update(column for k, (_, column) in enumerate(alternatives) if k != first)
    out = np.array(sorted(others - best), np.int64)
    upper = model.col_upper.copy()
    upper[out] = model.col_lower[out]
    return replace(model, col_upper=upper)


def _satisfied(encoded: Encoded, runs: Mapping[str, Run]) -> Iterator[Alternatives]:
    """The alternatives, with their literals, of the disjunctions that the runs satisfy."""
    for node, alternatives in encoded.choices:
        if alternatives and _is_plain(node):
            reached = max(value(alternative, runs) for alternative, _ in alternatives)
            if reached >= encoded.level.margin - MISS:
                yield alternatives


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
