"""Finds in a compiled mission what the relaxation understands.

Agents must fall apart into one chain of integrators along each axis (`problem.Axis`), and the
objective into effort and link costs on one partition. Requirements are read where they bound the
position of one agent at one step: alternatives that keep out of an obstacle, and one exclusive
choice over time for each agent, and where they ask for a link at a step: cells without it are too
expensive for any plan. All others are left to the MILP.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stlc.arrays import Bools
from stlc.ir.nodes import Linear, Link, Node, Not, Role
from stlc.ir.rewrite import conjuncts
from stlc.milp.compile import Compiled
from stlc.mission import Channel, ObjectiveTerm, TermKind
from stlc.radio.partition import Partition
from stlc.scales import static_range, steps_of
from stlc.solve.relaxation.asserted import asserted
from stlc.solve.relaxation.bodies import body_of
from stlc.solve.relaxation.link_costs import Costs
from stlc.solve.relaxation.problem import Apart, Body, Problem


def recognise(compiled: Compiled, *, borders: bool = False, guide: bool = False) -> Problem | None:
    """The relaxation's view, or None where it has nothing to say. `borders`: as cells. `guide`:
    every table with its own costs, for searches that know where on a border a point is; with the
    cells of states these bound nothing."""
    mission = compiled.mission
    links = [t for t in mission.objective if t.kind is TermKind.LINK_COST and t.weight != 0]
    efforts = [t for t in mission.objective if t.kind is TermKind.EFFORT and t.weight != 0]
    if len(links) + len(efforts) < sum(t.weight != 0 for t in mission.objective):
        return None
    if any(t.weight < 0 for t in efforts) or mission.horizon < 2:
        return None
    asked = tuple(_asked_links(compiled))
    uses = [(t.channel, p) for t in links for p in t.pairs]
    uses = uses or [(a.channel, a.pair) for a in asked]
    names = [n for n in mission.agents if any(n in p for _, p in uses)]
    main = next((c for c, p in uses if all(n in mission.agents for n in p)), None)
    if main is None:
        return None
    channel = mission.channels[main]
    if channel.partition.axes > 2:
        return None  # its states are those of two axes
    bodies = [body_of(compiled, mission.agents[n], efforts) for n in names]
    found = [b for b in bodies if b is not None]
    if len(found) < len(bodies) or not _inside(compiled, names, channel.partition):
        return None
    return _with_costs(compiled, found, links, asked, channel, borders, guide)


def _inside(compiled: Compiled, names: Sequence[str], partition: Partition) -> bool:
    """Whether agents stay on the partition throughout; it may have no holes."""
    low, high = partition.low.min(0), partition.high.max(0)
    if (partition.common_grid()[1] < 0).any():
        return False
    return all(
        (compiled.ranges[n].position_lower[:, :2] >= low - 1e-6).all()
        and (compiled.ranges[n].position_upper[:, :2] <= high + 1e-6).all()
        for n in names
    )


def _add_costs(
    compiled: Compiled, links: Sequence[ObjectiveTerm], partition: Partition, costs: Costs,
    proof: bool,
) -> float:  # fmt: skip
    """Add link costs over a partition; the least that those over other cells come to."""
    mission, rest = compiled.mission, 0.0
    for term in links:
        assert term.channel is not None
        other, steps = mission.channels[term.channel], steps_of(mission, term)[0]
        weight = term.weight / static_range(mission, term, compiled.channels)
        for pair in term.pairs:
            table = weight * compiled.channels.cost(other.name, pair)
            same = np.array_equal(other.partition.boxes, partition.boxes)
            if not same or not costs.add(pair, table, steps, proof=proof):
                rest += float(table.min()) * len(steps)
    return rest


def _with_costs(
    compiled: Compiled,
    bodies: list[Body],
    links: list[ObjectiveTerm],
    asked: Sequence[_Asked],
    channel: Channel,
    borders: bool,
    guide: bool,
) -> Problem:
    """The relaxed problem over one channel's partition. Costs over other cells, and least costs of
    agents in no pair, come in as a constant."""
    mission, partition = compiled.mission, channel.partition
    fine, owner = partition.common_grid()
    assert fine.edges is not None
    x, y = fine.edges
    costs = Costs([b.name for b in bodies], partition, mission.horizon, borders)
    rest = _add_costs(compiled, links, partition, costs, not guide)
    for i, own in enumerate(costs.alone):
        if not any(i in pair for pair in costs.pairs):
            rest += sum(float(cost.min()) for cost in own if cost is not None)
    forbidding, proof = _forbidding(compiled), bool(links) and not guide
    for link in asked:
        other, at = mission.channels[link.channel], range(link.step, link.step + 1)
        if np.array_equal(other.partition.boxes, partition.boxes):
            costs.add(link.pair, np.where(link.allowed, 0.0, forbidding), at, proof=proof)
    key = np.ascontiguousarray(partition.boxes, dtype=np.float64).tobytes()
    if borders:
        owner = np.zeros(np.prod([2 * (len(e) - 1) - 1 for e in fine.edges]), np.int64)
    return Problem(
        mission.horizon, (x, y), tuple(bodies),
        {k: tuple(v) for k, v in costs.pairs.items()}, tuple(tuple(a) for a in costs.alone), rest,
        owner.astype(np.int64), key, tuple(_apart(compiled, bodies)), bool(links), borders,
    )  # fmt: skip


def _forbidding(compiled: Compiled) -> float:
    """More than the objectives of any two plans differ by."""
    model = compiled.model
    used = np.flatnonzero(model.c)
    ends = np.abs(np.stack([model.col_lower[used], model.col_upper[used]])).max(0)
    most = 1.0 + 2.0 * float(np.abs(model.c[used]) @ ends)
    return min(most, 1e9)


@dataclass(frozen=True, slots=True, eq=False)
class _Asked:
    """A link that must hold at a step: cells (pairs) that are allowed, one axis a moving end."""

    channel: str
    pair: tuple[str, str]
    step: int
    allowed: Bools


def _asked_links(compiled: Compiled) -> Iterator[_Asked]:
    """Link predicates that are required as they stand."""
    for one in compiled.layout.encoded:
        parts = conjuncts(one.formula)
        for node in () if one.level.goals else parts:
            link = node.arg if isinstance(node, Not) else node
            if not isinstance(link, Link):
                continue
            found = compiled.channels.thresholds(link)
            robustness = -found.high if isinstance(node, Not) else found.low
            allowed = robustness >= one.level.margin - 1e-9
            if link.shift >= 1 and allowed.any():
                yield _Asked(link.channel, (link.sender, link.receiver), link.shift, allowed)


def _apart(compiled: Compiled, bodies: Sequence[Body]) -> Iterator[Apart]:
    """Disjunctions over the positions of two agents at one step."""
    where = {
        (b.name, axis.state): (i, d) for i, b in enumerate(bodies) for d, axis in enumerate(b.axes)
    }
    for node, _, margin in asserted(compiled):
        ways = [_way(part, where, margin) for part in node.args]
        known = [w for w in ways if w is not None]
        if len(known) == len(ways) and len({w[:3] for w in known}) == 1:
            yield Apart(*known[0][:3], np.array([w[3] for w in known]))


def _way(
    node: Node, where: Mapping[tuple[str, int], tuple[int, int]], margin: float
) -> tuple[int, int, int, tuple[float, ...]] | None:
    """First agent, second agent, step, and the row of `Apart.ways`."""
    if not isinstance(node, Linear) or any(s.role is not Role.STATE for s, _ in node.terms):
        return None
    found = [(where.get((s.owner, s.index)), s.shift, factor) for s, factor in node.terms]
    agents = sorted({at[0] for at, _, _ in found if at is not None})
    steps = {shift for _, shift, _ in found}
    if len(agents) != 2 or len(steps) != 1 or any(at is None for at, _, _ in found):
        return None
    row = [0.0] * 5
    for at, _, factor in found:
        assert at is not None
        row[2 * agents.index(at[0]) + at[1]] += factor
    row[4] = margin - node.constant
    return agents[0], agents[1], steps.pop(), tuple(row)
