"""Nodes of the search over more than two agents."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stlc.arrays import Bools, Ints
from stlc.solve.bounders.agreement import Pair, Prices
from stlc.solve.bounders.prices import masked, sliced
from stlc.solve.relaxation.problem import Problem
from stlc.solve.states.layers import Layer, restrict

Taken = tuple[tuple[int, ...], ...]


@dataclass(slots=True)
class Node:
    """rows[agent][t] over the cells of `problem`; masks[pair][t]: alive pairs of states (None: all
    of all plans); `ascended`: had its ascent, or is a part."""

    bound: float
    problem: Problem
    taken: Taken
    rows: list[list[Layer]]
    prices: Prices
    masks: dict[Pair, list[Bools]] | None
    bins: int = 1
    tried: bool = False
    ascended: bool = False

    @property
    def has_open_choice(self) -> bool:
        """Whether some choice is open."""
        return max(map(len, self.taken)) > 1

    @property
    def size(self) -> int:
        """Most pairs of states that two agents have at a step."""
        return max(
            len(self.rows[i][t]) * len(self.rows[j][t])
            for i, j in self.prices.states
            for t in range(len(self.rows[i]))
        )

    @property
    def empty(self) -> bool:
        """Whether some agent has nowhere to be."""
        return any(len(layer) == 0 for row in self.rows for layer in row)


def everything(node: Node) -> list[list[Ints]]:
    """All states of each agent and step, for `keep`."""
    return [[np.arange(len(layer)) for layer in row] for row in node.rows]


def keep(node: Node, index: list[list[Ints]]) -> None:
    """Only some states of each agent and step."""
    for n, row in enumerate(node.rows):
        masks = [np.zeros(len(layer), bool) for layer in row]
        for mask, kept in zip(masks, index[n], strict=True):
            mask[kept] = True
        node.rows[n] = [restrict(layer, m) for layer, m in zip(row, masks, strict=True)]
    node.prices, node.masks = sliced(node.prices, index), masked(node.masks, index)


def kept(node: Node, index: list[list[Ints]]) -> Node:
    """`keep` of a node whose lists of rows are another's."""
    node.rows = [list(row) for row in node.rows]
    keep(node, index)
    return node
