"""Better slopes and prices of a team at once: ascent on the sum of its pairs' soft minima.

Sweeps (`agreement`) and steps along single paths end where many runs of all pairs cost the same.
The soft minima of `ascent` tell over all runs how much further on boxes are entered than left, and
how often each pair of an agent has it in a state; both say at once how to go on. An agent has the
same slope in a box whatever the pair, on top of each pair's potentials. Whatever comes out is a
bound: it only moves prices that add up to nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from stlc.arrays import Floats
from stlc.solve import tuning
from stlc.solve.bounders.agreement import Agreement, Pair, Prices
from stlc.solve.bounders.arcs import Arcs
from stlc.solve.bounders.ascent import climbed, softened
from stlc.solve.bounders.shares import lighter
from stlc.solve.states.layers import Layer


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """A pair's runs; `base`: costs at every stop without prices."""

    pair: Pair
    arcs: Arcs
    base: list[Floats]


class TeamAscent:
    """Over what is alive in an agreement. A point (n,) holds the slopes of all agents' boxes, the
    pairs' potentials and the prices on states, each where `_at` says."""

    def __init__(self, agreement: Agreement) -> None:
        self.agreement, self.steps = agreement, agreement.steps
        self._at: dict[tuple[object, ...], slice] = {}
        self._size = 0
        self.parts = [self._part(pair) for pair in agreement.pairs]
        self._place()

    def _part(self, pair: Pair) -> _Part:
        made, nothing = self.agreement, np.zeros((self.agreement.problem.cells,) * 2)
        bodies = [lighter(made.problem.bodies[n], len(made.own[n])) for n in pair]
        base = made.costs(pair)
        arcs = Arcs(
            (bodies[0], bodies[1]), (list(made.rows[pair[0]]), list(made.rows[pair[1]])),
            [nothing] * self.steps, [np.isfinite(v) for v in base],
        )  # fmt: skip
        stops = [v[s.i, s.j].astype(float) for v, s in zip(base, arcs.stops, strict=True)]
        return _Part(pair, arcs, stops)

    def _place(self) -> None:
        """Say where slopes, potentials and prices stand in a point; those that stay 0 do not."""
        made = self.agreement
        for n, row in enumerate(made.rows):
            for t in range(1, self.steps):
                for d in (0, 1):
                    self._room((n, t, d), 2 * len(row[t].grid(d).box))
        for pair in made.pairs:
            self._room(pair, 8 * (self.steps - 1))
            for end, n in enumerate(pair):
                for t in range(1, self.steps + 1):
                    self._room((pair, end, t), len(made.rows[n][t]))

    def _room(self, key: tuple[object, ...], size: int) -> None:
        self._at[key] = slice(self._size, self._size + size)
        self._size += size

    @property
    def empty(self) -> bool:
        """Whether some pair has no run."""
        return any(part.arcs.empty for part in self.parts)

    def start(self) -> Floats:
        """The point that the agreement stands at."""
        z, made = np.zeros(self._size), self.agreement
        for n, row in enumerate(made.rows):
            for t in range(1, self.steps):
                for d in (0, 1):
                    z[self._at[n, t, d]] = row[t].grid(d).slope.ravel()
        for pair in made.pairs:
            z[self._at[pair]] = made.prices.potentials[pair][:, 1:-1].ravel()
            for end, states in enumerate(made.prices.states[pair]):
                for t, prices in enumerate(states[1:], start=1):
                    z[self._at[pair, end, t]] = np.where(np.isfinite(prices), prices, 0.0)
        return z

    def climb(self, stopped: Callable[[], bool], gap: float) -> tuple[list[list[Layer]], Prices]:
        """Layers with slopes, and prices, of the highest least value found; ends when a stage
        raises it by too little. gap: what it may still rise by."""
        z = best = self.start()
        least, part, rising = self.least(z), tuning.TEAM.heat, False
        while part >= tuning.TEAM.coldest and not stopped():
            z = self._stage(z, part * gap / len(self.parts))
            value = self.least(z) if np.isfinite(z).all() else -np.inf
            enough = value >= least + tuning.TEAM.worth * gap
            if value > least:
                best, least = z, value
            if rising and not enough:
                break
            part, rising = part * tuning.TEAM.cooler, rising or enough
        return self._taken(best)

    def _stage(self, z: Floats, heat: float) -> Floats:
        """Steps from a point at one heat of each pair."""
        with np.errstate(all="ignore"):
            return climbed(
                lambda point: self._softened(point, heat), z, heat * len(self.parts),
                tuning.TEAM.stage_rounds,
            )  # fmt: skip

    def least(self, z: Floats) -> float:
        """Sum of the pairs' least values."""
        self._set(z)
        return sum(part.arcs.through()[0] for part in self.parts)

    def _set(self, z: Floats) -> None:
        """Put the slopes and prices of a point into the pairs' arcs and stops."""
        for part in self.parts:
            arcs, slopes = part.arcs, np.zeros_like(part.arcs.slopes)
            pi = z[self._at[part.pair]].reshape(2, self.steps - 1, 2, 2)
            for (end, t, d), where in arcs.boxes.items():
                if 0 < t < self.steps:
                    own = z[self._at[part.pair[end], t, d]].reshape(-1, 2)
                    slopes[where] = own + pi[end, t - 1, d]
            arcs.slopes = slopes
            for t in range(1, self.steps + 1):
                stop = arcs.stops[t]
                first, second = (z[self._at[part.pair, end, t]] for end in (0, 1))
                cost = part.base[t] + first[stop.i] + second[stop.j]
                arcs.stops[t] = replace(stop, cost=cost)

    def _softened(self, z: Floats, heat: float) -> tuple[float, Floats]:
        """Sum of the pairs' soft minima and its derivative, along which prices stay balanced."""
        self._set(z)
        total, slope = 0.0, np.zeros(self._size)
        for part in self.parts:
            value, slips, shares = softened(part.arcs, part.arcs.slopes, heat)
            total += value
            pi = np.zeros((2, self.steps - 1, 2, 2))
            for (end, t, d), where in part.arcs.boxes.items():
                if 0 < t < self.steps:
                    slope[self._at[part.pair[end], t, d]] += slips[where].ravel()
                    pi[end, t - 1, d] = slips[where].sum(0)
            slope[self._at[part.pair]] = pi.ravel()
            for t in range(1, self.steps + 1):
                stop = part.arcs.stops[t]
                for end, states in enumerate((stop.i, stop.j)):
                    at = self._at[part.pair, end, t]
                    slope[at] = np.bincount(states, shares[t], minlength=at.stop - at.start)
        self._balance(slope)
        return total, slope

    def _balance(self, slope: Floats) -> None:
        """Prices of an agent's states are to add up to nothing over its pairs."""
        for n, own in enumerate(self.agreement.own):
            for t in range(1, self.steps + 1):
                places = [self._at[pair, pair.index(n), t] for pair in own]
                mean = np.mean([slope[at] for at in places], axis=0) if places else 0.0
                for at in places:
                    slope[at] -= mean

    def _taken(self, z: Floats) -> tuple[list[list[Layer]], Prices]:
        """A point as layers with slopes, and as prices."""
        made, last = self.agreement, self.steps
        rows = [
            [
                layer if t in (0, last)
                else layer.priced(*(z[self._at[n, t, d]].reshape(-1, 2) for d in (0, 1)))
                for t, layer in enumerate(row)
            ]
            for n, row in enumerate(made.rows)
        ]  # fmt: skip
        potentials = {pair: np.zeros_like(pi) for pair, pi in made.prices.potentials.items()}
        for pair, pi in potentials.items():
            pi[:, 1:-1] = z[self._at[pair]].reshape(2, last - 1, 2, 2)
        states = {
            pair: tuple(
                [ends[0], *(z[self._at[pair, end, t]] for t in range(1, last + 1))]
                for end, ends in enumerate(old)
            )
            for pair, old in made.prices.states.items()
        }
        return rows, Prices(potentials, {p: (v[0], v[1]) for p, v in states.items()})
