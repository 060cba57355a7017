"""One agent's abstract steps through its layers, and the weights of their edges."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.solve.relaxation.problem import Body, Singles
from stlc.solve.states.boxes import Edges, corners, edge_min
from stlc.solve.states.layers import Layer
from stlc.solve.states.steps import Reals, both_ways, make_step

SAFETY = 2e-6  # taken off each axis edge
_DELTA = 1e-4  # of a slope, for differences

Weights = list[tuple[Floats, Floats]]
"""For each step those of the edges along x and along y."""
SingleWeights = list[tuple[Singles, Singles]]


class Chain:
    """The layers 0..T of an agent, joined by half-steps. Potentials pi (T+1, 2 axes, 2: slopes on
    p and w), as in `joint`, come with `weights`, on top of those of the boxes: pairs of agents
    share a chain, not its weights."""

    def __init__(self, body: Body, layers: Sequence[Layer]) -> None:
        self.body, self.layers, self.steps = body, layers, len(layers) - 1
        made = [make_step(body, t, layers[t], layers[t + 1]) for t in range(self.steps)]
        self._sweeps = [(both_ways(s.first), both_ways(s.second)) for s in made]
        rows, shifts, self._cuts = [], [], [0]
        for t, step in enumerate(made):
            for d, (i, j) in enumerate((step.along_x, step.along_y)):
                src, dst = layers[t].grid(d).take(i), layers[t + 1].grid(d).take(j)
                key = np.empty((len(i), 14))
                key[:, :4], key[:, 4:8], key[:, 8:10] = src.room, dst.room, (t, d)
                key[:, [0, 1, 4, 5]] -= src.room[:, :1]
                key[:, 10:12], key[:, 12:] = src.slope, dst.slope
                rows.append(key)
                shifts.append(src.room[:, 0])
                self._cuts.append(self._cuts[-1] + len(i))
        self._shift = np.concatenate(shifts)
        keys, self._inverse = _unique_rows(np.concatenate(rows))
        self._at = keys[:, 8:10].astype(int)
        self._corners = corners(self._costed(keys[:, :4], keys[:, 4:8], self._at))
        self._slopes = keys[:, 10:12], keys[:, 12:]

    def _costed(self, src: Floats, dst: Floats, at: Ints) -> Edges:
        """Edges between boxes; at (n, 2): step and axis."""
        t, d = at.T
        axes = self.body.axes
        return Edges(
            src, dst,
            np.array([a.blend for a in axes])[d], np.array([a.jump for a in axes])[d],
            np.array([a.rate_cost[1:] for a in axes])[d, t],
            np.array([a.change_cost for a in axes])[d, t],
        )  # fmt: skip

    def weights(self, pi: Floats | None = None) -> Weights:
        """Least weights of all edges under potentials pi."""
        t, d = self._at.T
        a0, a1 = self._slopes
        if pi is not None:
            a0, a1 = a0 + pi[t, d], a1 + pi[t + 1, d]
        base = self._corners.least(a0, a1)[0] - SAFETY
        all_ = base[self._inverse] + (a1 - a0)[self._inverse, 0] * self._shift
        parts = [all_[low:high] for low, high in zip(self._cuts[:-1], self._cuts[1:], strict=True)]
        return list(zip(parts[::2], parts[1::2], strict=True))

    def onward(self, t: int, values: Reals, weights: Sequence[tuple[Reals, Reals]]) -> Reals:
        """(n', k): least values over the steps t -> t + 1; values (n, k)."""
        for half in (0, 1):
            values = self._sweeps[t][half][0].apply(values, weights[t][half])
        return values

    def back(self, t: int, values: Reals, weights: Sequence[tuple[Reals, Reals]]) -> Reals:
        """(n, k): least values over the steps from t; values (n', k) at t + 1."""
        for half in (1, 0):
            values = self._sweeps[t][half][1].apply(values, weights[t][half])
        return values

    def into(self, t: int, state: int, weights: Sequence[tuple[Reals, Reals]]) -> Reals:
        """(n,): weight of the step from every state of layer t to one of layer t + 1."""
        f = np.full((len(self.layers[t + 1]), 1), np.inf, weights[t][0].dtype)
        f[state] = 0
        return self.back(t, f, weights)[:, 0]

    def slopes(self, pi: Floats, path: Sequence[int]) -> Floats:
        """Derivative of a path's weight by pi, as differences: how far apart the points are at
        which it enters and leaves its boxes."""
        at = np.stack([np.repeat(np.arange(self.steps), 2), np.tile([0, 1], self.steps)], 1)
        boxes = np.array([[layer.x.room[layer.ix[k]], layer.y.room[layer.iy[k]]]
                          for layer, k in zip(self.layers, path, strict=True)])  # fmt: skip
        src, dst = boxes[:-1].reshape(-1, 4), boxes[1:].reshape(-1, 4)
        edges = self._costed(np.tile(src, (5, 1)), np.tile(dst, (5, 1)), np.tile(at, (5, 1)))
        a0, a1 = (
            np.tile(pi[:-1].reshape(-1, 2), (5, 1, 1)),
            np.tile(pi[1:].reshape(-1, 2), (5, 1, 1)),
        )
        for k in (0, 1):
            a0[1 + k, :, k] += _DELTA
            a1[3 + k, :, k] += _DELTA
        value = edge_min(edges, a0.reshape(-1, 2), a1.reshape(-1, 2)).reshape(5, -1, 2)
        change = (value[1:] - value[0]) / _DELTA
        out = np.zeros_like(pi)
        out[:-1] += np.moveaxis(change[:2], 0, -1)
        out[1:] += np.moveaxis(change[2:], 0, -1)
        out[0] = out[-1] = 0.0
        return out


def single(weights: Weights) -> SingleWeights:
    """In single precision."""
    return [(x.astype(np.float32), y.astype(np.float32)) for x, y in weights]


def _unique_rows(keys: Floats) -> tuple[Floats, Ints]:
    """Rows that differ (rounded to 1e-9), and the inverse map."""
    rounded = np.ascontiguousarray(np.round(keys, 9) + 0.0)
    view = rounded.view([("", rounded.dtype)] * rounded.shape[1]).ravel()
    _, first, inverse = np.unique(view, return_index=True, return_inverse=True)
    return keys[first], inverse
