"""Branch and bound over more than two agents, by what their pairs agree on.

A node is a set of alternatives for each agent's choice over time, with the states and pairs of
states that may still lie on a plan better than the cutoff, and the prices of its parent. Nodes
with few cell pairs go to the solver whole; the others are split by a choice, or by where an agent
is at a step.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from stlc.arrays import Bools, Floats
from stlc.solve import tuning
from stlc.solve.bounders.agreement import Agreement, Pair, no_prices
from stlc.solve.bounders.climb import climb
from stlc.solve.bounders.prices import blocks, prices_of_finer_cells
from stlc.solve.bounders.shares import coarsened
from stlc.solve.bounders.team_node import (
    Node,
    alternatives,
    everything,
    keep,
    kept,
)
from stlc.solve.bounders.views import Views
from stlc.solve.relaxation.borders import taken
from stlc.solve.restricted.session import Session
from stlc.solve.states.layers import cells_of, with_choice
from stlc.solve.states.tubes import tubes
from stlc.solve.tree import Expansion, branch_and_bound

_POINT = 1e-6  # m


class Tree:
    """The nodes of one problem."""

    def __init__(self, session: Session, pool: Executor) -> None:
        self.session, self.problem, self.pool = session, session.problem, pool
        self.frame = session.frame
        self.tubes = [tubes(body, self.problem.steps) for body in self.problem.bodies]
        self.visited = self._plunges = 0  # nodes; as of which plans are looked for again
        agents = range(len(self.problem.bodies))
        self._free = itertools.cycle(itertools.combinations(agents, 2))
        self._polished = np.inf
        self.views = Views(session, self.tubes, pool)

    def run(self) -> None:
        """Best bound first, until the incumbent is proven or the session stops."""
        root = self.root()
        if root is not None:
            branch_and_bound(self, root, self.session)

    def root(self) -> Node | None:
        """All alternatives; None where an agent has none. Prices are found on merged cells."""
        taken = tuple(t.possible for t in self.tubes)
        if not all(taken):
            return None
        coarse = coarsened(self.problem, tuning.TEAM.coarse_cells)
        rows = self.views.layers(coarse, taken)
        node = Node(-np.inf, coarse, taken, rows, no_prices(list(coarse.pairs), rows), None)
        if node.empty:
            return node
        if coarse is self.problem:
            if node.size <= tuning.TEAM.border_states:
                self.views.with_borders(node)
            return node
        self._tighten(node, tuning.TEAM.coarse_rounds, np.inf)
        fine = self.views.layers(self.problem, taken)
        host = blocks(self.problem, coarse)
        prices = prices_of_finer_cells(node.prices, node.rows, fine, host)
        return Node(node.bound, self.problem, taken, fine, prices, None)

    # -- nodes --------------------------------------------------------------------------------
    def expand(self, node: Node) -> Expansion[Node]:
        """Tighten; close what is settled, give small nodes to the solver, split the rest."""
        session, first = self.session, node.masks is None
        session.nodes, self.visited = session.nodes + 1, self.visited + 1
        rounds = tuning.TEAM.root_rounds if first else tuning.TEAM.rounds
        agreement = self._tighten(node, rounds, session.cutoff)
        if agreement is None:
            return Expansion(closed=max(node.bound, session.cutoff))
        if session.stopped():
            return Expansion((node,))
        if self.views.split(node):
            return Expansion((node,))
        leaf = not node.tried and self._count(node) <= (
            tuning.TEAM.open_leaf_pairs if node.has_open_choice else tuning.TEAM.leaf_pairs
        )
        if not leaf and self.views.ascend(node):
            return Expansion((node,))
        if leaf:
            node.bound = max(node.bound, self._solve(node, tuning.TEAM.leaf_seconds))
            if node.bound >= session.cutoff:
                return Expansion(closed=node.bound)
            node.tried = True
        elif self.visited >= self._plunges:
            self._plunges = self.visited + tuning.TEAM.plunge_every
            if not (node.by_choice and node.has_open_choice):
                self._plunge(node, agreement)
            self._polish()
        return self._branch(node, agreement)

    def _tighten(self, node: Node, rounds: int, cutoff: float) -> Agreement | None:
        """Climb at a node and keep what is alive; None when nothing below the cutoff is left."""
        if node.empty:
            node.bound = np.inf
            return None
        whole = node.masks is None and all(
            t.possible == own for t, own in zip(self.tubes, node.taken, strict=True)
        )
        agreement = Agreement(node.problem, node.rows, node.prices, node.masks, self.pool)
        climb(agreement, rounds, self.session, cutoff, whole)
        node.bound = max(node.bound, agreement.bound)
        if node.bound >= cutoff:
            return None
        node.prices, node.masks = agreement.prices, agreement.masks()
        keep(node, [[np.flatnonzero(a) for a in row] for row in agreement.alive()])
        node.taken = tuple(alternatives(*v) for v in zip(node.rows, node.taken, strict=True))
        return None if node.empty else agreement

    def _alive_cells(self, node: Node) -> dict[Pair, list[Bools]]:
        """Cell pairs (cells, cells) at each step, those taken where borders are cells."""
        assert node.masks is not None
        found = {
            p: [
                cells_of(mask, node.rows[p[0]][t], node.rows[p[1]][t], node.problem.cells)
                for t, mask in enumerate(masks)
            ]
            for p, masks in node.masks.items()
        }
        if not node.problem.borders:
            return found
        return {p: [taken(v, self.problem.shape) for v in row] for p, row in found.items()}

    def _count(self, node: Node) -> int:
        return sum(int(v.sum()) for row in self._alive_cells(node).values() for v in row[1:])

    def _solve(self, node: Node, seconds: float) -> float:
        """Give the node to the solver; its bound."""
        cells, by_table = self._alive_cells(node), node.problem.borders
        lower, upper = self.frame.narrowed(node.taken, node.rows, cells, by_table)
        return self.session.milp(lower, upper, seconds, 0.5 * self.session.options.gap)

    # -- plans --------------------------------------------------------------------------------
    def _plunge(self, node: Node, agreement: Agreement) -> None:
        """Take every choice as the pairs' best runs do, and solve over what would be left were
        the incumbent better than it is."""
        part = node
        for n, own in enumerate(node.taken):
            if len(own) > 1:
                part = self._child(part, n, (self._taken_by(n, agreement, own),))
        part = replace(part, rows=list(part.rows))
        session = self.session
        top = min(session.cutoff, node.bound + abs(node.bound) + 1.0)
        if self._tighten(part, tuning.TEAM.rounds, top) is None:
            return
        parts, left = [part], self._count(part)
        while left > tuning.TEAM.dive_pairs and not session.stopped():
            part, before = replace(part, rows=list(part.rows)), left
            top = part.bound + tuning.TEAM.plunge_cut * (top - part.bound)
            if self._tighten(part, 2, top) is None:
                break
            parts, left = [*parts, part], self._count(part)
            if left > tuning.TEAM.plunge_least * before:
                return  # so near to the bound nothing is dropped any more
        value, until = session.value, session.seconds + tuning.TEAM.dive_seconds
        for part in reversed(parts):
            if session.value < value or session.seconds > until or session.stopped():
                return
            self._solve(part, tuning.TEAM.dive_seconds)

    def _polish(self) -> None:
        """Free two agents at a time around the incumbent, until all pairs bring nothing."""
        session = self.session
        moment = session.deadline.share(tuning.TEAM.polish_share, tuning.TEAM.dive_seconds)
        cell = min(float(np.diff(e).max()) for e in self.problem.edges)
        agents = len(self.problem.bodies)
        idle = 0
        while session.x is not None and not moment.over():
            if session.value >= self._polished or idle == agents * (agents - 1) // 2:
                self._polished = session.value
                return
            better = session.around(
                next(self._free), 0.7 * cell, tuning.TEAM.dive_seconds / 2, 1e-3
            )
            idle = 0 if better else idle + 1

    def _taken_by(self, n: int, agreement: Agreement, own: tuple[int, ...]) -> int:
        """The alternative that most of an agent's pairs take."""
        steps = [self.tubes[n].steps[j] for j in own]
        votes = np.zeros(len(own))
        for pair in agreement.own[n]:
            path, end = agreement.path(pair), int(pair[1] == n)
            bits = [agreement.rows[n][t].bit[k[end]] for t, k in enumerate(path)]
            votes += np.array([bits.index(1) == step for step in steps])
        return own[int(np.argmax(votes))]

    # -- branching ----------------------------------------------------------------------------
    def _branch(self, node: Node, agreement: Agreement) -> Expansion[Node]:
        """Split by choices, or where an agent is at some step."""
        if not node.has_open_choice:
            return self._halves(node)
        if node.by_choice:
            return Expansion(tuple(self._by_best(node, agreement)))
        n = int(np.argmax([len(t) for t in node.taken]))
        own = node.taken[n]
        half = len(own) // 2
        return Expansion(tuple(self._child(node, n, part) for part in (own[:half], own[half:])))

    def _by_best(self, node: Node, agreement: Agreement) -> Iterator[Node]:
        """For each agent what is left without its best alternative while those before it take
        theirs, bounded by its runs; at last all of them take it."""
        order, least = [], [self._least(agreement, n) for n in range(len(node.taken))]
        for n, own in enumerate(node.taken):
            first, *others = sorted(own, key=least[n].__getitem__)
            if others:
                order.append((least[n][others[0]], n, first))
        for bound, n, first in sorted(order, reverse=True):
            left = self._child(node, n, tuple(j for j in node.taken[n] if j != first))
            left.bound = max(left.bound, bound)
            yield left
            node = self._child(node, n, (first,))
        yield node

    def _least(self, agreement: Agreement, n: int) -> Floats:
        """Bounds of the plans in which an agent takes each alternative."""
        last = agreement.rows[n][-1]
        return agreement.least_by(n, last.x.kind[last.ix])

    def _child(self, node: Node, n: int, part: tuple[int, ...]) -> Node:
        index = everything(node)
        row, index[n] = with_choice(self.problem.bodies[n], self.tubes[n], part, node.rows[n])
        taken = tuple(part if k == n else t for k, t in enumerate(node.taken))
        child = kept(replace(node, taken=taken, tried=False), index)
        child.rows[n], child.ascended, child.reached = row, child.has_open_choice, -np.inf
        return child

    def _halves(self, node: Node) -> Expansion[Node]:
        """Split the widest spread of an agent's positions along an axis."""
        spread = [
            (float(np.ptp(at)), n, t, at)
            for n, row in enumerate(node.rows)
            for t, layer in enumerate(row)
            for at in (layer.x.box[layer.ix, :2].mean(1), layer.y.box[layer.iy, :2].mean(1))
        ]
        widest, n, t, at = max(spread, key=lambda s: s[0])
        if widest < _POINT:
            return Expansion(closed=max(node.bound, self._solve(node, self.session.left)))
        middle = (at.min() + at.max()) / 2
        out = []
        for side in (at <= middle, at > middle):
            index = everything(node)
            index[n][t] = np.flatnonzero(side)
            out.append(kept(replace(node, tried=False, ascended=False), index))
        return Expansion(tuple(out))
