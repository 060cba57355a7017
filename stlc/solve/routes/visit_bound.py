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


def climb(graph: Priced, most: float, over: Callable[[], bool]) -> float:
    """A bound on what the visits cost, `most` where all ways cost at least that.

    Prices are bettered as long as it is worth it and nobody says `over`.
    """
    if not graph.possible:
        return most
    prices = np.zeros((len(graph.ways.stop), 2, 2))
    best, climbing = max(graph.least(prices), 0.0), tuning.ROUTES
    inner = graph.ways.stop[:, 2] > 0
    prices[inner] = np.random.default_rng(0).normal(scale=_STIR, size=prices[inner].shape)
    for _ in range(climbing.climbs):
        heat, before = climbing.heat * (most - best), best
        if not np.isfinite(heat) or heat <= 0 or over():
            break
        with np.errstate(all="ignore"):
            prices = _ascended(graph, prices, heat)
        best = min(max(best, graph.least(prices)), most)
        graph = graph.below(prices, most)
        if not len(graph.ways.source) or best - before < _WORTH * (most - best):
            break
    return best


def _ascended(graph: Priced, prices: Floats, heat: float) -> Floats:
    found = climbed(lambda z: graph.soft(z, heat), prices, heat, tuning.ROUTES.climb_rounds)
    return found if np.isfinite(found).all() else prices
