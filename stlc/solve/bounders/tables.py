"""Sums and minima over all abstract runs of two agents, by tables of their states.

The same values as those of `arcs`. Where most pairs of states are alive, products of one agent's
half-steps, as sparse matrices, with tables of pairs take a tenth of the time of lists.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.solve.bounders.ascent import weights_of
from stlc.solve.bounders.axis_edges import AxisEdges
from stlc.solve.bounders.chain import SAFETY
from stlc.solve.relaxation.problem import Body
from stlc.solve.states.layers import Layer
from stlc.solve.states.steps import Half, Sweep, both_ways

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

_LEAST = 1e-300


@dataclass(frozen=True, slots=True, eq=False)
class _Hop:
    """A half-step: `matrix` (targets, sources) has an entry for each of its edges, in the order of
    `source`, `target` and `edge` (of the agent's axis edges, those in `part`)."""

    source: Ints
    target: Ints
    edge: Ints
    part: slice
    matrix: csr_matrix
    sweep: Sweep


class Moves(AxisEdges):
    """The steps of one agent. Its half-steps are shared by all tables that it has a part in, which
    are worked through one after the other: each sets the entries of `matrix` anew."""

    def __init__(self, body: Body, layers: list[Layer]) -> None:
        super().__init__([body], [layers])
        ends = [*self.parts.tolist(), len(self.leaves)]
        self.hops = [
            _hop(half, slice(ends[2 * t + d], ends[2 * t + d + 1]))
            for t, step in enumerate(self.made[0])
            for d, half in enumerate((step.first, step.second))
        ]

    def least(self, slopes: Floats) -> Floats:
        """Least weight of every axis edge."""
        return self.corners.least(*self.ends(slopes))[0] - SAFETY

    def priced(self, slopes: Floats) -> list[Layer]:
        """The layers with these slopes."""
        return [
            layer.priced(*(slopes[self.boxes[0, t, d]] for d in (0, 1)))
            for t, layer in enumerate(self.layers[0])
        ]


def _hop(half: Half, part: slice) -> _Hop:
    from scipy.sparse import csr_matrix

    order = np.lexsort((half.source, half.target))
    source, target = half.source[order], half.target[order]
    starts = np.searchsorted(target, np.arange(half.targets + 1))
    shape = (half.targets, half.sources)
    matrix = csr_matrix((np.ones(len(source)), source, starts), shape=shape)
    return _Hop(source, target, half.edge[order] + part.start, part, matrix, both_ways(half)[0])


@dataclass(frozen=True, slots=True, eq=False)
class Soft:
    """A soft minimum; for both agents the share of the runs along each axis edge and the steps
    that edges stand for (see `Corners.cheapest`); at every step that of each pair of states."""

    value: float
    flows: tuple[Floats, Floats]
    at: tuple[Floats, Floats]
    shares: list[Floats]


class Tables:
    """Two agents. `slopes` are those of both (boxes, 2); stops[t] (n, m): what pairs of states
    cost at step t, infinite where they are dropped; stops[0] is not looked at."""

    def __init__(self, first: Moves, second: Moves) -> None:
        self.moves, self.steps = (first, second), first.steps

    def softened(self, slopes: tuple[Floats, Floats], stops: Sequence[Floats], heat: float) -> Soft:
        """-heat log sum exp(-value / heat) over all abstract runs."""
        found = [m.corners.cheapest(*m.ends(s)) for m, s in zip(self.moves, slopes, strict=True)]
        low, weights = 0.0, list[Floats]()
        for moves, (value, _) in zip(self.moves, found, strict=True):
            lowest, scaled = weights_of(moves, value, heat)
            low, weights = low + lowest, [*weights, scaled]
            for hop in moves.hops:
                hop.matrix.data[:] = scaled[hop.edge]
        sums = [np.ones((1, 1))]
        scales, logs = self._forward(sums, stops, heat)
        flows, shares = self._flow(sums, scales, weights)
        total = float(sums[-1].sum())
        value = low - heat * (np.log(total) + logs)
        return Soft(value, flows, (found[0][1], found[1][1]), shares)

    def _forward(
        self, sums: list[Floats], stops: Sequence[Floats], heat: float
    ) -> tuple[list[Floats], float]:
        """Append the sums over the runs to each pair after every half-step, and after stops. What
        stops were scaled by, and the logarithm of all that scaling."""
        scales, logs = [], 0.0
        for t in range(self.steps):
            table = sums[-1]
            for moves in self.moves:
                for hop in moves.hops[2 * t : 2 * t + 2]:
                    table = hop.matrix @ table
                    sums.append(table)
                sums[-1] = table = np.ascontiguousarray(table.T)
            low = float(stops[t + 1].min())
            scale = np.exp((low - stops[t + 1]) / heat)
            top = max(float((table * scale).max()), _LEAST)
            scales.append(scale / top)
            sums[-1] = table * scales[-1]
            logs += float(np.log(top)) - low / heat
        return scales, logs

    def _flow(
        self, sums: list[Floats], scales: list[Floats], weights: list[Floats]
    ) -> tuple[tuple[Floats, Floats], list[Floats]]:
        """Share of the runs along each axis edge, and through each pair of states at each step."""
        flows, back = (np.zeros(len(weights[0])), np.zeros(len(weights[1]))), np.ones_like(sums[-1])
        shares = [sums[-1] / sums[-1].sum()]
        for t in range(self.steps - 1, -1, -1):
            back = back * scales[t]
            for end in (1, 0):
                back = np.ascontiguousarray(back.T)
                for d in (1, 0):
                    hop, before = self.moves[end].hops[2 * t + d], sums[4 * t + 2 * end + d]
                    along = np.einsum("ij,ij->i", before[hop.source], back[hop.target])
                    along *= weights[end][hop.edge]
                    flows[end][hop.part] += np.bincount(
                        hop.edge - hop.part.start, along / along.sum(),
                        minlength=hop.part.stop - hop.part.start,
                    )  # fmt: skip
                    back = hop.matrix.T @ back
            back /= back.max()
            share = sums[4 * t] * back
            shares.append(share / share.sum())
        return flows, shares[::-1]

    def least(self, slopes: tuple[Floats, Floats], stops: Sequence[Floats]) -> float:
        """Least value of all abstract runs; infinite where there is none."""
        weights = [m.least(s) for m, s in zip(self.moves, slopes, strict=True)]
        table = np.zeros((1, 1))
        for t in range(self.steps):
            for moves, own in zip(self.moves, weights, strict=True):
                for hop in moves.hops[2 * t : 2 * t + 2]:
                    table = hop.sweep.apply(table, own[hop.part])
                table = np.ascontiguousarray(table.T)
            table = table + stops[t + 1]
        return float(table.min(initial=np.inf))
