"""All abstract steps of two agents between the pairs of states that are alive, as lists.

Where few pairs of states are left this is far smaller than the tables of `joint`, and fast enough
to be run many times. List 4 t holds the pairs of layer t; the three lists after it hold where
they stand when the first agent has moved along x, then along y, then the second along x.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.solve.bounders.axis_edges import AxisEdges
from stlc.solve.bounders.chain import SAFETY
from stlc.solve.relaxation.problem import Body
from stlc.solve.states.layers import Layer
from stlc.solve.states.steps import Half, Step, spread


@dataclass(frozen=True, slots=True, eq=False)
class Hop:
    """Arcs of a half-step: source and target in two lists, the axis edge. Sorted by source, whose
    first arcs are `begin`; `order` sorts by target, whose first arcs are then `first`."""

    source: Ints
    target: Ints
    edge: Ints
    begin: Ints
    order: Ints
    first: Ints


@dataclass(frozen=True, slots=True, eq=False)
class Stop:
    """Pairs of states i, j of a layer, and what their cells cost."""

    i: Ints
    j: Ints
    cost: Floats


class Arcs(AxisEdges):
    """Two agents; cost[t] (cells, cells) at step t + 1; masks[t]: pairs of states alive. The axis
    edges of a hop stand together."""

    def __init__(
        self, bodies: tuple[Body, Body], layers: tuple[list[Layer], list[Layer]],
        cost: Sequence[Floats], masks: Sequence[Bools],
    ) -> None:  # fmt: skip
        super().__init__(bodies, layers)
        raw, pairs = self._walk(self.made, masks)
        self.stops, self.hops = self._joined(raw, pairs, cost)

    # -- lists of pairs -------------------------------------------------------------------------
    def _walk(
        self, made: Sequence[Sequence[Step]], masks: Sequence[Bools]
    ) -> tuple[list[list[Ints]], list[tuple[Ints, Ints]]]:
        """Follow all steps from the start: arcs [source, target, edge] and pairs of all lists."""
        i = j = np.zeros(1, np.int64)
        raw, pairs = [], [(i, j)]
        for t in range(self.steps):
            for n in (0, 1):
                for d, half in enumerate((made[n][t].first, made[n][t].second)):
                    arcs, i, j = _hop(half, n, i, j)
                    arcs[2] = arcs[2] + self._first[n, t, d]
                    raw.append(arcs)
                    pairs.append((i, j))
            keep = masks[t + 1][i, j]
            raw[-1], (i, j) = _kept(raw[-1], keep), (i[keep], j[keep])
            pairs[-1] = (i, j)
        return raw, pairs

    def _joined(
        self, raw: list[list[Ints]], pairs: list[tuple[Ints, Ints]], cost: Sequence[Floats]
    ) -> tuple[list[Stop], list[Hop]]:
        """Lists without what leads nowhere."""
        keep = np.ones(len(pairs[-1][0]), bool)
        hops: list[Hop] = []
        for q in range(len(raw) - 1, -1, -1):
            pairs[q + 1] = (pairs[q + 1][0][keep], pairs[q + 1][1][keep])
            arcs = _kept(raw[q], keep)
            keep = np.zeros(len(pairs[q][0]), bool)
            keep[arcs[0]] = True
            arcs[0] = (np.cumsum(keep) - 1)[arcs[0]]
            hops.append(_hopped(arcs))
        pairs[0] = (pairs[0][0][keep], pairs[0][1][keep])
        stops = [Stop(*pairs[0], np.zeros(len(pairs[0][0])))]
        for t in range(1, self.steps + 1):
            i, j = pairs[4 * t]
            cells = (self.layers[0][t].cell[i], self.layers[1][t].cell[j])
            stops.append(Stop(i, j, cost[t - 1][cells]))
        return stops, hops[::-1]

    @property
    def empty(self) -> bool:
        """Whether no run is left."""
        return len(self.stops[0].i) == 0

    # -- values ---------------------------------------------------------------------------------
    def through(self) -> tuple[float, list[Floats]]:
        """Least value of all abstract runs, and of those through each pair of every stop."""
        weights = self.corners.least(*self.ends(self.slopes))[0] - SAFETY
        ahead, f = [np.zeros(1)], np.zeros(1)
        for q, hop in enumerate(self.hops):
            f = np.minimum.reduceat((f[hop.source] + weights[hop.edge])[hop.order], hop.first)
            if q % 4 == 3:
                f = f + self.stops[(q + 1) // 4].cost
                ahead.append(f)
        behind, g = [np.zeros(len(f))], np.zeros(len(f))
        for q in range(len(self.hops) - 1, -1, -1):
            hop = self.hops[q]
            if q % 4 == 3:
                g = g + self.stops[(q + 1) // 4].cost
            g = np.minimum.reduceat(g[hop.target] + weights[hop.edge], hop.begin)
            if q % 4 == 0:
                behind.append(g)
        return float(f.min()), [a + b for a, b in zip(ahead, behind[::-1], strict=True)]

    def priced(self) -> tuple[list[Layer], list[Layer]]:
        """The layers with these slopes."""
        rows = [
            [
                layer.priced(*(self.slopes[self.boxes[n, t, d]] for d in (0, 1)))
                for t, layer in enumerate(row)
            ]
            for n, row in enumerate(self.layers)
        ]
        return rows[0], rows[1]


def _hop(half: Half, n: int, i: Ints, j: Ints) -> tuple[list[Ints], Ints, Ints]:
    """All arcs of agent n's half-step from pairs (i, j), as [source, target, edge, order by
    target], and the pairs they lead to."""
    mover, other = (i, j) if n == 0 else (j, i)
    by_source = np.argsort(half.source, kind="stable")
    count = np.bincount(half.source, minlength=half.sources)
    source, at = spread(np.cumsum(count) - count, count, mover)
    at = by_source[at]
    width = int(other.max(initial=0)) + 1
    keys = half.target[at] * width + other[source]
    order = np.argsort(keys, kind="stable")
    inorder = keys[order]
    new = np.diff(inorder, prepend=-1) > 0
    target = np.empty_like(order)
    target[order] = np.cumsum(new) - 1
    moved, stayed = np.divmod(inorder[new], width)
    ends = (moved, stayed) if n == 0 else (stayed, moved)
    return [source, target, half.edge[at], order], *ends


def _kept(arcs: list[Ints], keep: Bools) -> list[Ints]:
    """Arcs to targets that are kept, renumbered."""
    source, target, edge, order = arcs
    alive = keep[target]
    number = np.cumsum(alive) - 1
    return [
        source[alive], (np.cumsum(keep) - 1)[target[alive]], edge[alive],
        number[order[alive[order]]],
    ]  # fmt: skip


def _hopped(arcs: list[Ints]) -> Hop:
    source, target, edge, order = arcs
    return Hop(source, target, edge, _starts(source), order, _starts(target[order]))


def _starts(values: Ints) -> Ints:
    """Where each run of equal values begins."""
    return np.flatnonzero(np.diff(values, prepend=-1))
