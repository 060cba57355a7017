"""Branch and bound over more than two agents, by what their pairs agree on.

A node is a set of alternatives for each agent's choice over time, with the states and pairs of
states that may still lie on a plan better than the cutoff, and the prices of its parent. Nodes
with few cell pairs go to the solver whole; the others are split by a choice, or by where an agent
is at a step.
"""

from __future__ import annotations

import itertools
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from stlc.arrays import Bools
from stlc.solve import tuning
from stlc.solve.bounders.agreement import Agreement, Pair, no_prices
from stlc.solve.bounders.climb import climb
from stlc.solve.bounders.prices import blocks, masked, prices_of_finer_cells, sliced
from stlc.solve.bounders.shares import coarsened
from stlc.solve.bounders.team_ascent import TeamAscent
from stlc.solve.bounders.team_node import Node, Taken, everything, keep, kept
from stlc.solve.relaxation.borders import taken
from stlc.solve.relaxation.problem import Problem
from stlc.solve.relaxation.recognise import recognise
from stlc.solve.restricted.session import Session
from stlc.solve.states.layers import Layer, Maker, cells_of, rate_borders, with_choice
from stlc.solve.states.tubes import tubes
from stlc.solve.tree import Expansion, branch_and_bound

_POINT = 1e-6  # m


class Tree:
    """The nodes of one problem."""

    def __init__(self, session: Session, pool: Executor) -> None:
        self.session, self.problem, self.pool = session, session.problem, pool
        self.frame = session.frame
        self.tubes = [tubes(body, self.problem.steps) for body in self.problem.bodies]
        self.visited = 0
        agents = range(len(self.problem.bodies))
        self._free = itertools.cycle(itertools.combinations(agents, 2))
        self._polished = np.inf
        self._bordered: Problem | None = None

    def run(self) -> None:
        """Best bound first, until the incumbent is proven or the session stops."""
        self._polish()
        root = self.root()
        if root is not None:
            branch_and_bound(self, root, self.session)

    def root(self) -> Node | None:
        """All alternatives; None where an agent has none. Prices are found on merged cells."""
        taken = tuple(t.possible for t in self.tubes)
        if not all(taken):
            return None
        coarse = coarsened(self.problem, tuning.TEAM.coarse_cells)
        rows = self._layers(coarse, taken, 1)
        node = Node(-np.inf, coarse, taken, rows, no_prices(list(coarse.pairs), rows), None)
        if node.empty:
            return node
        if coarse is self.problem:
            return self._with_borders(node) if node.size <= tuning.TEAM.border_states else node
        self._tighten(node, tuning.TEAM.coarse_rounds, np.inf)
        fine = self._layers(self.problem, taken, 1)
        host = blocks(self.problem, coarse)
        prices = prices_of_finer_cells(node.prices, node.rows, fine, host)
        return Node(node.bound, self.problem, taken, fine, prices, None)

    def _layers(self, problem: Problem, taken: Taken, bins: int) -> list[list[Layer]]:
        return [self._maker(problem, n, part, bins).layers() for n, part in enumerate(taken)]

    def _maker(self, problem: Problem, n: int, taken: tuple[int, ...], bins: int) -> Maker:
        body = problem.bodies[n]
        rates = (rate_borders(body.axes[0], bins), rate_borders(body.axes[1], bins))
        return Maker(problem, body, self.tubes[n], taken, rates)

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
        if not node.problem.borders and node.size <= tuning.TEAM.border_states:
            return Expansion((self._with_borders(node),))
        if not node.ascended and node.problem.borders and self._ascend(node):
            return Expansion((node,))
        if (
            not node.has_open_choice
            and node.bins < tuning.TEAM.rate_bins
            and node.size <= tuning.TEAM.fine_states
        ):
            self._refine(node, tuning.TEAM.rate_bins)
            return Expansion((node,))
        if (
            self._count(node)
            <= (tuning.TEAM.open_leaf_pairs if node.has_open_choice else tuning.TEAM.leaf_pairs)
            and not node.tried
        ):
            node.bound = max(node.bound, self._solve(node, tuning.TEAM.leaf_seconds))
            if node.bound >= session.cutoff:
                return Expansion(closed=node.bound)
            node.tried = True
        elif self.visited % tuning.TEAM.plunge_every == 1:
            self._plunge(node, agreement)
            self._polish()
        return self._branch(node)

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
        return None if node.empty else agreement

    def _ascend(self, node: Node) -> bool:
        """Better slopes and prices for the node of all plans, once; whether there are any."""
        node.ascended, session = True, self.session
        assert node.masks is not None
        alive = sum(int(m.sum()) for masks in node.masks.values() for m in masks)
        if alive > tuning.TEAM.ascent_pairs or not np.isfinite(session.cutoff):
            return False
        kept = Agreement(node.problem, node.rows, node.prices, node.masks, self.pool)
        ascent = TeamAscent(kept)
        if ascent.empty:
            node.bound = np.inf
            return True
        moment = session.deadline.share(tuning.TEAM.ascent_share)
        gap = session.cutoff - node.bound
        node.rows, node.prices = ascent.climb(moment.over, gap)
        return True

    def _refine(self, node: Node, bins: int) -> None:
        """Children of the alive states on a finer grid of rates."""
        rows = self._children(node, node.problem, bins)
        index = [[layer.parent for layer in row] for row in rows]
        node.rows, node.bins = rows, bins
        node.prices, node.masks = sliced(node.prices, index), masked(node.masks, index)

    def _children(self, node: Node, problem: Problem, bins: int) -> list[list[Layer]]:
        return [
            self._maker(problem, n, node.taken[n], bins).layers(row)
            for n, row in enumerate(node.rows)
        ]

    def _with_borders(self, node: Node) -> Node:
        """Borders of alive cells as cells of their own. A plan is in that of the touching cells
        that its first tables take: states are kept for any of them, all pairs of states at first.
        """
        if self._bordered is None:
            self._bordered = recognise(self.frame.compiled, borders=True)
        assert self._bordered is not None
        rows = self._children(node, self._bordered, node.bins)
        prices = sliced(node.prices, [[layer.parent for layer in row] for row in rows])
        masks = None if node.masks is None else {
            (i, j): [np.ones((len(a), len(b)), bool) for a, b in zip(rows[i], rows[j], strict=True)]
            for i, j in node.masks
        }  # fmt: skip
        return replace(node, problem=self._bordered, rows=rows, prices=prices, masks=masks)

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
        parts = [part]
        while self._count(parts[-1]) > tuning.TEAM.dive_pairs and not session.stopped():
            part = replace(parts[-1], rows=list(parts[-1].rows))
            top = part.bound + tuning.TEAM.plunge_cut * (top - part.bound)
            if self._tighten(part, 2, top) is None:
                break
            parts.append(part)
        before, until = session.value, session.seconds + tuning.TEAM.dive_seconds
        for part in reversed(parts):
            if session.value < before or session.seconds > until or session.stopped():
                return
            self._solve(part, tuning.TEAM.dive_seconds)

    def _polish(self) -> None:
        """Free two agents at a time around the incumbent, until all pairs bring nothing."""
        session, until = self.session, self.session.seconds + tuning.TEAM.dive_seconds
        cell = min(float(np.diff(e).max()) for e in self.problem.edges)
        agents = len(self.problem.bodies)
        idle = 0
        while session.x is not None and session.seconds < until and not session.stopped():
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
    def _branch(self, node: Node) -> Expansion[Node]:
        """Halve the largest choice, or where an agent is at some step."""
        if not node.has_open_choice:
            return self._halves(node)
        n = int(np.argmax([len(t) for t in node.taken]))
        own = node.taken[n]
        half = len(own) // 2
        return Expansion(tuple(self._child(node, n, part) for part in (own[:half], own[half:])))

    def _child(self, node: Node, n: int, part: tuple[int, ...]) -> Node:
        index = everything(node)
        row, index[n] = with_choice(self.problem.bodies[n], self.tubes[n], part, node.rows[n])
        taken = tuple(part if k == n else t for k, t in enumerate(node.taken))
        child = kept(replace(node, taken=taken, tried=False, ascended=True), index)
        child.rows[n] = row
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
            out.append(kept(replace(node, tried=False, ascended=True), index))
        return Expansion(tuple(out))
