"""The joint min-plus programme of two agents over their layers.

A run through boxes may leave one at another point than it entered. That is priced: for any
potentials (a slope on p and one on w for every axis box of each step; 0 at the start and at the
end) the sum over steps of what the arrival point costs less what the departure point costs is 0
on every true run, so adding it to the edges leaves true costs as they are and the least value a
lower bound. The duals of the dynamics rows in an LP relaxation are good potentials to begin with
(`restrict`), an ascent makes them better (`ascent`); any others are as sound.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stlc.arrays import Bools, Floats
from stlc.solve.bounders.chain import Chain
from stlc.solve.relaxation.problem import Body
from stlc.solve.states.layers import Layer


class Joint:
    """Two agents. cost[t] (cells, cells): of their cells at step t + 1; masks[t]: pairs of states
    that are alive, or None for all."""

    def __init__(
        self,
        bodies: tuple[Body, Body],
        layers: tuple[list[Layer], list[Layer]],
        cost: Sequence[Floats],
        masks: Sequence[Bools] | None,
    ) -> None:
        self.layers, self.steps = layers, len(cost)
        self._chains = [Chain(body, row) for body, row in zip(bodies, layers, strict=True)]
        self._weights = [chain.weights() for chain in self._chains]
        self._stage = [self._staged(t, cost[t], masks) for t in range(self.steps)]
        self.ahead: list[Floats] = []
        self.behind: list[Floats] = []

    def _staged(self, t: int, cost: Floats, masks: Sequence[Bools] | None) -> Floats:
        a, b = self.layers[0][t + 1], self.layers[1][t + 1]
        stage = cost[a.cell][:, b.cell]
        if masks is not None:
            stage[~masks[t + 1]] = np.inf
        return stage

    def forward(self) -> float:
        """Least value of all abstract runs: a lower bound."""
        self.ahead = [np.zeros((1, 1))]
        for t in range(self.steps):
            f = self.ahead[-1]
            for chain, weights in zip(self._chains, self._weights, strict=True):
                f = np.ascontiguousarray(chain.onward(t, f, weights).T)
            self.ahead.append(f + self._stage[t])
        return float(self.ahead[-1].min(initial=np.inf))

    def backward(self) -> None:
        """Least cost to go from every pair of states."""
        behind = [np.zeros_like(self._stage[-1])]
        for t in range(self.steps - 1, -1, -1):
            f = behind[-1] + self._stage[t]
            for chain, weights in zip(self._chains, self._weights, strict=True):
                f = np.ascontiguousarray(chain.back(t, f, weights).T)
            behind.append(f)
        self.behind = behind[::-1]

    def through(self, t: int) -> Floats:
        """Lower bound of the runs through each pair of states of layer t."""
        return self.ahead[t] + self.behind[t]

    def path(self) -> list[tuple[int, int]]:
        """States of the best abstract run, by a walk backward over the stored values."""
        last = self.ahead[-1]
        k = np.unravel_index(int(np.argmin(last)), last.shape)
        out = [(int(k[0]), int(k[1]))]
        for t in range(self.steps - 1, -1, -1):
            reach = [
                chain.into(t, out[-1][n], self._weights[n]) for n, chain in enumerate(self._chains)
            ]
            i, j = (np.flatnonzero(np.isfinite(r)) for r in reach)
            value = self.ahead[t][np.ix_(i, j)] + reach[0][i][:, None] + reach[1][j][None]
            k = np.unravel_index(int(np.argmin(value)), value.shape)
            out.append((int(i[k[0]]), int(j[k[1]])))
        return out[::-1]
