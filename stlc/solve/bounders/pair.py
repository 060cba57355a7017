"""Branch and bound over two agents: dynamic programming and LPs at the nodes, MILPs at the leaves.

A node is a set of alternatives for each agent's choice over time, with the pairs of states that
may still hold a plan better than the cutoff. It is tightened in turns: the joint programme removes
pairs of states, the LP relaxation of the restricted model gives the first potentials and removes
pair columns by their reduced cost, an ascent improves the potentials. Nodes are split by a choice,
or by where an agent is at a step; those with few cell pairs left go to the solver whole.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stlc.arrays import Floats
from stlc.solve import tuning
from stlc.solve.bounders.joint import Joint
from stlc.solve.bounders.pair_bounds import MARGIN, Tightener
from stlc.solve.bounders.pair_node import Node, with_cut, with_part
from stlc.solve.heuristics.descent import Descent
from stlc.solve.restricted.session import Session
from stlc.solve.states.layers import Layer, Maker, rate_borders
from stlc.solve.states.tubes import tubes
from stlc.solve.tree import Expansion, branch_and_bound


class Search:
    """Two agents that share one pair; works on a session until proven or stopped."""

    def __init__(self, session: Session) -> None:
        self.session, self.problem = session, session.problem
        bodies = self.problem.bodies
        self.bodies = (bodies[0], bodies[1])
        self.tubes = tuple(tubes(b, self.problem.steps) for b in bodies)
        self.tools = Tightener(session)
        self.descent = Descent(session.guide, session.stopped)
        self.dives = 0  # nodes when plans were last looked for

    def plan(self) -> bool:
        """Look for first plans only; never proves anything."""
        self._descend({}, ((0, 1), (1, 0)))
        return False

    def run(self) -> bool:
        """Search; True when the incumbent is proven within the gap."""
        root = self.root()
        if root is None:
            return False
        self.plan()
        branch_and_bound(self, root, self.session)
        return self.session.x is not None and self.session.bound >= self.session.cutoff - MARGIN

    def root(self) -> Node | None:
        """All pairs of states; None where an agent has no alternative."""
        taken = (self.tubes[0].possible, self.tubes[1].possible)
        if not all(taken):
            return None
        rows = tuple(self._maker(n, taken[n]).layers() for n in (0, 1))
        return Node(-np.inf, (rows[0], rows[1]), taken, None)

    def _maker(self, n: int, taken: tuple[int, ...]) -> Maker:
        body = self.bodies[n]
        rates = (
            rate_borders(body.axes[0], tuning.PAIR.rate_bins),
            rate_borders(body.axes[1], tuning.PAIR.rate_bins),
        )
        return Maker(self.problem, body, self.tubes[n], taken, rates)

    # -- plans --------------------------------------------------------------------------------
    def _descend(self, start: dict[int, Floats], orders: Sequence[Sequence[int]]) -> bool:
        """Coordinate descents, each run given to the solver with the cells it touches."""
        if not self.descent.possible:
            return False
        better = False
        for order in orders:
            runs = self.descent.run(order, start, 8)
            if runs is not None and not self.session.stopped():
                better |= self.session.follow([runs[i] for i in range(2)], 5.0)
        return better

    def _polish(self, seconds: float) -> None:
        """Solve over the cells near the incumbent."""
        if self.session.x is not None and not self.session.stopped():
            self.session.near(self.session.paths(), self._radius(), seconds, 1e-3)

    def _seeded(self, node: Node) -> bool:
        """Descents from the best abstract run under the node's potentials."""
        path = self._best_run(node) if self.descent.possible else None
        if path is None:
            return False
        return any(
            [self._descend({n: self._centres(node, path, n)}, ((1 - n, n),)) for n in (0, 1)]
        )

    def _best_run(self, node: Node) -> list[tuple[int, int]] | None:
        """States of the best abstract run."""
        joint = Joint(self.bodies, node.layers, self.tools.cost, node.masks)
        return joint.path() if np.isfinite(joint.forward()) else None

    def _centres(self, node: Node, path: Sequence[tuple[int, int]], n: int) -> Floats:
        """Positions (T+1, 2) in the middle of agent n's boxes along a run."""
        return np.array([_centre(node.layers[n][t], pair[n]) for t, pair in enumerate(path)])

    def _radius(self) -> float:
        """Of the neighbourhoods that are solved [m]: well over half a cell."""
        return 0.7 * min(float(np.diff(e).max()) for e in self.problem.edges)

    # -- nodes --------------------------------------------------------------------------------
    def expand(self, node: Node) -> Expansion[Node]:
        """Tighten; close what is decided or small enough for the solver, split the rest."""
        session = self.session
        session.nodes += 1
        is_open = self._tighten(node)
        if not is_open:
            return Expansion(closed=max(node.bound, session.cutoff))
        if session.stopped():
            return Expansion((node,))
        most = tuning.PAIR.open_leaf_pairs if node.has_open_choice else tuning.PAIR.leaf_pairs
        if node.count > most and (node.has_open_choice or self.tools.cut(node)):
            return Expansion(tuple(self._branch(node)))
        lower, upper = self.tools.bounds(node)
        least = session.milp(lower, upper, session.left, 0.5 * session.options.gap)
        return Expansion(closed=max(least, node.bound))

    def _tighten(self, node: Node) -> bool:
        """False when nothing better than the cutoff is left."""
        tools = self.tools
        if not tools.programme(node) or not tools.relax(node):
            return False
        if node.depth == 0:
            self._seeded(node)
            self._polish(10.0)
            if not tools.programme(node):
                return False
        many = node.pairs_of_states > (
            tuning.PAIR.open_most_states if node.has_open_choice else tuning.PAIR.most_states
        )
        if self.session.stopped() or many:
            return True
        return tools.ascend(node) and (node.count < tuning.PAIR.dive_pairs or self._dive(node))

    def _dive(self, node: Node) -> bool:
        """Plans near the best abstract run, once in a while; False when that closes the node."""
        session = self.session
        if session.nodes < 2 * self.dives:
            return True
        self.dives, before = session.nodes, session.value
        path = self._best_run(node)
        if path is None:
            return True
        session.near([self._centres(node, path, n) for n in (0, 1)], self._radius(), 6.0, 1e-3)
        return session.value >= before or self.tools.programme(node)

    def _branch(self, node: Node) -> list[Node]:
        """Halve the larger choice; without one, cut the node where an agent is at a step."""
        if not node.has_open_choice:
            return [with_cut(self.problem, node, first) for first in (True, False)]
        n = int(len(node.taken[1]) > len(node.taken[0]))
        own = node.taken[n]
        halves = (own[: len(own) // 2], own[len(own) // 2 :])
        return [with_part(node, n, h, self.bodies[n], self.tubes[n]) for h in halves]


def _centre(layer: Layer, k: int) -> Floats:
    x, y = layer.x.box[layer.ix[k], :2], layer.y.box[layer.iy[k], :2]
    return np.array([x.mean(), y.mean()])
