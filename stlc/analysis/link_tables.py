"""A mission's channel tables by polarity and within reach.

Robustness of a link predicate on cells: `low` is what surely holds in each closed cell pair (the
worst for a positive predicate), `high` the other end, negated for a negated predicate.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from stlc.analysis.ranges import Ranges
from stlc.arrays import Floats, Ints
from stlc.ir.nodes import Link, Node, Not
from stlc.mission import Bound, Channel, Mission

if TYPE_CHECKING:
    from stlc.channels import ChannelTables, TableMemo


@dataclass(slots=True)
class LinkTables:
    """A mission's channel tables as the encoders want them: by polarity, and within reach.

    `hopeful`: what may hold somewhere in each cell pair, whatever bound the channel names, in place
    of what its cells stand for. `memo`: see ChannelTables.
    """

    mission: Mission
    hopeful: bool = False
    memo: TableMemo | None = None
    channels: ChannelTables = field(init=False)

    def __post_init__(self) -> None:
        from stlc.channels import ChannelTables

        self.channels = ChannelTables(self.mission, {} if self.memo is None else self.memo)

    def cost(self, channel: Channel, pair: tuple[str, str]) -> Floats:
        """Link cost (n, n), or (n,) towards a station."""
        return self.channels.cost(channel.name, pair)

    def robustness(self, node: Link | Not) -> Floats:
        """What surely holds of a (negated) link predicate: (n, n), or (n,) towards a station."""
        bound = Bound.WORST if self.hopeful else None
        found = self.channels.thresholds(link_of(node), bound)
        if isinstance(node, Not):
            return -(found.low if self.hopeful else found.high)
        return found.high if self.hopeful else found.low

    def bounds(self, node: Link | Not, ranges: Mapping[str, Ranges]) -> tuple[float, float]:
        """Least and greatest robustness over the cells in reach at the predicate's step."""
        table, link = self.robustness(node), link_of(node)
        seen = table[np.ix_(*self._cells(link, ranges))] if table.ndim else table
        if seen.size == 0:
            return -np.inf, -np.inf
        return float(seen.min()), float(seen.max())

    def _cells(self, link: Link, ranges: Mapping[str, Ranges]) -> list[Ints]:
        """Cells in reach of each moving end at the link's step, sender first."""
        partition = self.mission.channels[link.channel].partition
        moving = [n for n in (link.sender, link.receiver) if n in self.mission.agents]
        at, axes = link.shift, partition.axes
        boxes = ((ranges[n].position_lower[at], ranges[n].position_upper[at]) for n in moving)
        return [np.asarray(partition.touching(low[:axes], high[:axes])) for low, high in boxes]


def link_of(node: Node) -> Link:
    """The link predicate below a possible negation."""
    inner = node.arg if isinstance(node, Not) else node
    assert isinstance(inner, Link)
    return inner
