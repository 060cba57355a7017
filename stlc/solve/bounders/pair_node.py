"""Nodes of the search over two agents, and their parts."""

from __future__ import annotations

from dataclasses import dataclass

from stlc.arrays import Bools
from stlc.solve.bounders.cuts import Cut, along
from stlc.solve.relaxation.problem import Body, Problem
from stlc.solve.states.layers import Layer, restrict, with_choice
from stlc.solve.states.tubes import Tubes

Rows = tuple[list[Layer], list[Layer]]
Taken = tuple[tuple[int, ...], tuple[int, ...]]


@dataclass(slots=True)
class Node:
    """masks[t]: alive pairs of states (None: all); pairs[t] (cells, cells): alive cell pairs;
    cut: where to split it when no choice is left."""

    bound: float
    layers: Rows
    taken: Taken
    masks: list[Bools] | None
    pairs: list[Bools] | None = None
    cut: Cut | None = None
    depth: int = 0
    priced: bool = False

    @property
    def count(self) -> int:
        """Alive cell pairs."""
        return 10**9 if self.pairs is None else sum(int(p.sum()) for p in self.pairs[1:])

    @property
    def pairs_of_states(self) -> int:
        """Alive pairs of states."""
        return 10**9 if self.masks is None else sum(int(m.sum()) for m in self.masks)

    @property
    def has_open_choice(self) -> bool:
        """Whether some choice is open."""
        return max(map(len, self.taken)) > 1


def with_part(node: Node, n: int, part: tuple[int, ...], body: Body, tubes: Tubes) -> Node:
    """The node with agent n's alternatives narrowed to `part`."""
    assert node.masks is not None
    row, kept = with_choice(body, tubes, part, node.layers[n])
    masks = [m[k] if n == 0 else m[:, k] for m, k in zip(node.masks, kept, strict=True)]
    taken = (part, node.taken[1]) if n == 0 else (node.taken[0], part)
    return _child(node, n, row, taken, masks)


def with_cut(problem: Problem, node: Node, first: bool) -> Node:
    """The first or second part of the node's cut."""
    assert node.masks is not None
    assert node.cut is not None
    n, t, d, last = node.cut
    row, masks = list(node.layers[n]), list(node.masks)
    keep = (along(problem, row[t].cell, d) <= last) == first
    row[t] = restrict(row[t], keep)
    masks[t] = masks[t][keep] if n == 0 else masks[t][:, keep]
    return _child(node, n, row, node.taken, masks)


def _child(node: Node, n: int, row: list[Layer], taken: Taken, masks: list[Bools]) -> Node:
    rows = (row, node.layers[1]) if n == 0 else (node.layers[0], row)
    return Node(node.bound, rows, taken, masks, depth=node.depth + 1, priced=node.priced)
