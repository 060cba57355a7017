"""Agents as chains of integrators along each axis, where their dynamics are such.

Requirements are read where they bound the position of one agent at one step: alternatives that
keep out of an obstacle, and one exclusive choice over time.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stlc.analysis.ranges import Ranges
from stlc.arrays import Floats
from stlc.dynamics import Dynamics
from stlc.ir.nodes import Linear, Node, Role
from stlc.ir.rewrite import conjuncts
from stlc.milp.compile import Compiled
from stlc.mission import Agent, ObjectiveTerm
from stlc.scales import static_range, steps_of
from stlc.solve.relaxation.asserted import asserted
from stlc.solve.relaxation.problem import Axis, Body, Place

_ANY = np.array([[-np.inf, np.inf], [-np.inf, np.inf]])


def body_of(compiled: Compiled, agent: Agent, efforts: Sequence[ObjectiveTerm]) -> Body | None:
    """What the relaxation understands of an agent: axes, faces of its speed polygon, boxes to
    avoid, places to be at once; None where its axes are coupled."""
    axes = [_axis(compiled, agent, efforts, d) for d in (0, 1)]
    if axes[0] is None or axes[1] is None:
        return None
    pair = (axes[0], axes[1])
    if not _independent(agent.dynamics, pair):
        return None
    avoid: dict[int, list[tuple[Floats, ...]]] = {}
    places: tuple[Place, ...] = ()
    for node, columns, margin in asserted(compiled):
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
