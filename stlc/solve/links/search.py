"""Branch and bound over two agents: dynamic programming and LPs at the nodes, MILPs at the leaves.

A node is a set of alternatives for each agent's choice over time, with the pairs of states that
may still hold a plan better than the cutoff. It is tightened in turns: the joint programme removes
pairs of states, the LP relaxation of the restricted model gives the next potentials and removes
pair columns by their reduced cost. Nodes with few cell pairs left go to the solver whole.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stlc.solve.links.descent import Descent
from stlc.solve.links.joint import Joint
from stlc.solve.links.layers import Layer, Maker, drawn_in, rate_borders, reach_bits, restrict
from stlc.solve.links.problem import Bools, Floats
from stlc.solve.links.reach import tubes
from stlc.solve.links.restrict import potentials, relax
from stlc.solve.links.session import Session
from stlc.solve.links.shares import stage_cost

COARSE, FINE = 4, 8  # bins of the rate along each axis
LEAF_PAIRS = 2600  # cell pairs that go to the solver when no choice is left
WIDE_PAIRS = 700  # and when there is
REFINE_PAIRS = 800  # more than these are worth finer boxes
DIVE_PAIRS = 600
_MARGIN = 1e-6

Rows = tuple[list[Layer], list[Layer]]
Taken = tuple[tuple[int, ...], tuple[int, ...]]


@dataclass(slots=True)
class Node:
    """masks[t]: alive pairs of states (None: all); pairs[t] (cells, cells): alive cell pairs."""

    bound: float
    layers: Rows
    taken: Taken
    masks: list[Bools] | None
    pi: Floats
    pairs: list[Bools] | None = None
    bins: int = COARSE
    depth: int = 0

    @property
    def count(self) -> int:
        """Alive cell pairs."""
        return 10**9 if self.pairs is None else sum(int(p.sum()) for p in self.pairs[1:])

    @property
    def wide(self) -> bool:
        """Whether some choice is open."""
        return max(map(len, self.taken)) > 1


class Search:
    """Two agents that share one pair; works on a session until proven or stopped."""

    def __init__(self, session: Session) -> None:
        self.session, self.problem = session, session.problem
        self.frame = session.frame
        bodies = self.problem.bodies
        self.bodies = (bodies[0], bodies[1])
        self.tubes = tuple(tubes(b, self.problem.steps) for b in bodies)
        self.cost = [stage_cost(self.problem, t) for t in range(1, self.problem.steps + 1)]
        self.descent = Descent(self.problem, session.stopped)

    def run(self) -> bool:
        """Search; True when the incumbent is proven within the gap."""
        root = self._root()
        if root is None:
            return False
        self._guides({}, ((0, 1), (1, 0)))
        ticks, closed = itertools.count(), np.inf
        heap = [(root.bound, next(ticks), root)]
        while heap and heap[0][0] < self.session.cutoff and not self.session.stopped():
            _, _, node = heapq.heappop(heap)
            done, kids = self._expand(node)
            closed = min(closed, done)
            for kid in kids:
                heapq.heappush(heap, (kid.bound, next(ticks), kid))
            self._raise(min([closed, *(k[0] for k in heap)]))
        return self.session.x is not None and self.session.bound >= self.session.cutoff - _MARGIN

    def _raise(self, least: float) -> None:
        """Every plan lies in an open node, a closed one, or is no better than the cutoff."""
        self.session.raise_bound(min(least, self.session.cutoff))

    def _root(self) -> Node | None:
        taken = (self.tubes[0].possible, self.tubes[1].possible)
        if not all(taken):
            return None
        rows = tuple(self._maker(n, taken[n], COARSE).layers() for n in (0, 1))
        pi = np.zeros((2, self.problem.steps + 1, 2, 2))
        return Node(-np.inf, (rows[0], rows[1]), taken, None, pi)

    def _maker(self, n: int, taken: tuple[int, ...], bins: int) -> Maker:
        body = self.bodies[n]
        rates = (rate_borders(body.axes[0], bins), rate_borders(body.axes[1], bins))
        return Maker(self.problem, body, self.tubes[n], taken, rates)

    # -- plans --------------------------------------------------------------------------------
    def _guides(self, start: dict[int, Floats], orders: Sequence[Sequence[int]]) -> bool:
        """Coordinate descents, each guide given to the solver with the cells it touches."""
        if not self.descent.possible:
            return False
        better = False
        for order in orders:
            runs = self.descent.run(order, start, 8)
            if runs is not None and not self.session.stopped():
                better |= self.session.follow([runs[i] for i in range(2)], 5.0)
        return better

    def _polish(self, rounds: int, seconds: float) -> None:
        cell = min(float(np.diff(e).max()) for e in self.problem.edges)
        for _ in range(rounds):
            before = self.session.value
            if self.session.x is None or self.session.stopped():
                return
            self.session.near(self.session.paths(), 0.7 * cell, seconds, 1e-3)
            if self.session.value > before - 1e-3 * abs(before):
                return

    def _seeded(self, node: Node) -> bool:
        """Descents from the best abstract run under the node's potentials."""
        if node.masks is None or not self.descent.possible:
            return False
        joint = Joint(self.bodies, node.layers, self.cost, node.masks)
        joint.weigh(node.pi)
        if not np.isfinite(joint.forward()):
            return False
        path, better = joint.path(), False
        for n in (0, 1):
            centre = np.array([_centre(node.layers[n][t], path[t][n]) for t in range(len(path))])
            better |= self._guides({n: centre}, ((1 - n, n),))
        return better

    # -- nodes --------------------------------------------------------------------------------
    def _expand(self, node: Node) -> tuple[float, list[Node]]:
        """Bound of what was closed here, and the children."""
        session = self.session
        session.nodes += 1
        is_open = self._tighten(node, 1 if node.wide else 2)
        if is_open and (node.depth == 0 or (not node.wide and node.count > DIVE_PAIRS)):
            before = session.value
            self._seeded(node)
            if session.value < before - _MARGIN:
                self._polish(1, 4.0)
                is_open = self._tighten(node, 1)
        if is_open and not node.wide and node.bins < FINE and node.count > REFINE_PAIRS:
            self._refine(node)
            is_open = self._tighten(node, 2)
        if not is_open:
            return max(node.bound, session.cutoff), []
        if session.stopped():
            return np.inf, [node]
        if node.count <= (WIDE_PAIRS if node.wide else LEAF_PAIRS) or not node.wide:
            lower, upper = self._bounds(node)
            least = session.milp(lower, upper, session.left, 0.5 * session.options.gap)
            return max(least, node.bound), []
        return np.inf, self._branch(node)

    def _tighten(self, node: Node, rounds: int) -> bool:
        """Joint programme and LP in turns; False when nothing better than the cutoff is left."""
        session = self.session
        for _ in range(rounds):
            if any(len(layer) == 0 for row in node.layers for layer in row):
                node.bound = np.inf
                return False
            before = node.count
            if not self._programme(node):
                return False
            if session.stopped():
                return True
            lower, upper = self._bounds(node)
            reduced = self.frame.reduce(lower, upper)
            relaxed = None if reduced is None else relax(self.frame, reduced, session.left)
            if reduced is None:
                node.bound = np.inf
                return False
            if relaxed is None:
                return True
            node.bound = max(node.bound, relaxed.value - _MARGIN)
            if node.bound >= session.cutoff:
                return False
            node.pi = potentials(self.frame, (0, 1), relaxed.duals)
            if np.isfinite(session.cutoff):
                self._fix(node, relaxed.reduced, session.cutoff - relaxed.value)
            if node.count > 0.9 * before:
                break
        return True

    def _programme(self, node: Node) -> bool:
        """Bound by the joint programme; drop pairs of states that reach the cutoff."""
        rest, cutoff = self.problem.rest, self.session.cutoff
        joint = Joint(self.bodies, node.layers, self.cost, node.masks)
        joint.weigh(node.pi)
        node.bound = max(node.bound, joint.forward() + rest - _MARGIN)
        if node.bound >= cutoff:
            return False
        joint.backward()
        alive = [joint.through(t) <= cutoff - rest + _MARGIN for t in range(joint.steps + 1)]
        alive = [a & np.isfinite(joint.through(t)) for t, a in enumerate(alive)]
        self._keep(node, alive)
        return True

    def _fix(self, node: Node, reduced: Floats, slack: float) -> None:
        """Drop cell pairs whose column costs too much to be 1."""
        assert node.pairs is not None
        assert node.masks is not None
        for block in self.frame.blocks.get((0, 1), ()):
            dear = reduced[block.columns] > slack + _MARGIN
            node.pairs[block.step][np.ix_(*block.cells)] &= ~dear
        alive = [node.masks[0]]
        for t in range(1, len(node.masks)):
            a, b = node.layers[0][t].cell, node.layers[1][t].cell
            alive.append(node.masks[t] & node.pairs[t][a][:, b])
        self._keep(node, alive)

    def _keep(self, node: Node, alive: list[Bools]) -> None:
        kept = [[np.asarray(m.any(axis)) for m in alive] for axis in (1, 0)]
        rows = [
            [restrict(layer, k) for layer, k in zip(node.layers[n], kept[n], strict=True)]
            for n in (0, 1)
        ]
        node.layers = (rows[0], rows[1])
        node.masks = [m[np.ix_(kept[0][t], kept[1][t])] for t, m in enumerate(alive)]
        cells, pairs = self.problem.cells, []
        for t, mask in enumerate(node.masks):
            out = np.zeros((cells, cells), bool)
            i, k = np.nonzero(mask)
            out[rows[0][t].cell[i], rows[1][t].cell[k]] = True
            pairs.append(out)
        node.pairs = pairs

    def _bounds(self, node: Node) -> tuple[Floats, Floats]:
        lower, upper = self.frame.bounds()
        for n in (0, 1):
            self.frame.choose(upper, n, node.taken[n])
            for t in range(1, self.problem.steps + 1):
                self.frame.confine(lower, upper, n, t, node.layers[n][t].bounds())
        assert node.pairs is not None
        self.frame.keep_pairs(upper, (0, 1), node.pairs)
        return lower, upper

    def _refine(self, node: Node) -> None:
        """Children of the alive states on a finer grid of rates."""
        assert node.masks is not None
        rows = tuple(self._maker(n, node.taken[n], FINE).layers(node.layers[n]) for n in (0, 1))
        node.masks = [m[a.parent][:, b.parent] for m, a, b in zip(node.masks, *rows, strict=True)]
        node.layers, node.bins = (rows[0], rows[1]), FINE

    def _branch(self, node: Node) -> list[Node]:
        """Halve the larger choice."""
        n = int(len(node.taken[1]) > len(node.taken[0]))
        own = node.taken[n]
        return [self._child(node, n, part) for part in (own[: len(own) // 2], own[len(own) // 2 :])]

    def _child(self, node: Node, n: int, part: tuple[int, ...]) -> Node:
        assert node.masks is not None
        row, masks = list(node.layers[n]), list(node.masks)
        for t in range(1, len(row)):
            layer = row[t]
            bits = reach_bits(
                self.bodies[n], self.tubes[n], part, t, layer.x, layer.y, layer.ix, layer.iy
            )
            keep = np.asarray(bits[layer.bit, np.arange(len(layer))], dtype=bool)
            x, y = drawn_in(self.tubes[n], part, t, layer.x, layer.y)
            row[t] = restrict(replace(layer, x=x, y=y), keep)
            masks[t] = masks[t][keep] if n == 0 else masks[t][:, keep]
        rows = (row, node.layers[1]) if n == 0 else (node.layers[0], row)
        taken = (part, node.taken[1]) if n == 0 else (node.taken[0], part)
        return Node(node.bound, rows, taken, masks, node.pi, None, node.bins, node.depth + 1)


def _centre(layer: Layer, k: int) -> Floats:
    x, y = layer.x.box[layer.ix[k], :2], layer.y.box[layer.iy[k], :2]
    return np.array([x.mean(), y.mean()])
