"""Counts and networks as rows over the literals w of their arguments; P is the parent z, or 1.

    count of k              sum w >= k P, each w with its weight
    joined                  an arborescence from vertex 0: arcs y with y_ij + y_ji <= w_e, one arc
                            into every other vertex, and for each of them a unit of flow from vertex
                            0 within y (the cuts of Edmonds' arborescences by flow: Wong 1980); its
                            relaxation is the dominant of spanning trees
    parted                  labels p, 0 at vertex 0, 1 somewhere, |p_i - p_j| <= w_e
    joined within H hops    P units of flow f from vertex 0 to vertex 1, f_ij + f_ji <= w_e and
                            sum f <= H P: a flow falls into paths, and the shortest is no longer
                            than their mean
    parted within H hops    r_h(v) = 1 for what is reached within h hops:
                            r_h(j) >= r_{h-1}(i) - w_e, r_H(1) <= 1 - P
    relayed (composed)      a path of P units with binary edges u, c_e >= weight_e - cap (1 - u_e),
                            sum c <= weight of the threshold
    unrelayed               lengths d of shortest paths: d_h(j) <= d_{h-1}(i) + weight_e,
                            d_H(1) >= weight of the threshold, where P is 1

Sound and complete at integer literals, in every number of vertices; sizes grow with vertices times
edges.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stlc.arrays import Ints
from stlc.ir.networks import Count, Network
from stlc.milp.builder import ModelBuilder
from stlc.milp.context import Affine
from stlc.milp.formulas.choice import RowBlock


@dataclass(frozen=True, slots=True, eq=False)
class NetworkRows:
    """Writes the rows of one count or network after the other."""

    builder: ModelBuilder
    rows: RowBlock

    def count(self, node: Count, w: Sequence[int], z: int | None) -> None:
        """Literals w that weigh so much are 1 where z is (always, for z None)."""
        self._row(w, [float(share) for share in node.shares], node.least, z)

    def network(self, node: Network, w: Sequence[int], z: int | None) -> None:
        """The literals w of a network's arguments make it hold where z is 1."""
        match node.hops is None, node.cut:
            case True, False:
                self._joined(node, w, z)
            case True, True:
                self._parted(node, w, z)
            case False, False:
                self._path(node, w, z)
            case _:
                self._no_path(node, w, z)

    def relayed(
        self, node: Network, weights: Sequence[Affine], most: float, cap: float, z: int | None
    ) -> None:
        """A path whose weights, none of which counts beyond `cap`, add up to at most `most`."""
        edges = len(node.ends)
        used = [int(c) for c in self.builder.binary("hop", (edges,))]
        shares = [int(c) for c in self.builder.add_columns("hop_weight", (edges,), 0.0, cap)]
        self._path(node, used, z)
        for u, share, weight in zip(used, shares, weights, strict=True):
            cols = [share, u, *(int(c) for c in weight.cols)]
            self.rows.add(cols, [1.0, -cap, *(-weight.values)], weight.constant - cap)
        self.rows.add(shares, [1.0] * edges, -np.inf, most)

    def unrelayed(
        self, node: Network, weights: Sequence[Affine], least: float, cap: float, z: int | None
    ) -> None:
        """No path whose weights, none of which counts beyond `cap`, add up to less than `least`."""
        hops = self._hops(node)
        length = self.builder.add_columns("length", (hops + 1, len(node.vertices)), 0.0, cap)
        self.rows.add([int(length[0, 0])], [1.0], 0.0, 0.0)
        for h in range(hops):
            for v in range(len(node.vertices)):
                self.rows.add([int(length[h, v]), int(length[h + 1, v])], [1.0, -1.0], 0.0)
            for i, j, e in _arcs(node):
                cols = [
                    int(length[h, i]),
                    int(length[h + 1, j]),
                    *(int(c) for c in weights[e].cols),
                ]
                values = [1.0, -1.0, *weights[e].values]
                self.rows.add(cols, values, -weights[e].constant)
        self._row([int(length[hops, 1])], [1.0], least, z)

    def never(self, z: int | None) -> None:
        """What can't hold: z is 0; without z there is no solution."""
        self.rows.add(
            [] if z is None else [z], [] if z is None else [-1.0], 1.0 if z is None else 0.0
        )

    def _joined(self, node: Network, w: Sequence[int], z: int | None) -> None:
        """An arborescence from vertex 0 with a unit of flow to every other vertex."""
        arcs, count = _arcs(node), len(node.vertices)
        y = self.builder.add_columns("arc", (len(arcs),), 0.0, 1.0)
        self._edges(node, y, w)
        for v in range(1, count):
            self._row(
                [int(y[k]) for k, a in enumerate(arcs) if a[1] == v], None, 1.0, z, exact=True
            )
            flow = self.builder.add_columns("flow", (len(arcs),), 0.0, 1.0)
            self._flow(node, flow, v, z)
            for k in range(len(arcs)):
                self.rows.add([int(y[k]), int(flow[k])], [1.0, -1.0], 0.0)

    def _parted(self, node: Network, w: Sequence[int], z: int | None) -> None:
        """Labels: vertex 0 on one side, some vertex on the other, no edge across."""
        side = [int(c) for c in self.builder.binary("side", (len(node.vertices),))]
        self.rows.add([side[0]], [1.0], 0.0, 0.0)
        self._row(side, None, 1.0, z)
        for i, j, e in _arcs(node):
            self.rows.add([w[e], side[i], side[j]], [1.0, -1.0, 1.0], 0.0)

    def _path(self, node: Network, w: Sequence[int], z: int | None) -> None:
        """A unit of flow from vertex 0 to vertex 1 within the edges, in few hops."""
        flow = self.builder.add_columns("flow", (2 * len(node.ends),), 0.0, 1.0)
        self._edges(node, flow, w)
        self._flow(node, flow, 1, z)
        if node.hops is not None and node.hops < len(node.vertices) - 1:
            self._row([int(c) for c in flow], [-1.0] * len(flow), -float(node.hops), z)

    def _no_path(self, node: Network, w: Sequence[int], z: int | None) -> None:
        """What is reached within so many hops; vertex 1 is not."""
        hops = self._hops(node)
        reached = self.builder.add_columns("reached", (hops + 1, len(node.vertices)), 0.0, 1.0)
        self.rows.add([int(reached[0, 0])], [1.0], 1.0, 1.0)
        for h in range(hops):
            for v in range(len(node.vertices)):
                self.rows.add([int(reached[h + 1, v]), int(reached[h, v])], [1.0, -1.0], 0.0)
            for i, j, e in _arcs(node):
                cols = [int(reached[h + 1, j]), int(reached[h, i]), w[e]]
                self.rows.add(cols, [1.0, -1.0, 1.0], 0.0)
        last = int(reached[hops, 1])
        cols, values = ([last], [1.0]) if z is None else ([last, z], [1.0, 1.0])
        self.rows.add(cols, values, -np.inf, 0.0 if z is None else 1.0)

    def _edges(self, node: Network, arcs: Ints, w: Sequence[int]) -> None:
        """Both directions of an edge together are at most its literal."""
        for e in range(len(node.ends)):
            self.rows.add([w[e], int(arcs[2 * e]), int(arcs[2 * e + 1])], [1.0, -1.0, -1.0], 0.0)

    def _flow(self, node: Network, flow: Ints, target: int, z: int | None) -> None:
        """One unit leaves vertex 0 and enters the target; elsewhere what comes goes on."""
        for v in range(len(node.vertices)):
            cols, values = [], []
            for k, (i, j, _) in enumerate(_arcs(node)):
                if v in (i, j):
                    cols.append(int(flow[k]))
                    values.append(1.0 if v == i else -1.0)
            supply = 1.0 if v == 0 else -1.0 if v == target else 0.0
            self._row(cols, values, supply, z if supply else None, exact=True)

    def _row(
        self,
        cols: Sequence[int],
        values: Sequence[float] | None,
        least: float,
        z: int | None,
        *,
        exact: bool = False,
    ) -> None:
        """values @ x[cols] >= (exact: =) least z, or least where z is None."""
        values = [1.0] * len(cols) if values is None else list(values)
        if z is None:
            self.rows.add(cols, values, least, least if exact else np.inf)
            return
        self.rows.add([*cols, z], [*values, -least], 0.0, 0.0 if exact else np.inf)

    def _hops(self, node: Network) -> int:
        longest = len(node.vertices) - 1
        return longest if node.hops is None else min(node.hops, longest)


def _arcs(node: Network) -> list[tuple[int, int, int]]:
    """(from, to, edge) of both directions of each edge, edge by edge."""
    return [arc for e, (a, b) in enumerate(node.ends) for arc in ((a, b, e), (b, a, e))]
