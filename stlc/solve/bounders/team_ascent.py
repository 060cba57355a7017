"""Better slopes and prices of a team at once: ascent on the sum of its pairs' soft minima.

Sweeps (`agreement`) and steps along single paths end where many runs of all pairs cost the same.
The soft minima of `ascent` tell over all runs how much further on boxes are entered than left, and
how often each pair of an agent has it in a state; both say at once how to go on. An agent has the
same slope in a box whatever the pair, on top of each pair's potentials. Whatever comes out is a
bound: it only moves prices that add up to nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.solve import tuning
from stlc.solve.bounders.agreement import Agreement, Pair, Prices
from stlc.solve.bounders.ascent import climbed
from stlc.solve.bounders.shares import lighter
from stlc.solve.bounders.tables import Moves, Soft, Tables
from stlc.solve.states.layers import Layer


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A pair's runs; `base`: costs at every stop without prices."""

    pair: Pair
    tables: Tables
    base: list[Floats]


class TeamAscent:
    """Over what is alive in an agreement. A point (n,) holds the slopes of all agents' boxes, the
    pairs' potentials and the prices on states, each where `_at` says."""

    def __init__(self, agreement: Agreement) -> None:
        self.agreement, self.steps = agreement, agreement.steps
        self.moves = [
            Moves(lighter(body, max(1, len(own))), list(row))
            for body, own, row in zip(
                agreement.problem.bodies, agreement.own, agreement.rows, strict=True
            )
        ]
        self._moments = [_moments(moves) for moves in self.moves]
        self._at: dict[tuple[object, ...], slice] = {}
        self._size = 0
        self.parts = [self._part(pair) for pair in agreement.pairs]
        self._place()

    def _part(self, pair: Pair) -> Part:
        base = [v.astype(float) for v in self.agreement.costs(pair)]
        return Part(pair, Tables(*(self.moves[n] for n in pair)), base)

    def _place(self) -> None:
        """Say where slopes, potentials and prices stand in a point."""
        made = self.agreement
        for n, moves in enumerate(self.moves):
            self._room((n,), moves.slopes.size)
        for pair in made.pairs:
            self._room(pair, made.prices.potentials[pair].size)
            for end, n in enumerate(pair):
                for t in range(1, self.steps + 1):
                    self._room((pair, end, t), len(made.rows[n][t]))

    def _room(self, key: tuple[object, ...], size: int) -> None:
        self._at[key] = slice(self._size, self._size + size)
        self._size += size

    def start(self) -> Floats:
        """The point that the agreement stands at."""
        z, made = np.zeros(self._size), self.agreement
        for n, moves in enumerate(self.moves):
            z[self._at[n,]] = moves.slopes.ravel()
        for pair in made.pairs:
            z[self._at[pair]] = made.prices.potentials[pair].ravel()
            for end, states in enumerate(made.prices.states[pair]):
                for t, prices in enumerate(states[1:], start=1):
                    z[self._at[pair, end, t]] = np.where(np.isfinite(prices), prices, 0.0)
        return z

    def climb(self, stopped: Callable[[], bool], gap: float) -> tuple[Floats, float]:
        """The point of the highest least value found, and the last heat; ends when a stage raises
        it by too little. gap: what it may still rise by."""
        z = best = self.start()
        least, part, rising = self.least(z), tuning.TEAM.heat, False
        heat = part * gap / len(self.parts)
        while part >= tuning.TEAM.coldest and not stopped():
            z = self._stage(z, part * gap / len(self.parts))
            value = self.least(z) if np.isfinite(z).all() else -np.inf
            enough = value >= least + tuning.TEAM.worth * gap
            if value > least:
                best, least, heat = z, value, part * gap / len(self.parts)
            if rising and not enough:
                break
            part, rising = part * tuning.TEAM.cooler, rising or enough
        return best, heat

    def _stage(self, z: Floats, heat: float) -> Floats:
        """Steps from a point at one heat of each pair."""
        with np.errstate(all="ignore"):
            return climbed(
                lambda point: self._softened(point, heat), z, heat * len(self.parts),
                tuning.TEAM.stage_rounds,
            )  # fmt: skip

    def least(self, z: Floats) -> float:
        """Sum of the pairs' least values; infinite where some pair has no run."""
        return sum(
            part.tables.least(self._slopes(part, z), self._stops(part, z)) for part in self.parts
        )

    def _slopes(self, part: Part, z: Floats) -> tuple[Floats, Floats]:
        """Those of a pair's boxes: their agent's, and the pair's potentials."""
        pi = z[self._at[part.pair]].reshape(2, -1, 2)
        first, second = (
            z[self._at[n,]].reshape(-1, 2) + pi[end, self._moments[n]]
            for end, n in enumerate(part.pair)
        )
        return first, second

    def _stops(self, part: Part, z: Floats) -> list[Floats]:
        """What a pair's states cost at every step, with their prices."""
        out = part.base[:1]
        for t, base in enumerate(part.base[1:], start=1):
            first, second = (z[self._at[part.pair, end, t]] for end in (0, 1))
            out.append(base + first[:, None] + second[None])
        return out

    def softened(self, z: Floats, heat: float) -> Iterator[tuple[Part, Soft]]:
        """The soft minimum of every pair."""
        for part in self.parts:
            yield part, part.tables.softened(self._slopes(part, z), self._stops(part, z), heat)

    def _softened(self, z: Floats, heat: float) -> tuple[float, Floats]:
        """Sum of the pairs' soft minima and its derivative, along which prices stay balanced."""
        total, slope = 0.0, np.zeros(self._size)
        for part, found in self.softened(z, heat):
            total += found.value
            self._add(slope, part, found)
        self._balance(slope)
        return total, slope

    def _add(self, slope: Floats, part: Part, found: Soft) -> None:
        """The derivative of one pair's soft minimum."""
        pi = slope[self._at[part.pair]].reshape(2, -1, 2)
        for end, n in enumerate(part.pair):
            slips = self.moves[n].slips(found.flows[end], found.at[end])
            slope[self._at[n,]] += slips.ravel()
            np.add.at(pi[end], self._moments[n], slips)
            for t in range(1, self.steps + 1):
                slope[self._at[part.pair, end, t]] = found.shares[t].sum(1 - end)

    def _balance(self, slope: Floats) -> None:
        """Prices of an agent's states are to add up to nothing over its pairs."""
        for n, own in enumerate(self.agreement.own):
            for t in range(1, self.steps + 1):
                places = [self._at[pair, pair.index(n), t] for pair in own]
                mean = np.mean([slope[at] for at in places], axis=0) if places else 0.0
                for at in places:
                    slope[at] -= mean

    def taken(self, z: Floats) -> tuple[list[list[Layer]], Prices]:
        """A point as layers with slopes, and as prices."""
        made = self.agreement
        rows = [moves.priced(z[self._at[n,]].reshape(-1, 2)) for n, moves in enumerate(self.moves)]
        potentials = {
            pair: z[self._at[pair]].reshape(pi.shape) for pair, pi in made.prices.potentials.items()
        }
        states = {
            pair: tuple(
                [ends[0], *(z[self._at[pair, end, t]] for t in range(1, self.steps + 1))]
                for end, ends in enumerate(old)
            )
            for pair, old in made.prices.states.items()
        }
        return rows, Prices(potentials, {p: (v[0], v[1]) for p, v in states.items()})


def _moments(moves: Moves) -> Ints:
    """(boxes,): 2 t + d of every box."""
    out = np.empty(len(moves.slopes), np.int64)
    for (_, t, d), where in moves.boxes.items():
        out[where] = 2 * t + d
    return out
