"""Link costs and link predicates: tables from the radio, columns from `stlc.milp.tables`.

Robustness of a link predicate on cells: `low` is what surely holds in each closed cell pair (the
worst for a positive predicate), `high` the other end, negated for a negated predicate.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from stlc.errors import UsageError
from stlc.ir.nodes import Link, Node, Not, Quantity, Relation
from stlc.milp.bounds import unit_of
from stlc.milp.context import Context, Ranges
from stlc.milp.goals import Goal, Level
from stlc.milp.model import Floats, Ints
from stlc.mission import Channel, Mission

if TYPE_CHECKING:
    from stlc.radio.table import LinkEnds


@dataclass(slots=True)
class LinkTables:
    """Tables of a mission's links, made once each: whole matrices over the channel's cells."""

    mission: Mission
    _costs: dict[tuple[str, tuple[str, str]], Floats] = field(default_factory=dict)
    _levels: dict[tuple[object, ...], Floats] = field(default_factory=dict)

    def cost(self, channel: Channel, pair: tuple[str, str]) -> Floats:
        """Link cost (n, n), or (n,) towards a station."""
        key = (channel.name, pair)
        if key not in self._costs:
            self._costs[key] = self._cost(channel, pair)
        return self._costs[key]

    def robustness(self, node: Link | Not) -> Floats:
        """What surely holds of a (negated) link predicate: (n, n), or (n,) towards a station."""
        link = link_of(node)
        key = (*link.key[:-1], isinstance(node, Not))
        if key not in self._levels:
            self._levels[key] = self._robustness(link, negated=isinstance(node, Not))
        return self._levels[key]

    def bounds(self, node: Link | Not, ranges: Mapping[str, Ranges]) -> tuple[float, float]:
        """Least and greatest robustness over the cells in reach at the predicate's step."""
        table, link = self.robustness(node), link_of(node)
        seen = table[np.ix_(*self._cells(link, ranges))] if table.ndim else table
        if seen.size == 0:
            return -np.inf, -np.inf
        return float(seen.min()), float(seen.max())

    def _cells(self, link: Link, ranges: Mapping[str, Ranges]) -> list[Ints]:
        partition = self.mission.channels[link.channel].partition
        moving = [n for n in (link.sender, link.receiver) if n in self.mission.agents]
        return [
            np.asarray(
                partition.touching(
                    ranges[name].position_lower[link.shift], ranges[name].position_upper[link.shift]
                )
            )
            for name in moving
        ]

    def _cost(self, channel: Channel, pair: tuple[str, str]) -> Floats:
        given = _given(channel, pair)
        if given is not None:
            return given
        from stlc.radio.costs import CostName
        from stlc.radio.table import cost_table

        if channel.model is None or channel.budget is None:
            raise UsageError(f"channel '{channel.name}' has neither a model nor a table for {pair}")
        bound = channel.cost_bound.value
        ends = self._ends(channel, pair)
        table = cost_table(channel.model, ends, CostName(channel.cost), channel.budget, bound)
        return self._oriented(table.matrix(), pair)

    def _robustness(self, link: Link, *, negated: bool) -> Floats:
        channel = self.mission.channels[link.channel]
        pair = (link.sender, link.receiver)
        at_least = link.relation is Relation.AT_LEAST
        if link.quantity is Quantity.COST:
            values = self.cost(channel, pair)
            return values - link.threshold if at_least else link.threshold - values
        from stlc.radio import predicates

        if channel.model is None or channel.budget is None:
            raise UsageError(
                f"channel '{channel.name}' has no model to judge {link.quantity.value}"
            )
        chance = link.probability is not None
        quantity = (
            predicates.Quantity.CHANCE if chance else predicates.Quantity(link.quantity.value)
        )
        predicate = predicates.LinkPredicate(quantity, link.threshold, at_least, link.probability)
        found = predicates.threshold_table(
            channel.model, self._ends(channel, pair), predicate, channel.budget,
            channel.predicate_bound.value,
        )  # fmt: skip
        values = -found.high.matrix() if negated else found.low.matrix()
        return self._oriented(values, pair)

    def _ends(self, channel: Channel, pair: tuple[str, str]) -> LinkEnds:
        from stlc.radio.table import LinkEnds

        stations = [self.mission.stations[n] for n in pair if n in self.mission.stations]
        if len(stations) == 2:
            raise UsageError(f"neither end of the link {pair[0]} - {pair[1]} moves")
        if not stations:
            return LinkEnds(channel.partition, receiver=pair[1])
        heights = (0.0, stations[0].height) if stations[0].height else None
        return LinkEnds(channel.partition, stations[0].position, heights, pair[1])

    def _oriented(self, values: Floats, pair: tuple[str, str]) -> Floats:
        """(n, 1) becomes (n,)."""
        both = all(name in self.mission.agents for name in pair)
        return values if both else values.reshape(len(values))


def _given(channel: Channel, pair: tuple[str, str]) -> Floats | None:
    if pair in channel.tables:
        return channel.tables[pair]
    if pair[::-1] in channel.tables:
        return channel.tables[pair[::-1]].T
    return channel.tables.get(None)


def link_of(node: Node) -> Link:
    """The link predicate below a possible negation."""
    inner = node.arg if isinstance(node, Not) else node
    assert isinstance(inner, Link)
    return inner


@dataclass(slots=True)
class LinkEncoder:
    """Link predicates as literals (margins) or as values (robustness goals)."""

    ctx: Context
    tables: LinkTables
    rho: Mapping[Goal, int]
    encoding: str = "auto"

    def assert_link(self, node: Link | Not, level: Level) -> None:
        """The predicate holds at its level."""
        if level.goals:
            self._value_rows(node, level, None)
            return
        column = self._allowed(node, level.margin)
        self.ctx.builder.add_rows("link", [0], [column], [1.0], 1.0, np.inf)

    def literal(self, node: Link | Not, level: Level) -> int:
        """Column z in {0, 1} with z = 1 => the predicate holds at its level."""
        if not level.goals:
            return self._allowed(node, level.margin)
        column = int(self.ctx.builder.binary("link_z", (1,))[0])
        self._value_rows(node, level, column)
        return column

    def _parts(self, node: Link | Not) -> tuple[Channel, tuple[str, str], int]:
        link = link_of(node)
        channel = self.ctx.mission.channels[link.channel]
        return channel, (link.sender, link.receiver), link.shift

    def _allowed(self, node: Link | Not, margin: float) -> int:
        from stlc.milp.tables import link_literal

        channel, pair, step = self._parts(node)
        allowed = self.tables.robustness(node) >= margin - 1e-9
        return link_literal(self.ctx, channel, pair, allowed, step)

    def _value_rows(self, node: Link | Not, level: Level, z: int | None) -> None:
        from stlc.milp.tables import link_value

        channel, pair, step = self._parts(node)
        unit = unit_of(node)
        # More than the ceiling is never asked for: cutting there keeps M small.
        table = np.minimum(self.tables.robustness(node), level.ceiling(unit))
        value = link_value(self.ctx, channel, pair, table, step, self.encoding)
        least = float(table.min())
        asks = [(self.rho[g], g.scale(unit), g.high) for g in level.goals]
        for rho, scale, high in asks:
            cols, values = [*value.cols, rho], [*value.values, -scale]
            self._row(cols, values, -value.constant, least - scale * high - value.constant, z)
        if level.needs_margin(unit):
            lower = level.margin - value.constant
            self._row(list(value.cols), list(value.values), lower, least - value.constant, z)

    def _row(
        self,
        cols: Sequence[int],
        values: Sequence[float],
        lower: float,
        slack: float,
        z: int | None,
    ) -> None:
        """values @ x >= lower, or only where z = 1."""
        if z is None:
            self.ctx.builder.add_rows(
                "link", np.zeros(len(cols), np.int64), cols, values, lower, np.inf
            )
            return
        cols, values = [*cols, z], [*values, slack - lower]
        self.ctx.builder.add_rows(
            "link", np.zeros(len(cols), np.int64), cols, values, slack, np.inf
        )
