"""Link quality on the cell model and at true positions.

Tables and the channel's posterior come from the radio as data; which cells a position touches
and how ties are broken is decided here: a predicate takes the best of the touching cells, a cost
the cheapest.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stlc.channels import LinkValues, true_robustness, true_values
from stlc.ir.nodes import Link, Quantity, walk
from stlc.mission import Channel, Mission, TermKind
from stlc.plan import LinkSeries
from stlc.verify.subject import Array, Subject
from stlc.verify.trace import LinkEvaluator
from stlc.verify.tubes import half_widths
from stlc.verify.walls import losses

Pair = tuple[str, str]
Pick = Literal["least", "greatest"]

TOUCH = 1e-6
"""A position this close [m] to a cell counts as in it."""


@dataclass(slots=True, eq=False)
class CellModel:
    """Looks positions up in tables."""

    subject: Subject
    _touched: dict[tuple[str, str], NDArray[np.bool_]] = field(default_factory=dict)

    def touched(self, channel: Channel, agent: str) -> NDArray[np.bool_]:
        """Which cells the agent touches (T+1, cells)."""
        key = (channel.name, agent)
        if key not in self._touched:
            place = self.subject.positions[agent]
            inside = np.ones((len(place), len(channel.partition.boxes)), dtype=np.bool_)
            for axis in range(channel.partition.boxes.shape[1] // 2):
                low, high = channel.partition.boxes[:, 2 * axis : 2 * axis + 2].T
                at = place[:, axis : axis + 1]
                inside &= (at >= low - TOUCH) & (at <= high + TOUCH)
            self._touched[key] = inside
        return self._touched[key]

    def lookup(self, channel: Channel, pair: Pair, table: Array, pick: Pick) -> Array:
        """The least or greatest of the touching entries (T+1,); NaN outside every cell."""
        length = self.subject.mission.horizon + 1
        moving = [name for name in pair if name in self.subject.mission.agents]
        if not moving:
            return np.full(length, float(table))
        masks = [self.touched(channel, name) for name in moving]
        counts = [mask.sum(axis=1) for mask in masks]
        first = tuple(mask.argmax(axis=1) for mask in masks)
        out = np.asarray(table[first], dtype=np.float64).copy()
        out[np.any([count == 0 for count in counts], axis=0)] = np.nan
        choose = np.min if pick == "least" else np.max
        for t in np.flatnonzero(np.prod(counts, axis=0) > 1):
            cells = np.ix_(*(np.flatnonzero(mask[t]) for mask in masks))
            out[t] = choose(table[cells])
        return out

    def robustness(self, link: Link, positive: bool) -> Array:
        """Robustness (T+1,) of a predicate; outside every cell it counts as lost."""
        channel = self.subject.mission.channels[link.channel]
        table = self.subject.tables.thresholds(link)
        pair = (link.sender, link.receiver)
        if positive:
            value, lost = self.lookup(channel, pair, table.low, "greatest"), -np.inf
        else:
            value, lost = self.lookup(channel, pair, table.high, "least"), np.inf
        return np.where(np.isnan(value), lost, value)

    def cost(self, channel: Channel, pair: Pair, pick: Pick) -> Array:
        """Link cost (T+1,); NaN outside every cell."""
        return self.lookup(channel, pair, self.subject.tables.cost(channel.name, pair), pick)


@dataclass(slots=True, eq=False)
class TrueModel:
    """Evaluates the channel itself, without any cells."""

    subject: Subject
    cells: CellModel
    _values: dict[tuple[str, Pair], LinkValues] = field(default_factory=dict)

    def values(self, channel: Channel, pair: Pair) -> LinkValues:
        """Mean, sigma and length of a pair's link at each step."""
        key = (channel.name, pair)
        if key not in self._values:
            places = self.subject.places
            ends = [places[name] for name in pair]
            mission = self.subject.mission
            walls = None if channel.model is None else channel.model.walls
            found = true_values(mission, _bare(channel), pair, *ends)
            if walls is not None:
                loss = dict(zip(walls.names, map(float, walls.loss), strict=True))
                found = replace(found, mean=found.mean - losses(mission.walls, loss, *ends))
            self._values[key] = found
        return self._values[key]

    def robustness(self, link: Link, positive: bool) -> Array:
        """Robustness (T+1,); of costs given as a table, that of the table."""
        channel = self.subject.mission.channels[link.channel]
        pair = (link.sender, link.receiver)
        given = link.quantity is Quantity.COST and channel.has_table(pair)
        if given or channel.model is None:
            return self.cells.robustness(link, positive)
        found = [true_robustness(channel, link, v) for v in self._anywhere(channel, pair)]
        return np.asarray(np.min(found, axis=0) if positive else np.max(found, axis=0))

    def _anywhere(self, channel: Channel, pair: Pair) -> Iterator[LinkValues]:
        """The link as planned, and where the ends' tubes have corners, edges and middles."""
        yield self.values(channel, pair)
        subject = self.subject
        corners = [list(_corners(subject, name)) for name in pair]
        if max(map(len, corners)) == 1:
            return
        for moved in product(*corners):
            ends = {n: subject.positions[n] + off for n, off in zip(pair, moved, strict=True)}
            shaken = replace(subject, positions={**subject.positions, **ends})
            yield TrueModel(shaken, self.cells).values(channel, pair)


def _corners(subject: Subject, name: str) -> Iterator[Array]:
    """How far (T+1, 3) [m] a disturbed agent may be off its plan: towards each corner of its box
    and, in the plane, each middle of an edge, and not at all."""
    mission, past = subject.mission, subject.plan.executed
    agent = mission.agents.get(name)
    widths = None if agent is None else half_widths(agent, mission.horizon - past)
    if agent is None or agent.tube is None or widths is None or agent.dynamics.position is None:
        yield np.zeros((mission.horizon + 1, 3))
        return
    box = np.zeros((mission.horizon + 1, 3))
    rows = np.abs(agent.dynamics.axes)
    box[past:, : len(rows)] = widths[0] @ rows.T
    flies = len(rows) == 3
    signs = list(product((-1.0, 1.0) if flies else (-1.0, 0.0, 1.0), repeat=len(rows)))
    for towards in [*signs, (0.0, 0.0, 0.0)] if flies else signs:
        yield box * np.array([*towards, 0.0][:3])


def _bare(channel: Channel) -> Channel:
    """The channel without its walls, which the verifier counts by itself."""
    if channel.model is None or channel.model.walls is None:
        return channel
    return replace(channel, model=replace(channel.model, walls=None))


def since(step: int, before: LinkEvaluator, after: LinkEvaluator) -> LinkEvaluator:
    """Links judged by one model up to the step that was measured last, and by another after it."""
    if not step:
        return after

    def robustness(link: Link, positive: bool) -> Array:
        """Robustness (T+1,) of a link predicate."""
        values = after(link, positive).copy()
        values[: step + 1] = before(link, positive)[: step + 1]
        return values

    return robustness


def named_pairs(mission: Mission) -> Iterator[tuple[str, Pair]]:
    """Every (channel, pair) that a requirement or the objective names, each once."""
    seen: set[tuple[str, frozenset[str]]] = set()
    for name, pair in _mentions(mission):
        key = (name, frozenset(pair))
        if key not in seen:
            seen.add(key)
            yield name, pair


def _mentions(mission: Mission) -> Iterator[tuple[str, Pair]]:
    """Every (channel, pair) where it is named."""
    formulas = [r.formula for r in mission.requirements]
    formulas += [p.formula for p in mission.preferences]
    for formula in formulas:
        for node in walk(formula):
            if isinstance(node, Link):
                yield node.channel, (node.sender, node.receiver)
    capped = (term for cap in mission.caps for term in cap.terms)
    for term in (*mission.objective, *capped):
        if term.kind is TermKind.LINK_COST and term.channel is not None:
            yield from ((term.channel, pair) for pair in term.pairs)


def link_series(subject: Subject, cells: CellModel, true: TrueModel) -> tuple[LinkSeries, ...]:
    """Link quality over time for every pair that the mission names."""
    return tuple(
        LinkSeries(name, *pair, _quality(subject.mission.channels[name], pair, cells, true))
        for name, pair in named_pairs(subject.mission)
    )


def _quality(channel: Channel, pair: Pair, cells: CellModel, true: TrueModel) -> dict[str, Array]:
    values = _signal(channel, pair, true)
    if channel.tables or _costs(cells.subject.mission, channel, pair):
        values["cost"] = cells.cost(channel, pair, "least")
    return values


def _costs(mission: Mission, channel: Channel, pair: Pair) -> bool:
    """Whether the objective counts this pair, so that its table is there already."""
    return any(
        term.channel == channel.name and {pair, pair[::-1]} & set(term.pairs)
        for term in mission.objective
    )


def _signal(channel: Channel, pair: Pair, true: TrueModel) -> dict[str, Array]:
    """What is known of a link at the true positions, at each step: distance [m], mean and sigma
    [dB], and what the budget makes of them."""
    places = true.subject.places
    if channel.model is None:
        return {"distance": np.linalg.norm(places[pair[0]] - places[pair[1]], axis=1)}
    found = true.values(channel, pair)
    values = {"distance": found.distance, "rssi": found.mean, "sigma": found.sigma}
    budget = channel.budget
    if budget is None:
        return values
    from stlc.radio.averages import average

    values["snr"] = budget.snr(found.mean)
    if budget.rates:
        values["rate"] = budget.throughput(found.mean)
    if budget.modulation is not None:
        values["ber"] = average(budget.ber, found.mean, found.sigma)
        if budget.packet is not None:
            values["prr"] = average(budget.prr, found.mean, found.sigma)
    return values
