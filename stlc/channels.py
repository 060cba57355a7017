"""A mission's channels as numbers: tables over cells, values at true positions.

Encoders and verifier share these as data. Which cells a position touches, how ties are broken
and what is summed is each one's own business.

A table has one axis of cells for each moving end of its pair, in the order of the pair: (n, n)
between two agents, (n,) between an agent and a station, () between two stations.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stlc.errors import StlcError
from stlc.ir.nodes import Link, Quantity, Relation
from stlc.link_places import height_of, link_ends, receiver, true_links, tube_radius
from stlc.mission import Bound, Channel, Mission, TermKind
from stlc.radio.costs import CLAMP, CostName, cost_interval, least_energy, link_cost
from stlc.radio.gp import ChannelModel
from stlc.radio.link_budget import LinkBudget
from stlc.radio.pathloss import link_distance
from stlc.radio.predicates import LinkPredicate, quantity_value, threshold_table
from stlc.radio.predicates import Quantity as RadioQuantity
from stlc.radio.table import BoundName, bound_ends, cost_table

Array = NDArray[np.float64]
Pair = tuple[str, str]

_BOUNDS: dict[Bound, BoundName] = {
    Bound.CENTRE: "centre",
    Bound.MEAN: "mean",
    Bound.WORST: "worst",
}

_FLOORLESS = (CostName.NEG_RSSI, CostName.PAPER_INV_RSSI, CostName.OUTAGE)


@dataclass(frozen=True, slots=True, eq=False)
class Thresholds:
    """Robustness of a link predicate over cells: `low` for where it is needed, `high` for where
    its negation is (they differ only when the bound is WORST)."""

    low: Array
    high: Array


TableMemo = dict[tuple[object, ...], object]
"""Tables by what they depend on, for missions with the same channels and stations."""


@dataclass(slots=True, eq=False)
class ChannelTables:
    """Tables of one mission, each made once. Not safe for use by two threads.

    `memo` may be shared by missions that differ in nothing but agents and requirements.
    """

    mission: Mission
    memo: TableMemo = field(default_factory=dict)

    def cost(self, channel: str, pair: Pair, bound: Bound | None = None) -> Array:
        """Link cost of a pair over cells, by the channel's cost bound unless another is given.

        Raises RadioError when the channel lacks what its cost needs, StlcError when a given
        table doesn't fit the pair.
        """
        found = self.mission.channels[channel]
        chosen = bound or found.cost_bound
        key = ("cost", channel, self._alike(found, pair), chosen)
        if key not in self.memo:
            self.memo[key] = self._cost(found, pair, chosen)
        table = self.memo[key]
        assert isinstance(table, np.ndarray)
        return table

    def thresholds(self, link: Link, bound: Bound | None = None) -> Thresholds:
        """Robustness of a predicate over cells (its shift plays no part), by the channel's bound
        unless another is given. Raises as `cost`."""
        channel = self.mission.channels[link.channel]
        pair = (link.sender, link.receiver)
        what = (link.quantity, link.relation, link.threshold, link.probability)
        chosen = bound or channel.predicate_bound
        beyond = link.tight or self._beyond
        key = ("link", link.channel, self._alike(channel, pair), *what, chosen, beyond)
        if key not in self.memo:
            self.memo[key] = self._thresholds(link, pair, chosen, beyond)
        found = self.memo[key]
        assert isinstance(found, Thresholds)
        if link.factor == 1.0:
            return found
        return Thresholds(link.factor * found.low, link.factor * found.high)

    @property
    def _beyond(self) -> bool:
        """Whether tables must be tight beyond the threshold too: robustness is maximised, or what
        it lacks counts."""
        kinds = {term.kind for term in self.mission.objective}
        return bool(self.mission.preferences) or TermKind.ROBUSTNESS in kinds

    def _alike(self, channel: Channel, pair: Pair) -> tuple[object, ...]:
        """Two pairs of agents share a model's table, unless offsets or heights tell them apart."""
        if channel.has_table(pair) or channel.model is None:
            return pair
        if not all(name in self.mission.agents for name in pair):
            return pair
        heights = tuple(height_of(self.mission, name) for name in pair)
        tubes = tuple(tube_radius(self.mission, name) for name in pair)
        return ("agents", receiver(channel.model, pair), heights, tubes)

    def _cost(self, channel: Channel, pair: Pair, bound: Bound) -> Array:
        if channel.has_table(pair) or channel.model is None:
            return given_table(self.mission, channel, pair)
        model, budget = needed(channel)
        name = CostName(channel.cost)
        if math.isnan(budget.noise_floor) and name not in _FLOORLESS:
            raise StlcError(f"channel {channel.name}: the cost {name.value} needs a noise floor")
        ends = link_ends(self.mission, channel, pair, bound is Bound.WORST)
        values = cost_table(model, ends, name, budget, _BOUNDS[bound]).matrix()
        return _shaped(self.mission, values, pair)

    def _thresholds(self, link: Link, pair: Pair, bound: Bound, beyond: bool) -> Thresholds:
        """Least and greatest excess of a predicate over its threshold, for each pair of cells."""
        channel = self.mission.channels[link.channel]
        if link.quantity is Quantity.COST:
            low, high = self._cost_range(channel, pair, bound)
            if link.relation is Relation.AT_LEAST:
                return Thresholds(low - link.threshold, high - link.threshold)
            return Thresholds(link.threshold - high, link.threshold - low)
        model, budget = needed(channel)
        ends = link_ends(self.mission, channel, pair, bound is Bound.WORST)
        table = threshold_table(
            model, ends, predicate(link, budget), budget, _BOUNDS[bound], beyond
        )
        sides = (table.low.matrix(), table.high.matrix())
        return Thresholds(*(_shaped(self.mission, side, pair) for side in sides))

    def _cost_range(self, channel: Channel, pair: Pair, bound: Bound) -> tuple[Array, Array]:
        """Least and highest cost over cells."""
        if channel.has_table(pair) or bound is not Bound.WORST:
            table = self.cost(channel.name, pair, bound)
            return table, table
        model, budget = needed(channel)
        ends = link_ends(self.mission, channel, pair, True)
        found = bound_ends(model, ends, 0.0)
        least = _least_cost(CostName(channel.cost), found.mean, found.sigma, budget)
        most = cost_interval(CostName(channel.cost), found.mean, found.sigma, budget).values
        low, high = (_shaped(self.mission, side, pair) for side in (least, most))
        return low, high


def needed(channel: Channel) -> tuple[ChannelModel, LinkBudget]:
    """Model and budget of a channel; without a budget the noise floor is NaN, which no table
    takes. Raises StlcError when the channel is given as tables only."""
    if channel.model is None:
        raise StlcError(f"channel {channel.name} is given as a table: only its cost is known")
    return channel.model, channel.budget or LinkBudget(math.nan)


def predicate(link: Link, budget: LinkBudget) -> LinkPredicate:
    """A link predicate in the radio's terms; chance forms become one about RSSI."""
    at_least = link.relation is Relation.AT_LEAST
    if link.probability is None:
        return LinkPredicate(RadioQuantity(link.quantity.value), link.threshold, at_least)
    level = link.threshold
    match link.quantity:
        case Quantity.SNR:
            level += budget.noise_floor
        case Quantity.BER | Quantity.BER_AT_MEAN:
            level, at_least = budget.rssi_for_ber(link.threshold), not at_least
        case Quantity.PRR:
            level = budget.rssi_for_prr(link.threshold)
        case _:
            pass
    return LinkPredicate(RadioQuantity.CHANCE, level, at_least, link.probability)


def _shaped(mission: Mission, values: Array, pair: Pair) -> Array:
    """(na, nb) to one axis for each moving end, in the order of the pair."""
    moving = sum(name in mission.agents for name in pair)
    return values if moving == 2 else values.reshape((-1,) * moving)


def given_table(mission: Mission, channel: Channel, pair: Pair) -> Array:
    """The table that the mission gives for a pair. Raises StlcError when none fits."""
    tables: Mapping[Pair | None, Array] = channel.tables
    both = " and ".join(pair)
    table = tables.get(pair)
    if table is None and pair[::-1] in tables:
        table = np.asarray(tables[pair[::-1]]).T
    if table is None:
        table = tables.get(None)
    if table is None:
        raise StlcError(f"channel {channel.name} has no table for {both}")
    values = np.asarray(table, dtype=np.float64)
    for axis in (1, 0):
        station = mission.stations.get(pair[axis])
        if station is not None and values.ndim == 2:
            cells = channel.partition.cells_at(station.place[: channel.partition.axes])
            values = np.take(values, cells, axis=axis).min(axis=axis)
    return values


def _least_cost(
    cost: CostName, mean: tuple[Array, Array], sigma: tuple[Array, Array], budget: LinkBudget
) -> Array:
    """A lower bound of the cost for mean and sigma anywhere in intervals."""
    if cost is CostName.PAPER_INV_RSSI:
        return np.full_like(mean[0], -CLAMP)
    if cost in (CostName.ETX, CostName.NEG_LOG_PRR):
        from stlc.radio.averages import average_bounds

        most = average_bounds(budget.prr, mean, sigma, decreasing=False)[1]
        with np.errstate(divide="ignore"):
            least = 1.0 / most**2 if cost is CostName.ETX else -np.log(most)
        return np.minimum(least, CLAMP)
    if cost is CostName.ENERGY:
        return least_energy(mean, sigma, budget)
    corners = [link_cost(cost, mean[1], s, budget).values for s in sigma]
    return np.minimum(*corners)


@dataclass(frozen=True, slots=True, eq=False)
class LinkValues:
    """Mean [dBm] and one packet's sigma [dB] of K links, and their length [m]; all (K,)."""

    mean: Array
    sigma: Array
    distance: Array


def true_values(mission: Mission, channel: Channel, pair: Pair, a: Array, b: Array) -> LinkValues:
    """The channel between places a and b (K, 3) [m] of a pair, without any cells."""
    model, _ = needed(channel)
    links = true_links(mission, model, pair, a, b)
    mean, variance = model.predict(links, True, receiver(model, pair))
    return LinkValues(mean, np.sqrt(variance), link_distance(links))


def true_robustness(channel: Channel, link: Link, values: LinkValues) -> Array:
    """Robustness (K,) of a predicate at true positions. Raises RadioError as the radio does."""
    _, budget = needed(channel)
    if link.quantity is Quantity.COST:
        cost = link_cost(CostName(channel.cost), values.mean, values.sigma, budget).values
        at_least = link.relation is Relation.AT_LEAST
        return link.factor * (cost - link.threshold if at_least else link.threshold - cost)
    wanted = predicate(link, budget)
    return link.factor * wanted.robustness(
        quantity_value(wanted, values.mean, values.sigma, budget)
    )
