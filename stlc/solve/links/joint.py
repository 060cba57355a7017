"""The joint min-plus programme of two agents over their layers.

A run through boxes may leave one at another point than it entered. That is priced: for any
potentials pi_t (a slope on p and one on w for each agent, step and axis; pi_0 = pi_T = 0) the sum
over steps of pi_{t+1}.x' - pi_t.x is 0 on every true run, so adding it to the edges leaves true
costs as they are and the least value a lower bound. The duals of the dynamics rows in an LP
relaxation are good potentials; any others are as sound.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stlc.solve.links.boxes import Edges, edge_min
from stlc.solve.links.layers import Layer
from stlc.solve.links.problem import Body, Bools, Floats, Ints, Singles
from stlc.solve.links.steps import both_ways, make_step

SAFETY = 2e-6  # taken off each axis edge: single precision over a whole run


class Joint:
    """Two agents. stage[t] (n, n): cost of their cells at step t + 1; masks[t]: pairs of states
    that are alive, or None for all."""

    def __init__(
        self,
        bodies: tuple[Body, Body],
        layers: tuple[list[Layer], list[Layer]],
        cost: Sequence[Floats],
        masks: Sequence[Bools] | None,
    ) -> None:
        self.bodies, self.layers, self.steps = bodies, layers, len(cost)
        self._steps = [
            [make_step(body, t, row[t], row[t + 1]) for t in range(self.steps)]
            for body, row in zip(bodies, layers, strict=True)
        ]
        self._sweeps = [
            [(both_ways(s.first), both_ways(s.second)) for s in row] for row in self._steps
        ]
        self._stage = [self._staged(t, cost[t], masks) for t in range(self.steps)]
        self._templates()
        self.ahead: list[Singles] = []
        self.behind: list[Singles] = []

    def _staged(self, t: int, cost: Floats, masks: Sequence[Bools] | None) -> Singles:
        a, b = self.layers[0][t + 1], self.layers[1][t + 1]
        stage = cost[a.cell][:, b.cell].astype(np.float32)
        if masks is not None:
            stage[~masks[t + 1]] = np.inf
        return stage

    def _templates(self) -> None:
        """Axis edges of both agents and all steps; equal up to a shift of position share one."""
        rows, shifts, self._where = [], [], []
        for n in (0, 1):
            for t in range(self.steps):
                a, b = self.layers[n][t], self.layers[n][t + 1]
                ways = (
                    (a.x, b.x, self._steps[n][t].along_x),
                    (a.y, b.y, self._steps[n][t].along_y),
                )
                for d, (src, dst, (i, j)) in enumerate(ways):
                    key = np.empty((len(i), 15))
                    key[:, :4], key[:, 4:8] = src.room[i], dst.room[j]
                    key[:, [0, 1, 4, 5]] -= src.room[i, :1]
                    key[:, 8:10], key[:, 10:12] = src.slope[i], dst.slope[j]
                    key[:, 12:] = n, t, d
                    rows.append(key)
                    shifts.append(src.room[i, 0])
                    self._where.append((n, t, d))
        self._cuts = np.cumsum([len(r) for r in rows])[:-1]
        self._shift = np.concatenate(shifts)
        self._keys, self._inverse = _unique_rows(np.concatenate(rows))
        self._ntd = self._keys[:, 12:].astype(int)
        self._edges = self._costed()
        self._weigh()

    def _costed(self) -> Edges:
        n, t, d = self._ntd.T
        axes = [body.axes for body in self.bodies]
        blend = np.array([[axis.blend for axis in row] for row in axes])
        jump = np.array([[axis.jump for axis in row] for row in axes])
        dear = np.array([[axis.dear[1:] for axis in row] for row in axes])
        turn = np.array([[axis.turn for axis in row] for row in axes])
        return Edges(
            self._keys[:, :4], self._keys[:, 4:8], blend[n, d], jump[n, d], dear[n, d, t],
            turn[n, d, t],
        )  # fmt: skip

    def _weigh(self) -> None:
        a0, a1 = self._keys[:, 8:10], self._keys[:, 10:12]
        base = edge_min(self._edges, a0, a1) - SAFETY
        weights = base[self._inverse] + (a1 - a0)[self._inverse, 0] * self._shift
        self._weights: list[list[list[Singles]]] = [
            [[np.empty(0, np.float32)] * 2 for _ in range(self.steps)] for _ in (0, 1)
        ]
        parts = np.split(weights, self._cuts)
        for (agent, step, axis), part in zip(self._where, parts, strict=True):
            self._weights[agent][step][axis] = part.astype(np.float32)

    def forward(self) -> float:
        """Least value of all abstract runs: a lower bound."""
        self.ahead = [np.zeros((1, 1), np.float32)]
        for t in range(self.steps):
            f = self.ahead[-1]
            for n in (0, 1):
                for half in (0, 1):
                    f = self._sweeps[n][t][half][0].apply(f, self._weights[n][t][half])
                f = np.ascontiguousarray(f.T)
            self.ahead.append(f + self._stage[t])
        return float(self.ahead[-1].min(initial=np.inf))

    def backward(self) -> None:
        """Least cost to go from every pair of states."""
        behind = [np.zeros_like(self._stage[-1])]
        for t in range(self.steps - 1, -1, -1):
            f = behind[-1] + self._stage[t]
            for n in (0, 1):
                for half in (1, 0):
                    f = self._sweeps[n][t][half][1].apply(f, self._weights[n][t][half])
                f = np.ascontiguousarray(f.T)
            behind.append(f)
        self.behind = behind[::-1]

    def through(self, t: int) -> Singles:
        """Lower bound of the runs through each pair of states of layer t."""
        return self.ahead[t] + self.behind[t]

    def path(self) -> list[tuple[int, int]]:
        """States of the best abstract run, by a walk backward over the stored values."""
        last = self.ahead[-1]
        k = np.unravel_index(int(np.argmin(last)), last.shape)
        out = [(int(k[0]), int(k[1]))]
        for t in range(self.steps - 1, -1, -1):
            reach = [self._into(n, t, out[-1][n]) for n in (0, 1)]
            i, j = (np.flatnonzero(np.isfinite(r)) for r in reach)
            value = self.ahead[t][np.ix_(i, j)] + reach[0][i][:, None] + reach[1][j][None]
            k = np.unravel_index(int(np.argmin(value)), value.shape)
            out.append((int(i[k[0]]), int(j[k[1]])))
        return out[::-1]

    def _into(self, n: int, t: int, state: int) -> Singles:
        """Weight of the step from every state of layer t to one of layer t + 1."""
        f = np.full((len(self.layers[n][t + 1]), 1), np.inf, np.float32)
        f[state] = 0
        for half in (1, 0):
            f = self._sweeps[n][t][half][1].apply(f, self._weights[n][t][half])
        return f[:, 0]


def _unique_rows(keys: Floats) -> tuple[Floats, Ints]:
    """Rows that differ (rounded to 1e-9), and the inverse map."""
    rounded = np.ascontiguousarray(np.round(keys, 9) + 0.0)
    view = rounded.view([("", rounded.dtype)] * rounded.shape[1]).ravel()
    _, first, inverse = np.unique(view, return_index=True, return_inverse=True)
    return keys[first], inverse
