"""A bound on the effort of agents with inertia: the cheapest way from visit to visit.

Over the graph of `visits.py` a leg costs what changes of the rate cost along both axes at the least
(`legs.py`). Prices on position and rate at every stop are paid by the leg that arrives and handed
to the one that leaves, so that any prices give a bound; this is the dual of a shortest path through
convex sets (Marcucci, Umenberger, Parrilo and Tedrake 2024), prices shared by all progress at a
stop. They are bettered by L-BFGS on the soft minimum over all ways; arcs that lie on no way below
the cost of a known plan are dropped.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.solve import tuning
from stlc.solve.bounders.ascent import climbed
from stlc.solve.relaxation.problem import Body
from stlc.solve.routes.legs import Corners
from stlc.solve.routes.visits import Ways

_STIR = 1e-3  # first prices: at none at all many corners of a leg are the same
_WORTH = 0.01  # of the gap: a climb that ends less is the last


@dataclass(slots=True, eq=False)
class Priced:
    """The graph with its legs, ready to be priced. Prices are (stops, axes, 2) of p and w."""

    body: Body
    ways: Ways
    groups: list[tuple[Corners, Corners, Ints]] = field(init=False)
    low: Floats = field(init=False)  # (stops, axes, 2)
    high: Floats = field(init=False)
    _layers: list[tuple[slice, Ints, Ints]] = field(init=False)
    _order: Ints = field(init=False)

    def __post_init__(self) -> None:
        ways, axes = self.ways, self.body.axes
        kind, step = ways.stop[:, 1], ways.stop[:, 2]
        self.low, self.high = np.empty((2, len(kind), 2, 2))
        for d, axis in enumerate(axes):
            box = axis.box[step]
            self.low[:, d, 0] = np.maximum(ways.boxes[kind, d, 0], box[:, 0])
            self.high[:, d, 0] = np.minimum(ways.boxes[kind, d, 1], box[:, 1])
            self.low[:, d, 1], self.high[:, d, 1] = box[:, 2], box[:, 3]
            self.low[step == 0, d, 1] = self.high[step == 0, d, 1] = axis.start[1]
        self.high = np.maximum(self.high, self.low)  # they may miss each other by rounding
        lasts = step[ways.legs[:, 1]] - step[ways.legs[:, 0]]
        x, y = ((axis.blend, float(axis.change_cost.min())) for axis in axes)
        self.groups = [
            (Corners.of(int(k), *x), Corners.of(int(k), *y), np.flatnonzero(lasts == k))
            for k in np.unique(lasts)
        ]
        self._sort()

    def _sort(self) -> None:
        """Arcs by source, in layers of one step each, the last first."""
        ways = self.ways
        self._order = np.argsort(ways.source, kind="stable")
        source = ways.source[self._order]
        steps = ways.steps[source]
        self._layers = []
        for t in np.unique(steps)[::-1]:
            own = slice(int(np.searchsorted(steps, t)), int(np.searchsorted(steps, t, "right")))
            first = np.flatnonzero(np.append(True, np.diff(source[own]) > 0))
            self._layers.append((own, source[own][first], first))

    def legs(self, prices: Floats) -> tuple[Floats, Floats]:
        """Cost of each leg (l,) and its derivative by the prices of both its stops (l, axes, 4)."""
        ways = self.ways
        cost, slope = np.zeros(len(ways.legs)), np.zeros((len(ways.legs), 2, 4))
        a, b = ways.legs.T
        for *corners, own in self.groups:
            for d, corner in enumerate(corners):
                ends = [np.concatenate([v[a[own], d], v[b[own], d]], axis=1)
                        for v in (prices, self.low, self.high)]  # fmt: skip
                value, slope[own, d] = corner.least(*ends)
                cost[own] += value
        return cost, slope

    def last(self, prices: Floats) -> tuple[Floats, Floats]:
        """What is handed on at each stop where a way ends: value and derivative."""
        at = np.where(prices > 0, self.low, self.high)
        return (prices * at).sum(axis=(1, 2)), at

    def to_go(self, cost: Floats, last: Floats) -> Floats:
        """Least cost from each node to an end."""
        return self._swept(cost, last, 0.0)

    def so_far(self, cost: Floats) -> Floats:
        """Least cost from the start to each node."""
        ways = self.ways
        found = np.full(len(ways.stops), np.inf)
        found[0] = 0.0
        first = np.flatnonzero(np.append(True, np.diff(ways.target) > 0))
        steps = ways.steps[ways.target]
        begins = np.append(first, len(ways.target))
        layer = np.searchsorted(steps[first], np.unique(steps)) if len(first) else first
        for i, j in zip(layer, np.append(layer[1:], len(first)), strict=True):
            own = slice(int(begins[i]), int(begins[j]))
            value = found[ways.source[own]] + cost[ways.leg[own]]
            found[ways.target[own][first[i:j] - begins[i]]] = np.minimum.reduceat(
                value, first[i:j] - begins[i]
            )
        return found

    def _swept(self, cost: Floats, last: Floats, heat: float) -> Floats:
        """Least, or with heat soft least, cost from each node to an end."""
        ways, order = self.ways, self._order
        found = np.full(len(ways.stops), np.inf)
        found[ways.ends] = last[ways.stops[ways.ends]]
        for own, nodes, first in self._layers:
            arcs = order[own]
            value = cost[ways.leg[arcs]] + found[ways.target[arcs]]
            least = np.minimum(np.minimum.reduceat(value, first), found[nodes])
            if heat > 0:
                spread = np.repeat(least, np.diff(np.append(first, len(arcs))))
                total = np.add.reduceat(np.exp((spread - value) / heat), first)
                total += np.exp((least - found[nodes]) / heat)
                least = least - heat * np.log(total)
            found[nodes] = least
        return found

    def soft(self, prices: Floats, heat: float) -> tuple[float, Floats]:
        """Soft minimum over all ways, and its derivative by the prices."""
        ways, order = self.ways, self._order
        (cost, slope), (last, at) = self.legs(prices), self.last(prices)
        ahead = self._swept(cost, last, heat)
        flow, taken = np.zeros(len(ahead)), np.zeros(len(cost))
        flow[0] = 1.0
        for own, _, _ in reversed(self._layers):
            arcs = order[own]
            leg, source, target = ways.leg[arcs], ways.source[arcs], ways.target[arcs]
            share = flow[source] * np.exp((ahead[source] - cost[leg] - ahead[target]) / heat)
            flow += np.bincount(target, share, minlength=len(flow))
            taken += np.bincount(leg, share, minlength=len(taken))
        ends = ways.stops[ways.ends]
        left = flow[ways.ends] * np.exp((ahead[ways.ends] - last[ends]) / heat)
        out = np.bincount(ends, left, minlength=len(at))[:, None, None] * at
        for side in (0, 1):
            np.add.at(
                out, ways.legs[:, side], taken[:, None, None] * slope[:, :, 2 * side :][:, :, :2]
            )
        out[ways.stop[:, 2] == 0] = 0.0
        return float(ahead[0]), out

    def least(self, prices: Floats) -> float:
        """The least cost of a way: a bound."""
        return float(self.to_go(self.legs(prices)[0], self.last(prices)[0])[0])

    def way(self, prices: Floats) -> Ints:
        """Kinds and steps (k, 2) of the visits of the cheapest way."""
        ways, (last, _) = self.ways, self.last(prices)
        cost = self.legs(prices)[0]
        ahead, ends = self.to_go(cost, last), np.full(len(ways.stops), np.inf)
        ends[ways.ends] = last[ways.stops[ways.ends]]
        node, found = 0, list[Ints]()
        while ends[node] > ahead[node]:
            arcs = self._order[np.searchsorted(ways.source[self._order], [node, node + 1])[0] :]
            arcs = arcs[ways.source[arcs] == node]
            node = int(
                ways.target[arcs[np.argmin(cost[ways.leg[arcs]] + ahead[ways.target[arcs]])]]
            )
            found.append(ways.stop[ways.stops[node], 1:])
        return np.array(found, np.int64).reshape(-1, 2)

    def below(self, prices: Floats, most: float) -> Priced:
        """Without the arcs that lie on no way that costs less than `most`."""
        ways = self.ways
        cost, last = self.legs(prices)[0], self.last(prices)[0]
        through = self.so_far(cost)[ways.source] + cost[ways.leg]
        through += self.to_go(cost, last)[ways.target]
        kept = through < most
        return Priced(self.body, replace(
            ways, source=ways.source[kept], target=ways.target[kept], leg=ways.leg[kept]
        ))  # fmt: skip

    @property
    def possible(self) -> bool:
        """Whether there is any way at all."""
        return len(self.ways.stops) > 0


@dataclass(slots=True, eq=False)
class Climb:
    """Prices of a graph as far as they have risen; `best` is proven for plans that cost less than
    what was known when it was found."""

    graph: Priced
    prices: Floats = field(init=False)
    best: float = 0.0
    _guess: Ints | None = None

    def __post_init__(self) -> None:
        self.prices = np.zeros((len(self.graph.ways.stop), 2, 2))
        inner = self.graph.ways.stop[:, 2] > 0
        if self.graph.possible:
            self.best = max(self.graph.least(self.prices), 0.0)
        stir = np.random.default_rng(0).normal(scale=_STIR, size=self.prices[inner].shape)
        self.prices[inner] = stir

    def guess(self, over: Callable[[], bool]) -> Ints:
        """The cheapest way when prices have risen a little, with no plan known: kinds and steps
        (k, 2) of its visits."""
        if self._guess is not None:
            return self._guess
        rates = np.array([np.abs(axis.box[:, 2:]).max() * axis.change_cost.max()
                          for axis in self.graph.body.axes])  # fmt: skip
        most = float(rates.sum()) * len(self.graph.way(self.prices))
        for _ in range(tuning.ROUTES.guesses):
            if over() or most <= 0:
                break
            self._rise(tuning.ROUTES.heat * most)
            most = max(self.best, _WORTH * most)
        self._guess = self.graph.way(self.prices)
        return self._guess

    def bound(self, most: float, over: Callable[[], bool]) -> float:
        """A bound on what the visits cost, `most` where all ways cost at least that.

        Where prices rise no more, those of all steps of a kind do together once, which sees
        through ways of many lengths that cost nearly the same; then they do with less and less
        heat.
        """
        if not self.graph.possible:
            return most
        heat, together, tried = tuning.ROUTES.heat, False, False
        while heat >= tuning.ROUTES.coldest:
            gap, before = most - self.best, self.best
            if not np.isfinite(gap) or gap <= 0 or over():
                break
            self._rise(heat * gap * (tuning.ROUTES.cooler if together else 1.0), together)
            self.best = min(self.best, most)
            self.graph = self.graph.below(self.prices, most)
            if not len(self.graph.ways.source):
                break
            if self.best - before >= _WORTH * (most - self.best):
                together = False
            else:
                together, tried = not tried, True
                heat *= 1.0 if together else tuning.ROUTES.cooler
        return min(self.best, most)

    def _rise(self, heat: float, together: bool = False) -> None:
        """Better prices by so many steps, those of all steps of a kind as one if asked."""
        groups, stop = np.arange(len(self.prices)), self.graph.ways.stop
        if together:
            groups = np.unique(stop[:, 1] * 2 + (stop[:, 2] == 0), return_inverse=True)[1].ravel()

        def soft(change: Floats) -> tuple[float, Floats]:
            value, slope = self.graph.soft(self.prices + change[groups] * free, heat)
            out = np.zeros_like(change)
            np.add.at(out, groups, slope * free)
            return value, out

        free = (stop[:, 2] > 0)[:, None, None]
        none = np.zeros((groups.max(initial=-1) + 1, 2, 2))
        with np.errstate(all="ignore"):
            found = climbed(soft, none, heat, tuning.ROUTES.climb_rounds)
        if np.isfinite(found).all():
            self.prices = self.prices + found[groups] * free
        self.best = max(self.best, self.graph.least(self.prices))
