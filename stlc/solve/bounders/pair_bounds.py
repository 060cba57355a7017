"""What rules out pairs of states at a node: joint programme, LP relaxation, ascent."""

from __future__ import annotations

import numpy as np

from stlc.arrays import Bools, Floats
from stlc.solve import tuning
from stlc.solve.bounders.arcs import Arcs
from stlc.solve.bounders.ascent import ascend
from stlc.solve.bounders.cuts import best_cut
from stlc.solve.bounders.joint import Joint
from stlc.solve.bounders.pair_node import Node
from stlc.solve.bounders.shares import stage_cost
from stlc.solve.restricted.frame import potentials, relax
from stlc.solve.restricted.session import Session
from stlc.solve.states.layers import cells_of, restrict, sloped

MARGIN = 1e-6


class Tightener:
    """Works on the nodes of two agents. Its methods say False when a node holds nothing better
    than the cutoff."""

    def __init__(self, session: Session) -> None:
        self.session, self.problem, self.frame = session, session.problem, session.frame
        self.bodies = (self.problem.bodies[0], self.problem.bodies[1])
        self.cost = [stage_cost(self.problem, t) for t in range(1, self.problem.steps + 1)]

    def relax(self, node: Node) -> bool:
        """Bound by the LP relaxation; drop pair columns by their reduced cost."""
        session = self.session
        lower, upper = self.bounds(node)
        reduced = self.frame.reduce(lower, upper)
        relaxed = None if reduced is None else relax(self.frame, reduced, session.left)
        if reduced is None:
            node.bound = np.inf
            return False
        if relaxed is None:
            return True
        node.bound = max(node.bound, relaxed.value - MARGIN)
        if node.bound >= session.cutoff:
            return False
        if np.isfinite(session.cutoff):
            self._fix(node, relaxed.reduced, session.cutoff - relaxed.value)
        if not node.priced:
            pi = potentials(self.frame, (0, 1), relaxed.duals)
            node.layers = (sloped(node.layers[0], pi[0]), sloped(node.layers[1], pi[1]))
            return self.programme(node)
        return True

    def ascend(self, node: Node) -> bool:
        """Better potentials, and what they rule out."""
        assert node.masks is not None
        node.priced = True
        arcs = Arcs(self.bodies, node.layers, self.cost, node.masks)
        if arcs.empty:
            node.bound = np.inf
            return False
        ascend(arcs, self._heat(node), tuning.PAIR.ascent_rounds)
        least, through = arcs.through()
        node.bound = max(node.bound, least + self.problem.rest - MARGIN)
        if node.bound >= self.session.cutoff:
            return False
        node.layers = arcs.priced()
        self._keep(node, self._alive(arcs, through, node))
        return True

    def cut(self, node: Node) -> bool:
        """Look for the node's best cut; False when there is none."""
        assert node.masks is not None
        arcs = Arcs(self.bodies, node.layers, self.cost, node.masks)
        if arcs.empty:
            return False
        room = self.session.cutoff - node.bound
        node.cut = best_cut(self.problem, arcs, self._heat(node), room)
        return node.cut is not None

    def _heat(self, node: Node) -> float:
        """Of the smoothing: a part of the gap."""
        gap = min(self.session.cutoff, 1.2 * abs(node.bound)) - node.bound
        return max(gap / 20, 1e-3 * abs(node.bound), 1e-6)

    def _alive(self, arcs: Arcs, through: list[Floats], node: Node) -> list[Bools]:
        out = []
        for t, (stop, values) in enumerate(zip(arcs.stops, through, strict=True)):
            mask = np.zeros((len(node.layers[0][t]), len(node.layers[1][t])), bool)
            keep = values <= self.session.cutoff - self.problem.rest + MARGIN
            mask[stop.i[keep], stop.j[keep]] = True
            out.append(mask)
        return out

    def programme(self, node: Node) -> bool:
        """Bound by the joint programme; drop pairs of states that reach the cutoff."""
        rest, cutoff = self.problem.rest, self.session.cutoff
        joint = Joint(self.bodies, node.layers, self.cost, node.masks)
        node.bound = max(node.bound, joint.forward() + rest - MARGIN)
        if node.bound >= cutoff:
            return False
        joint.backward()
        alive = [joint.through(t) <= cutoff - rest + MARGIN for t in range(joint.steps + 1)]
        alive = [a & np.isfinite(joint.through(t)) for t, a in enumerate(alive)]
        self._keep(node, alive)
        return True

    def _fix(self, node: Node, reduced: Floats, slack: float) -> None:
        """Drop cell pairs whose column costs too much to be 1, where columns tell the state."""
        assert node.pairs is not None
        assert node.masks is not None
        for block in self.frame.blocks.get((0, 1), ()):
            if any(block.beside):
                continue
            excluded = reduced[block.columns] > slack + MARGIN
            node.pairs[block.step][np.ix_(*block.cells)] &= ~excluded
        alive = [node.masks[0]]
        for t in range(1, len(node.masks)):
            a, b = node.layers[0][t].cell, node.layers[1][t].cell
            alive.append(node.masks[t] & node.pairs[t][a][:, b])
        self._keep(node, alive)

    def _keep(self, node: Node, alive: list[Bools]) -> None:
        """Keep the state pairs that are `alive` (T+1 masks), and drop states that are in none."""
        kept = [[np.asarray(m.any(axis)) for m in alive] for axis in (1, 0)]
        rows = [
            [restrict(layer, k) for layer, k in zip(node.layers[n], kept[n], strict=True)]
            for n in (0, 1)
        ]
        node.layers = (rows[0], rows[1])
        node.masks = [m[np.ix_(kept[0][t], kept[1][t])] for t, m in enumerate(alive)]
        node.pairs = [
            cells_of(mask, rows[0][t], rows[1][t], self.problem.cells)
            for t, mask in enumerate(node.masks)
        ]

    def bounds(self, node: Node) -> tuple[Floats, Floats]:
        """Column bounds of the full model with what is left of a node."""
        assert node.pairs is not None
        return self.frame.narrowed(node.taken, node.layers, {(0, 1): node.pairs})
