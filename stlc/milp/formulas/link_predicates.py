"""Link predicates as columns and rows; link tables become columns in `stlc.milp.tables`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stlc.analysis import networks
from stlc.analysis.bounds import unit_of
from stlc.analysis.goals import Goal, Level
from stlc.analysis.link_tables import LinkTables, link_of
from stlc.ir.networks import Network
from stlc.ir.nodes import Link, Not
from stlc.milp.context import Affine, Context
from stlc.milp.formulas.networks import NetworkRows
from stlc.mission import Channel


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

    def compose(self, node: Network, level: Level, z: int | None, rows: NetworkRows) -> None:
        """A composed network holds at its level where z is 1 (always, for z None)."""
        assert not level.goals, "semantic analysis refuses to maximise end-to-end qualities"
        links = node.links
        first = links[0] if links else None
        if first is None or not networks.attainable(first, level.margin):
            if not node.cut:
                rows.never(z)
            return
        asked = networks.budget(first, level.margin)
        cap = 2.0 * asked + 1e-3  # what is heavier alone is never taken, nor misses from a path
        weights = [self._weight(link, cap, below=node.cut) for link in links]
        if node.cut:
            rows.unrelayed(node, weights, asked, cap, z)
        else:
            rows.relayed(node, weights, asked, cap, z)

    def _weight(self, link: Link, cap: float, *, below: bool) -> Affine:
        """An expression that a link's weight is at most, or (`below`) at least."""
        from stlc.milp.tables import link_bound

        channel, pair, step = self._parts(link)
        table = np.minimum(networks.weights(link, self.tables.robustness(link)), cap)
        sign = -1.0 if below else 1.0
        return link_bound(self.ctx, channel, pair, sign * table, step, self.encoding).scaled(sign)

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
        """Rows that keep a link's value above the robustness columns and its margin, where z is 1
        (always, for z None)."""
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
