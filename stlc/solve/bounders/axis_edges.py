"""The axis boxes of some agents, numbered, and the steps between two boxes of an axis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.solve.relaxation.problem import Body
from stlc.solve.states.boxes import AxisGrid, Edges, corners
from stlc.solve.states.layers import Layer
from stlc.solve.states.steps import Step, make_step


class AxisEdges:
    """Agents `bodies` over `layers`, and their steps `made`[agent][t].

    slopes (boxes, 2) of the potentials, from the layers; `loose` (boxes,) may change. Edges go from
    box `leaves` to box `enters`; those of an agent, step and axis stand together, from `parts`.
    """

    def __init__(self, bodies: Sequence[Body], layers: Sequence[list[Layer]]) -> None:
        self.bodies, self.layers, self.steps = bodies, layers, len(layers[0]) - 1
        self.made = [
            [make_step(body, t, row[t], row[t + 1]) for t in range(self.steps)]
            for body, row in zip(bodies, layers, strict=True)
        ]
        self._number_boxes()
        self._list_edges(self.made)

    def _grids(self) -> list[tuple[int, int, int]]:
        agents = range(len(self.bodies))
        return [(n, t, d) for n in agents for t in range(self.steps + 1) for d in (0, 1)]

    def _number_boxes(self) -> None:
        """Number the axis boxes of all agents; `slopes` (boxes, 2) start from the layers'."""
        grids = [self._grid(*at) for at in self._grids()]
        ends = np.cumsum([0] + [len(g.box) for g in grids])
        self.boxes = {
            at: slice(int(a), int(b))
            for at, a, b in zip(self._grids(), ends[:-1], ends[1:], strict=True)
        }
        self.slopes = np.concatenate([g.slope for g in grids])
        loose = [np.full(len(self._grid(*at).box), 0 < at[1] < self.steps) for at in self._grids()]
        self.loose = np.concatenate(loose)

    def _grid(self, n: int, t: int, d: int) -> AxisGrid:
        return self.layers[n][t].grid(d)

    def _list_edges(self, made: Sequence[Sequence[Step]]) -> None:
        """Axis edges of all agents and steps, one after the other."""
        src, dst, ends, costs, self._first, count = [], [], [], [], {}, 0
        for n, t, d in self._grids():
            if t == self.steps:
                continue
            i, j = (made[n][t].along_x, made[n][t].along_y)[d]
            axis = self.bodies[n].axes[d]
            src.append(self._grid(n, t, d).room[i])
            dst.append(self._grid(n, t + 1, d).room[j])
            ends.append(
                np.stack([i + self.boxes[n, t, d].start, j + self.boxes[n, t + 1, d].start])
            )
            row = (axis.blend, axis.jump, axis.rate_cost[t + 1], axis.change_cost[t])
            costs.append(np.tile(row, (len(i), 1)))
            self._first[n, t, d] = count
            count += len(i)
        self.parts = np.array(list(self._first.values()), np.int64)
        blend, jump, rate_cost, change_cost = np.concatenate(costs).T
        self.blend = blend
        edges = Edges(np.concatenate(src), np.concatenate(dst), blend, jump, rate_cost, change_cost)
        self.corners = corners(edges)
        self.leaves, self.enters = np.concatenate(ends, axis=1)

    def ends(self, slopes: Floats) -> tuple[Floats, Floats]:
        """Slopes at both ends of every edge."""
        return slopes[self.leaves], slopes[self.enters]

    def slips(self, flow: Floats, at: Floats) -> Floats:
        """By how much runs enter each box elsewhere than they leave it: (boxes, 2). flow (edges,):
        share of the runs along each; at (edges, 3): the step that it stands for, as p, w, w'."""
        columns = [
            self._sums(self.enters, flow * into) - self._sums(self.leaves, flow * leave)
            for into, leave in zip(*self.points(at), strict=True)
        ]
        return np.where(self.loose[:, None], np.stack(columns, axis=1), 0.0)

    def points(self, at: Floats) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
        """(p, w) where each step enters, and where it leaves."""
        p, v, w = at.T
        return (p + (1 - self.blend) * v + self.blend * w, w), (p, v)

    def _sums(self, boxes: Ints, values: Floats) -> Floats:
        return np.bincount(boxes, values, minlength=len(self.slopes)).astype(np.float64)
