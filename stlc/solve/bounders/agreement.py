"""A bound for many agents: the pairs as subproblems that must agree on every agent's states.

The cost of a plan is the sum over pairs of what the pair costs, each agent's own cost divided
among its pairs. Prices that add up to 0 over the pairs of an agent may be put on its states at
each step: the sum stays as it is, so the pairs' least values still add up to a bound of the whole.
Sweeps over the steps set the prices so that an agent's least values through a state (its
min-marginals) are the same in all its pairs; the bound never falls. This is sequential tree-
reweighted message passing (Kolmogorov 2006) with pairs of agents as chains. Between sweeps the
potentials of each pair (see `joint`) follow a subgradient.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.solve.bounders.chain import Chain, SingleWeights, single
from stlc.solve.bounders.shares import lighter, pair_share, stage_cost
from stlc.solve.relaxation.problem import Problem, Singles
from stlc.solve.states.layers import Layer

Pair = tuple[int, int]
_UNIT = 2.0**-24  # of single precision
_ROUNDINGS = 8  # a step
_MARGIN = 1e-5
T = TypeVar("T")


@dataclass(slots=True)
class Prices:
    """potentials[pair] (2, T+1, 2, 2); states[pair][end][t] (n,)."""

    potentials: dict[Pair, Floats]
    states: dict[Pair, tuple[list[Floats], list[Floats]]]


def no_prices(pairs: Sequence[Pair], rows: Sequence[Sequence[Layer]]) -> Prices:
    """All prices 0."""
    steps = len(rows[0])
    zeros = {p: [[np.zeros(len(layer)) for layer in rows[n]] for n in p] for p in pairs}
    return Prices(
        {p: np.zeros((2, steps, 2, 2)) for p in pairs}, {p: (v[0], v[1]) for p, v in zeros.items()}
    )


class Agreement:
    """Pairs of agents over the agents' layers. `bound` is the best found so far."""

    def __init__(
        self, problem: Problem, rows: Sequence[Sequence[Layer]], prices: Prices,
        masks: dict[Pair, list[Bools]] | None, pool: Executor,
    ) -> None:  # fmt: skip
        self.problem, self.rows, self.steps = problem, list(rows), problem.steps
        self.prices = Prices(
            dict(prices.potentials), {p: (list(a), list(b)) for p, (a, b) in prices.states.items()}
        )
        self.pairs = list(problem.pairs)
        self.own = [[p for p in self.pairs if i in p] for i in range(len(problem.bodies))]
        self.chains = [
            Chain(lighter(body, max(1, len(own))), row)
            for body, own, row in zip(problem.bodies, self.own, rows, strict=True)
        ]
        self.lonely = _lonely(problem, self.own)
        self._pool = pool
        self._base = {p: self._costs(p, None if masks is None else masks[p]) for p in self.pairs}
        self._weights: dict[Pair, tuple[SingleWeights, SingleWeights]] = {}
        self._weigh()
        self._table: dict[Pair, list[Singles]] = {}
        self._margin = 0.0
        self.bound = -np.inf

    def _costs(self, pair: Pair, masks: list[Bools] | None) -> list[Singles]:
        part, out = pair_share(self.problem, pair), [np.zeros((1, 1), np.float32)]
        for t in range(1, self.steps + 1):
            a, b = (self.rows[n][t].cell for n in pair)
            out.append(stage_cost(part, t).astype(np.float32)[a][:, b])
            if masks is not None:
                out[t][~masks[t]] = np.inf
        return out

    def costs(self, pair: Pair) -> list[Singles]:
        """Of the pair's states at each step without prices, infinite where they are dropped."""
        return self._base[pair]

    def move(self, change: dict[Pair, Floats]) -> None:
        """Add to the potentials."""
        for p in self.pairs:
            self.prices.potentials[p] = self.prices.potentials[p] + change[p]
        self._weigh()

    def _weigh(self) -> None:
        for p in self.pairs:
            pi = self.prices.potentials[p]
            self._weights[p] = (
                single(self.chains[p[0]].weights(pi[0])), single(self.chains[p[1]].weights(pi[1])),
            )  # fmt: skip

    def _each(self, work: Callable[[Pair], T]) -> dict[Pair, T]:
        return dict(zip(self.pairs, self._pool.map(work, self.pairs), strict=True))

    # -- sweeps -------------------------------------------------------------------------------
    def _stage(self, pair: Pair, t: int) -> Singles:
        first, second = self.prices.states[pair]
        stage = self._base[pair][t] + first[t].astype(np.float32)[:, None]
        stage += second[t].astype(np.float32)[None]
        return stage

    def _onward(self, pair: Pair, t: int, values: Singles) -> Singles:
        for n, weights in zip(pair, self._weights[pair], strict=True):
            values = np.ascontiguousarray(self.chains[n].onward(t, values, weights).T)
        return values

    def _back(self, pair: Pair, t: int, values: Singles) -> Singles:
        for n, weights in zip(pair, self._weights[pair], strict=True):
            values = np.ascontiguousarray(self.chains[n].back(t, values, weights).T)
        return values

    def prepare(self) -> float:
        """Least costs to go under the prices as they are; the bound."""

        def work(pair: Pair) -> list[Singles]:
            """Cost-to-go of a pair at each step, swept back from the last."""
            ends = tuple(len(self.rows[n][-1]) for n in pair)
            out = [np.zeros(ends, np.float32)]
            for t in range(self.steps - 1, -1, -1):
                out.append(self._back(pair, t, out[-1] + self._stage(pair, t + 1)))
            return out[::-1]

        self._table = self._each(work)
        return self._settled({p: self._table[p][0] for p in self.pairs})

    def forward(self, cutoff: float = np.inf) -> float:
        """From costs to go to costs so far, prices on the way; the bound. Pairs of states that
        lie on no plan below the cutoff are dropped."""
        for t in range(1, self.steps + 1):

            def work(pair: Pair, t: int = t) -> tuple[Singles, Singles]:
                """A pair's cost up to step t, and the cost of its best run through each state pair
                there."""
                before = self._table[pair][t - 1]
                if t > 1:
                    before = before + self._stage(pair, t - 1)
                ahead = self._onward(pair, t - 1, before if t > 1 else np.zeros_like(before))
                return ahead, ahead + self._stage(pair, t) + self._table[pair][t]

            found = self._each(work)
            through = {p: v[1] for p, v in found.items()}
            self._agree(t, through)
            if np.isfinite(cutoff):
                self._drop(t, through, cutoff)
            for p in self.pairs:
                self._table[p][t] = found[p][0]
        last = self.steps
        return self._settled({p: self._table[p][last] + self._stage(p, last) for p in self.pairs})

    def backward(self) -> float:
        """From costs so far to costs to go, prices on the way; the bound."""
        behind = {p: np.zeros_like(self._table[p][-1]) for p in self.pairs}
        for t in range(self.steps, 0, -1):
            through = {p: self._table[p][t] + self._stage(p, t) + behind[p] for p in self.pairs}
            self._agree(t, through)
            for p in self.pairs:
                self._table[p][t] = behind[p]

            def work(pair: Pair, t: int = t, last: dict[Pair, Singles] = behind) -> Singles:
                """A pair's cost-to-go from step t - 1, given the one from t."""
                return self._back(pair, t - 1, last[pair] + self._stage(pair, t))

            behind = self._each(work)
        for p in self.pairs:
            self._table[p][0] = behind[p]
        return self._settled(behind)

    def _agree(self, t: int, through: dict[Pair, Singles]) -> None:
        """Prices that make an agent's min-marginals at t equal in all its pairs."""
        for i, own in enumerate(self.own):
            found = [through[p].min(int(p[0] == i), initial=np.inf).astype(float) for p in own]
            mean = np.mean(found, axis=0) if own else np.empty(0)
            fine = np.isfinite(mean)
            for p, marginal in zip(own, found, strict=True):
                end = int(p[1] == i)
                change = np.where(fine, mean, 0.0) - np.where(fine, marginal, 0.0)
                states = self.prices.states[p][end]
                states[t] = np.where(fine, states[t] + change, np.inf)
                step = np.where(fine, change, np.inf).astype(np.float32)
                through[p] += step[:, None] if end == 0 else step[None]

    def _drop(self, t: int, through: dict[Pair, Singles], cutoff: float) -> None:
        """Any plan costs the pair's least value through its states, and the other pairs' least
        values through the state of the agent that they share with it, or at all."""
        least = {p: (v.min(1, initial=np.inf), v.min(0, initial=np.inf))
                 for p, v in through.items()}  # fmt: skip
        total = [sum((least[p][int(p[1] == i)] for p in own), np.float32(0))
                 for i, own in enumerate(self.own)]  # fmt: skip
        value = {p: v[0].min(initial=np.inf) for p, v in least.items()}
        room = cutoff - self.lonely + 2 * self._margin + _MARGIN
        for p in self.pairs:
            others = sum(v for q, v in value.items() if not set(p) & set(q))
            with np.errstate(invalid="ignore"):
                first, second = (total[n] - least[p][e] for e, n in enumerate(p))
            cost = through[p] + (first[:, None] + np.float32(others))
            cost += second[None]
            self._base[p][t][~(cost <= room)] = np.inf

    def _settled(self, ends: dict[Pair, Singles]) -> float:
        """The sum of the pairs' least values, float errors taken off."""
        self.values = {p: float(v.min(initial=np.inf)) for p, v in ends.items()}
        bound = sum(self.values.values()) + self.lonely
        if not np.isfinite(bound):
            self.bound = np.inf
            return self.bound
        self._margin = len(self.pairs) * self._error()
        bound -= self._margin
        self.bound = max(self.bound, bound)
        return bound

    def _error(self) -> float:
        """Of one pair's value: roundings of the partial sums along its best run."""
        size = 0.0
        for p in self.pairs:
            least = [float(v.min()) for v in self._table[p]]
            prices = [np.abs(s[np.isfinite(s)]).max(initial=0.0)
                      for end in self.prices.states[p] for s in end]  # fmt: skip
            size = max(size, 2 * float(np.abs(least).max()) + 2 * max(prices))
        return float(_UNIT * _ROUNDINGS * self.steps * size)

    # -- what is left -------------------------------------------------------------------------
    def masks(self) -> dict[Pair, list[Bools]]:
        """Pairs of states that are alive at each step."""
        return {p: [np.isfinite(v) for v in base] for p, base in self._base.items()}

    def alive(self) -> list[list[Bools]]:
        """For each agent and step the states that are alive in all its pairs."""
        return [
            [
                np.logical_and.reduce(
                    [np.isfinite(self._base[p][t]).any(int(p[0] == i)) for p in own]
                    or [np.ones(len(layer), bool)]
                )
                for t, layer in enumerate(self.rows[i])
            ]
            for i, own in enumerate(self.own)
        ]

    def least_by(self, i: int, groups: Ints) -> Floats:
        """Bounds on what plans cost that end in each group of agent i's states, groups (n,) from
        0; after a forward sweep."""
        others = sum(self.values[p] for p in self.pairs if i not in p)
        out = np.full(int(groups.max()) + 1, others + self.lonely - self._margin)
        for p in self.own[i]:
            ends = self._table[p][-1] + self._stage(p, self.steps)
            least = np.full(len(out), np.inf)
            np.minimum.at(least, groups, ends.min(int(p[0] == i), initial=np.inf))
            out += least
        return out

    # -- potentials ---------------------------------------------------------------------------
    def path(self, pair: Pair) -> list[tuple[int, int]]:
        """States of a pair's best abstract run, after a forward sweep."""
        value = self._table[pair][-1] + self._stage(pair, self.steps)
        k = np.unravel_index(int(np.argmin(value)), value.shape)
        out = [(int(k[0]), int(k[1]))]
        for t in range(self.steps - 1, 0, -1):
            into = [self.chains[n].into(t, out[-1][e], self._weights[pair][e])
                    for e, n in enumerate(pair)]  # fmt: skip
            i, j = (np.flatnonzero(np.isfinite(v)) for v in into)
            value = (self._table[pair][t] + self._stage(pair, t))[np.ix_(i, j)]
            value = value + into[0][i][:, None] + into[1][j][None]
            k = np.unravel_index(int(np.argmin(value)), value.shape)
            out.append((int(i[k[0]]), int(j[k[1]])))
        return [(0, 0), *out[::-1]]

    def slopes(self, pair: Pair) -> Floats:
        """Subgradient (2, T+1, 2, 2) of a pair's value by its potentials."""
        pi, path = self.prices.potentials[pair], self.path(pair)
        return np.stack([
            self.chains[n].slopes(pi[e], [k[e] for k in path]) for e, n in enumerate(pair)
        ])  # fmt: skip


def _lonely(problem: Problem, own: Sequence[Sequence[Pair]]) -> float:
    """Costs outside all pairs: `rest`, and the least station costs of agents without a pair."""
    return problem.rest + sum(
        float(costs[problem.owner >= 0].min())
        for i, pairs in enumerate(own) if not pairs
        for costs in problem.alone[i] if costs is not None
    )  # fmt: skip
