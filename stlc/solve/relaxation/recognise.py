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

from stlc.analysis.ranges import Ranges
from stlc.arrays import Bools, Floats
from stlc.ir.nodes import Linear, Link, Node, Not, Or, Role
from stlc.ir.rewrite import conjuncts
from stlc.milp.compile import Compiled
from stlc.mission import Agent, Channel, Dynamics, ObjectiveTerm, TermKind
from stlc.radio.partition import Partition
from stlc.scales import static_range, steps_of
from stlc.solve.relaxation.costs import Costs
from stlc.solve.relaxation.problem import Apart, Axis, Body, Place, Problem

_ANY = np.array([[-np.inf, np.inf], [-np.inf, np.inf]])


def recognise(compiled: Compiled) -> Problem | None:
    """The relaxation's view, or None where it has nothing to say."""
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
    bodies = [_body(compiled, mission.agents[n], efforts) for n in names]
    found = [b for b in bodies if b is not None]
    if len(found) < len(bodies) or not _inside(compiled, names, channel.partition):
        return None
    return _with_costs(compiled, found, links, asked, channel)


def _inside(compiled: Compiled, names: Sequence[str], partition: Partition) -> bool:
    """Whether agents stay on the partition throughout; it may have no holes."""
    low, high = partition.low.min(0), partition.high.max(0)
    if (partition.common_grid()[1] < 0).any():
        return False
    return all(
        (compiled.ranges[n].position_lower >= low - 1e-6).all()
        and (compiled.ranges[n].position_upper <= high + 1e-6).all()
        for n in names
    )


def _with_costs(
    compiled: Compiled,
    bodies: list[Body],
    links: list[ObjectiveTerm],
    asked: Sequence[_Asked],
    channel: Channel,
) -> Problem:
    mission, partition = compiled.mission, channel.partition
    fine, owner = partition.common_grid()
    assert fine.edges is not None
    costs, rest = Costs([b.name for b in bodies], partition, mission.horizon), 0.0
    for term in links:
        assert term.channel is not None
        other, steps = mission.channels[term.channel], steps_of(mission, term)[0]
        weight = term.weight / static_range(mission, term, compiled.channels)
        for pair in term.pairs:
            table = weight * compiled.channels.cost(other.name, pair)
            same = np.array_equal(other.partition.boxes, partition.boxes)
            if not same or not costs.add(pair, table, steps):
                rest += float(table.min()) * len(steps)
    for i, own in enumerate(costs.alone):
        if not any(i in pair for pair in costs.pairs):
            rest += sum(float(cost.min()) for cost in own if cost is not None)
    forbidding = _forbidding(compiled)
    for link in asked:
        other, at = mission.channels[link.channel], range(link.step, link.step + 1)
        if np.array_equal(other.partition.boxes, partition.boxes):
            costs.add(link.pair, np.where(link.allowed, 0.0, forbidding), at, proof=bool(links))
    key = np.ascontiguousarray(partition.boxes, dtype=np.float64).tobytes()
    return Problem(
        mission.horizon, fine.edges, tuple(bodies),
        {k: tuple(v) for k, v in costs.pairs.items()}, tuple(tuple(a) for a in costs.alone), rest,
        owner.astype(np.int64), key, tuple(_apart(compiled, bodies)), bool(links),
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


def _body(compiled: Compiled, agent: Agent, efforts: Sequence[ObjectiveTerm]) -> Body | None:
    axes = [_axis(compiled, agent, efforts, d) for d in (0, 1)]
    if axes[0] is None or axes[1] is None:
        return None
    pair = (axes[0], axes[1])
    if not _independent(agent.dynamics, pair):
        return None
    avoid: dict[int, list[tuple[Floats, ...]]] = {}
    places: tuple[Place, ...] = ()
    for node, columns, margin in _asserted(compiled):
        boxes = [_bounds(agent.name, pair, part, margin) for part in node.args]
        at = {b[0] for b in boxes if b is not None}
        if any(b is None for b in boxes) or not at:
            continue
        known = [b for b in boxes if b is not None]
        if len(at) == 1:
            avoid.setdefault(known[0][0], []).append(tuple(b[1] for b in known))
        elif not places and columns:
            places = tuple(
                Place(c, t, _cut(box, pair, t)) for c, (t, box) in zip(columns, known, strict=True)
            )
    return Body(
        agent.name, pair, _faces(agent, pair), {t: tuple(g) for t, g in avoid.items()}, places
    )


def _independent(dyn: Dynamics, axes: tuple[Axis, Axis]) -> bool:
    """Whether no state and no input belongs to both axes: their efforts are added up."""
    states = [{axis.state, axis.speed} - {None} for axis in axes]
    inputs = [set(np.flatnonzero(dyn.B[axis.state])) for axis in axes]
    return not (states[0] & states[1] or inputs[0] & inputs[1])


def _cut(box: Floats, axes: tuple[Axis, Axis], t: int) -> Floats:
    """A box cut to the range of a step, so that it is finite."""
    range_ = np.array([axis.box[t, :2] for axis in axes])
    return np.stack(
        [np.maximum(box[:, 0], range_[:, 0]), np.minimum(box[:, 1], range_[:, 1])], axis=1
    )


def _axis(
    compiled: Compiled, agent: Agent, efforts: Sequence[ObjectiveTerm], d: int
) -> Axis | None:
    """The chain behind one axis of the position, if it is one and depends on nothing else."""
    dyn, ranges = agent.dynamics, compiled.ranges[agent.name]
    if dyn.position is None or agent.integer_inputs or dyn.drift.any():
        return None
    used = np.flatnonzero(dyn.position[d])
    if len(used) != 1 or dyn.position[d, used[0]] != 1.0:
        return None
    p = int(used[0])
    driven = np.flatnonzero(dyn.A[p] - np.eye(len(dyn.A))[p])
    if dyn.A[p, p] != 1.0 or len(driven) > 1:
        return None
    weights = _effort(compiled, agent, efforts)
    if not len(driven):
        return _single(agent, ranges, p, weights)
    return _double(agent, ranges, p, int(driven[0]), weights)


def _effort(
    compiled: Compiled, agent: Agent, efforts: Sequence[ObjectiveTerm]
) -> tuple[Floats, Floats]:
    """Effort's weight on states (T+1,) and on inputs (T,) at each step."""
    mission = compiled.mission
    on_states, on_inputs = np.zeros(mission.horizon + 1), np.zeros(mission.horizon)
    for term in efforts:
        if term.agents and agent.name not in term.agents:
            continue
        weight = term.weight / static_range(mission, term, compiled.channels)
        states, inputs = steps_of(mission, term)
        on_states[states.start : states.stop] += weight
        on_inputs[inputs.start : inputs.stop] += weight
    return on_states, on_inputs


def _single(agent: Agent, ranges: Ranges, p: int, weights: tuple[Floats, Floats]) -> Axis | None:
    """p' = p + b u: the rate of a step is b u."""
    inputs = np.flatnonzero(agent.dynamics.B[p])
    if len(inputs) != 1:
        return None
    u, b = int(inputs[0]), float(agent.dynamics.B[p, inputs[0]])
    ends = b * np.stack([ranges.input_lower[:, u], ranges.input_upper[:, u]], 1)
    if not np.isfinite(ends).all():
        return None
    box = np.zeros((len(ends) + 1, 4))
    box[:, 0], box[:, 1] = ranges.state_lower[:, p], ranges.state_upper[:, p]
    box[1:, 2], box[1:, 3] = ends.min(1), ends.max(1)
    rate_cost = np.concatenate([[0.0], weights[1] * agent.effort_input[u] / abs(b)])
    jump = 2 * float(np.abs(ends).max()) + 1.0
    start = (float(agent.start[p]), 0.0)
    return Axis(p, None, b, start, 1.0, jump, box, rate_cost, np.zeros(len(ends)))


def _double(
    agent: Agent, ranges: Ranges, p: int, v: int, weights: tuple[Floats, Floats]
) -> Axis | None:
    """p' = p + a v + b u, v' = v + c u, with one input u: w = a v, blend = b / (a c)."""
    dyn = agent.dynamics
    inputs = np.flatnonzero(dyn.B[v])
    chain = dyn.A[v] - np.eye(len(dyn.A))[v]
    if chain.any() or len(inputs) != 1 or (np.flatnonzero(dyn.B[p]) != inputs[0]).any():
        return None
    u = int(inputs[0])
    a, b, c = float(dyn.A[p, v]), float(dyn.B[p, u]), float(dyn.B[v, u])
    blend = b / (a * c)
    ends = np.abs(np.stack([ranges.input_lower[:, u], ranges.input_upper[:, u]]))
    rates = np.stack([ranges.state_lower[:, v], ranges.state_upper[:, v]], 1)
    if a <= 0 or not 0 <= blend <= 1 or not np.isfinite(ends).all() or not np.isfinite(rates).all():
        return None
    positions = np.stack([ranges.state_lower[:, p], ranges.state_upper[:, p]], 1)
    rate_cost = weights[0] * agent.effort_state[v] / a
    change_cost = weights[1] * agent.effort_input[u] / abs(a * c)
    start = (float(agent.start[p]), a * float(agent.start[v]))
    jump = abs(a * c) * float(ends.max())
    return Axis(
        p, v, a, start, blend, jump, np.hstack([positions, a * rates]), rate_cost, change_cost
    )


def _faces(agent: Agent, axes: tuple[Axis, Axis]) -> Floats:
    """Norm polygons over both rates: n.w <= c."""
    x, y = axes
    rows = []
    if x.speed is not None and y.speed is not None:
        bounds, wanted = agent.state_norms, (x.speed, y.speed)
    elif x.speed is None and y.speed is None:
        B = agent.dynamics.B
        bounds = agent.input_norms
        wanted = (int(np.flatnonzero(B[x.state])[0]), int(np.flatnonzero(B[y.state])[0]))
    else:
        return np.empty((0, 3))
    for bound in bounds:
        if bound.indices != wanted:
            continue
        shrink = 1.0 if bound.kind.value == "outer" else float(np.cos(np.pi / bound.sides))
        angle = 2 * np.pi * np.arange(1, bound.sides + 1) / bound.sides
        limit = np.full(bound.sides, bound.limit * shrink)
        rows.append(np.stack([np.sin(angle) / x.gain, np.cos(angle) / y.gain, limit], 1))
    faces = np.concatenate(rows) if rows else np.empty((0, 3))
    return np.where(np.abs(faces) < 1e-12, 0.0, faces)


def _asserted(compiled: Compiled) -> Iterator[tuple[Or, tuple[int, ...], float]]:
    """Disjunctions that must hold, their exclusive literals (if all have one), the margin."""
    for one in compiled.layout.encoded:
        if one.level.goals:
            continue
        top = conjuncts(one.formula)
        known = dict(one.choices)
        for node in top:
            if not isinstance(node, Or):
                continue
            pairs = known.get(node, ())
            whole = len(pairs) == len(node.args)
            order = {alternative: column for alternative, column in pairs}
            yield node, tuple(order[a] for a in node.args) if whole else (), one.level.margin


def _bounds(
    name: str, axes: tuple[Axis, Axis], node: Node, margin: float
) -> tuple[int, Floats] | None:
    """Step and box (2, 2) that an alternative asks of an agent's position, None if it asks none.

    Predicates of other kinds are left out.
    """
    box, steps = _ANY.copy(), set()
    where = {axis.state: d for d, axis in enumerate(axes)}
    for atom in conjuncts(node):
        if not isinstance(atom, Linear) or len(atom.terms) != 1:
            continue
        signal, factor = atom.terms[0]
        d = where.get(signal.index)
        if signal.owner != name or signal.role is not Role.STATE or d is None:
            continue
        limit = (margin - atom.constant) / factor
        side = 0 if factor > 0 else 1
        box[d, side] = max(box[d, 0], limit) if side == 0 else min(box[d, 1], limit)
        steps.add(signal.shift)
    return (steps.pop(), box) if len(steps) == 1 else None


def _apart(compiled: Compiled, bodies: Sequence[Body]) -> Iterator[Apart]:
    """Disjunctions over the positions of two agents at one step."""
    where = {
        (b.name, axis.state): (i, d) for i, b in enumerate(bodies) for d, axis in enumerate(b.axes)
    }
    for node, _, margin in _asserted(compiled):
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
