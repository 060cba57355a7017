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
    of all plans); `by_choice`: states of each alternative apart; `reached`: the bound
    before the last ascent; `ascended`: no more ascents."""

    bound: float
    problem: Problem
    taken: Taken
    rows: list[list[Layer]]
    prices: Prices
    masks: dict[Pair, list[Bools]] | None
    by_choice: bool = False
    reached: float = -np.inf
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
    def pairs(self) -> int:
        """Pairs of states of all pairs of agents at all steps."""
        return pairs_of(self.rows, self.prices)

    @property
    def empty(self) -> bool:
        """Whether some agent has nowhere to be, or nothing to take."""
        return not all(self.taken) or any(len(layer) == 0 for row in self.rows for layer in row)


def pairs_of(rows: list[list[Layer]], prices: Prices) -> int:
    """Pairs of states that pairs of agents have at all steps."""
    return sum(
        len(a) * len(b)
        for i, j in prices.states
        for a, b in zip(rows[i], rows[j], strict=True)
    )  # fmt: skip


def alternatives(row: list[Layer], taken: tuple[int, ...]) -> tuple[int, ...]:
    """Those of an agent that have a state left at every step; all where states are of all."""
    if any((layer.x.kind < 0).any() for layer in row[1:]):
        return taken
    return tuple(j for j in taken if all((layer.x.kind == j).any() for layer in row[1:]))


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


def viewed(node: Node, rows: list[list[Layer]], problem: Problem | None = None) -> None:
    """Give a node other layers, whose `parent` numbers its states, on the cells of another problem
    where one is given: then all pairs of states are alive, as a border is in several cells."""
    index = [[layer.parent for layer in row] for row in rows]
    node.rows, node.prices, node.masks = (
        rows, sliced(node.prices, index), masked(node.masks, index),
    )  # fmt: skip
    if problem is not None:
        node.problem = problem
        for row in (node.masks or {}).values():
            for mask in row:
                mask[:] = True
