"""A first plan before branch and bound: alternating between a run and its best alternatives.

With every literal fixed the model is an LP. Its robustness column is held at its static upper bound
and the rows of the requirements are made elastic,

    minimise the sum of violations   over runs, the chosen alternatives given,      (one LP)
    choose the most robust alternatives   at that run,                              (one evaluation)

in turn; neither step can make the sum larger. Zero proves the plan optimal for the robustness;
otherwise the chosen alternatives give one more LP with the real objective, and a feasible point of
it is the MIP start. (Coordinate descent on the bilinear form of the disjunctions; feasibility pump
of Fischetti, Glover and Lodi, 2005, with the formula's own rounding.)
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stlc.ir.nodes import And, Const, Linear, Node, Or, Role
from stlc.ir.rewrite import postorder
from stlc.milp.compile import Compiled
from stlc.milp.formula import Encoded
from stlc.milp.model import Floats, Ints, Model

_ROUNDS = 30
_ZERO = 1e-7


def find_start(compiled: Compiled) -> Floats | None:
    """A feasible point (n,) of the model, or None.

    None too where integer columns other than the formulas' literals decide (links, integer
    inputs), or where nothing maximises robustness.
    """
    search = _Search.of(compiled)
    return None if search is None else search.run()


@dataclass(slots=True, eq=False)
class _Judge:
    """Evaluates one requirement's formula at a point."""

    encoded: Encoded
    order: list[Node]
    place: dict[Node, int]
    atoms: list[tuple[int, Ints, Floats, float]]

    @staticmethod
    def of(encoded: Encoded, compiled: Compiled) -> _Judge:
        """Compile the formula into index lists."""
        order = list(postorder([encoded.formula]))
        place = {node: k for k, node in enumerate(order)}
        atoms = [
            (place[node], *_row(node, compiled)) for node in order if isinstance(node, Linear)
        ]
        return _Judge(encoded, order, place, atoms)

    def values(self, x: Floats) -> list[float]:
        """Robustness of every node."""
        found = [np.inf] * len(self.order)
        for k, cols, values, constant in self.atoms:
            found[k] = float(values @ x[cols]) + constant
        for k, node in enumerate(self.order):
            if isinstance(node, And):
                found[k] = min([found[self.place[c]] for c in node.args], default=np.inf)
            elif isinstance(node, Or):
                found[k] = max([found[self.place[c]] for c in node.args], default=-np.inf)
            elif isinstance(node, Const):
                found[k] = np.inf if node.value else -np.inf
        return found

    def active(self, values: Sequence[float], bias: Mapping[Node, float]) -> set[Node]:
        """Nodes that are relied upon when every disjunction takes its best alternative."""
        seen: set[Node] = set()
        todo: list[Node] = [self.encoded.formula]
        while todo:
            node = todo.pop()
            if node in seen:
                continue
            seen.add(node)
            if isinstance(node, Or):
                todo.append(
                    max(node.args, key=lambda c: values[self.place[c]] - bias.get(c, 0.0))
                )
            elif isinstance(node, And):
                todo.extend(node.args)
        return seen


def _row(node: Linear, compiled: Compiled) -> tuple[Ints, Floats, float]:
    cols = [
        (compiled.states if s.role is Role.STATE else compiled.inputs)[s.owner][s.shift, s.index]
        for s, _ in node.terms
    ]
    return np.array(cols, np.int64), np.array([v for _, v in node.terms]), node.constant
