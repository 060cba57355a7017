"""How many pairs of cells the link tables of a mission would hold, before any is built."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import prod
from typing import ClassVar

from stlc.analysis.ranges import Ranges
from stlc.analysis.sizes import MOST_PARTS
from stlc.diagnostics import Diagnostic
from stlc.errors import MissionError
from stlc.ir.nodes import Link
from stlc.ir.rewrite import postorder
from stlc.mission import Channel, Mission, ObjectiveTerm, TermKind
from stlc.source import Span

PAIRS = 40
"""Pairs of cells that count as one part of the model. A table of 2 500 x 2 500 cells, 6 million
pairs, took 1 GB and 6 s; the limit of 500 000 parts allows three times that."""
_BYTES = 160  # of memory for each pair, at the peak
_SHARED = ("channel", "quantity", "relation", "threshold", "probability")


class TooLargeTables(Diagnostic):
    """Link tables between agents would be larger than can be built.

    A table has an entry for each pair of cells, so that twice the cells along both axes make 16
    times the entries; a link cost has them once more for each pair of agents, at each step, where
    both can be in reach. `stlc compile --max-size N` and `stlc solve --max-size N` raise the limit.
    """

    code: ClassVar[str] = "E0807"
    title: ClassVar[str] = (
        "link tables would have {size:,} pairs of cells (about {gigabytes:.1f} GB), "
        "more than {limit:,}"
    )
    label: ClassVar[str] = "{own:,} of them are of this"
    help: ClassVar[str] = (
        "use a coarser `partition` or fewer steps, or raise the limit: `--max-size {parts}`"
    )
    size: int
    limit: int
    own: int
    gigabytes: float
    parts: int


def check_tables(mission: Mission, ranges: Mapping[str, Ranges], limit: int = MOST_PARTS) -> None:
    """Raise MissionError at what is largest where link tables would be larger than the limit."""
    shares = [*_predicates(mission), *_costs(mission, ranges)]
    size = sum(count for count, _ in shares)
    if size <= limit * PAIRS:
        return
    own, span = max(shares, key=lambda share: share[0])
    found = TooLargeTables(
        span=span, size=size, limit=limit * PAIRS, own=own, gigabytes=size * _BYTES / 1e9,
        parts=-(-size // PAIRS),
    )  # fmt: skip
    raise MissionError([found])


def _predicates(mission: Mission) -> Iterator[tuple[int, Span | None]]:
    """Entries of the tables of link predicates; those that ask the same share one."""
    seen = set()
    for requirement in mission.requirements:
        for node in postorder([requirement.formula]):
            if not isinstance(node, Link):
                continue
            key = tuple(getattr(node, name) for name in _SHARED)
            if key not in seen:
                seen.add(key)
                pair = (node.sender, node.receiver)
                count = _entries(mission, mission.channels[node.channel], pair)
                yield count, node.span or requirement.span


def _costs(mission: Mission, ranges: Mapping[str, Ranges]) -> Iterator[tuple[int, Span | None]]:
    """Entries of each link cost's table, and of what is in reach of its pairs at its steps."""
    capped = (term for cap in mission.caps for term in cap.terms)
    for term in (*mission.objective, *capped):
        if term.kind is not TermKind.LINK_COST or term.channel is None or not term.pairs:
            continue
        channel = mission.channels[term.channel]
        table = max(_entries(mission, channel, pair) for pair in term.pairs)
        yield (
            table + sum(_reached(mission, ranges, channel, term, p) for p in term.pairs),
            term.span,
        )


def _entries(mission: Mission, channel: Channel, pair: tuple[str, str]) -> int:
    return prod(len(channel.partition) for name in pair if name in mission.agents)


def _reached(
    mission: Mission, ranges: Mapping[str, Ranges], channel: Channel, term: ObjectiveTerm,
    pair: tuple[str, str],
) -> int:  # fmt: skip
    """Pairs of cells in reach, over the steps of a term."""
    first, last = term.window or (0, mission.horizon)
    ends = [ranges[name] for name in pair if name in mission.agents]
    touching, axes = channel.partition.touching, channel.partition.axes
    return sum(
        prod(len(touching(r.position_lower[t, :axes], r.position_upper[t, :axes])) for r in ends)
        for t in range(max(first, 1), last + 1)
    )
