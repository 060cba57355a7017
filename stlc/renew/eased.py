"""Bounds that the measured state breaks, given up as far as they must be.

A bound on a state, a speed or the workspace that does not hold now cannot be a hard one: the
state is what it is, and inertia may carry it further. It is widened far enough to leave the agent
room, and how far the old bound is exceeded, added up over the steps to come, is minimised before
anything else (an exact penalty by tiers; Kerrigan and Maciejowski, Soft constraints and exact
penalty functions in model predictive control, 2000).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from stlc.arrays import Floats
from stlc.grids import beyond, carried_on
from stlc.ir.nodes import Always, And, Linear, Node, Role, Signal
from stlc.ir.rewrite import conjuncts
from stlc.milp.polygons import norm_faces
from stlc.mission import Agent, Mission, NormBound, TermKind
from stlc.places import Polytope
from stlc.preferences import Preference
from stlc.renew.progression import unit_of

_HELD = 1e-9
"""A state beyond a bound by less is rounding; a bound moves by so much in silence."""


@dataclass(frozen=True, slots=True, eq=False)
class Exceeded:
    """A bound that the measured state exceeds by `now`, in its own unit.

    `excess` gives how far states (K, n) are beyond it (K,), 0 within.
    """

    agent: str
    what: str
    now: float
    unit: str
    excess: Callable[[Floats], Floats]


@dataclass(frozen=True, slots=True, eq=False)
class Eased:
    """A mission whose bounds hold at its start, and those that had to give way."""

    mission: Mission
    exceeded: tuple[Exceeded, ...]


def eased(mission: Mission, *, all_bounds: bool = False) -> Eased:
    """The mission with room for where its agents start; the same one where all bounds hold.

    With `all_bounds` those of states and the workspace give way that hold now too: inertia may
    break them before anything can be done.
    """
    held = -np.inf if all_bounds else _HELD
    found: list[tuple[Exceeded, list[Linear]]] = []
    agents = {name: _agent(agent, held, found) for name, agent in mission.agents.items()}
    left = replace(mission, agents=agents)
    space = mission.workspace
    if space is not None:
        out = max((_outside(a, space) for a in agents.values()), default=0.0)
        if out > held:
            left = _in_wider_space(left, space, out)
            found += list(_beyond_space(agents, space, held))
        elif out > 0.0:
            left = replace(left, workspace=_grown(space, out))
    if not found:
        return Eased(left, ())
    steps = range(1, mission.horizon + 1)
    first = _first(mission) - 2
    wishes = [
        Preference(f"{e.agent}: {e.what} at step {t}", _at(faces, t), priority=first, unit=e.unit)
        for e, faces in found
        for t in steps
    ]
    left = replace(left, preferences=(*wishes, *mission.preferences))
    return Eased(left, tuple(e for e, _ in found))


def _at(faces: list[Linear], step: int) -> Node:
    body: Node = faces[0] if len(faces) == 1 else And(tuple(faces))
    return Always(body, step, step)


def _agent(agent: Agent, held: float, found: list[tuple[Exceeded, list[Linear]]]) -> Agent:
    """The agent with wider bounds on states, and on speeds, where its start is beyond them by more
    than `held`."""
    lower, upper = agent.state_lower.copy(), agent.state_upper.copy()
    tube = _tube(agent)
    for k, now in enumerate(agent.start):
        for sign, limit, ends in ((1.0, upper[k], upper), (-1.0, lower[k], lower)):
            over = sign * (now - limit) + tube
            if np.isfinite(limit) and over > held:
                width = agent.state_upper[k] - agent.state_lower[k]
                over = max(over, 0.0)
                room = max(over, width if np.isfinite(width) else 1.0)
                ends[k] = limit + sign * (over + room)
                found.append(_beyond_box(agent, k, sign, limit, over))
            elif over > 0.0:
                ends[k] = now + sign * tube
    norms = tuple(_norm(agent, bound, held, found) for bound in agent.state_norms)
    return replace(agent, state_lower=lower, state_upper=upper, state_norms=norms)


def _beyond_box(
    agent: Agent, k: int, sign: float, limit: float, over: float
) -> tuple[Exceeded, list[Linear]]:
    """A state beyond one end of its box, and the predicate that it is within."""
    unit = agent.dynamics.state_units[k]
    word = "<=" if sign > 0 else ">="
    what = f"{agent.dynamics.states[k]} {word} {limit:g}"
    face = _face(agent, {k: -sign}, sign * limit, unit)

    def excess(states: Floats) -> Floats:
        """How far the states (K, n) are beyond the bound (K,)."""
        return np.asarray(np.maximum(sign * (states[:, k] - limit) + _tube(agent), 0.0))

    return Exceeded(agent.name, what, over, unit, excess), [face]


def _norm(
    agent: Agent, bound: NormBound, held: float, found: list[tuple[Exceeded, list[Linear]]]
) -> NormBound:
    """A bound on a speed with room for the speed now, where that is above it."""
    columns = list(bound.indices)
    over = float(np.linalg.norm(agent.start[columns])) - bound.limit
    if over <= held:
        return bound
    over = max(over, 0.0)
    unit = agent.dynamics.state_units[columns[0]]
    what = f"norm of {' and '.join(agent.dynamics.states[k] for k in columns)} <= {bound.limit:g}"
    normals, offset = norm_faces(bound)
    faces = [
        _face(agent, dict(zip(columns, -normal, strict=True)), offset, unit) for normal in normals
    ]

    def excess(states: Floats) -> Floats:
        """How far the norm of the states (K, n) is above its limit (K,)."""
        size = np.linalg.norm(states[:, columns], axis=1)
        return np.asarray(np.maximum(size - bound.limit, 0.0))

    found.append((Exceeded(agent.name, what, over, unit, excess), faces))
    return replace(bound, limit=2.0 * (bound.limit + over))


def _outside(agent: Agent, space: Polytope) -> float:
    """How far an agent starts outside [m]; 0 inside and for one that is nowhere."""
    if agent.dynamics.position is None:
        return 0.0
    place = agent.dynamics.position @ agent.start
    return float(max((space.normals @ place - space.offsets).max() + _tube(agent), 0.0))


def _tube(agent: Agent) -> float:
    """What a robot needs around the plan of its look-ahead point [m]."""
    return 0.0 if agent.robot is None else agent.robot.radius


def _beyond_space(
    agents: Mapping[str, Agent], space: Polytope, held: float
) -> Iterator[tuple[Exceeded, list[Linear]]]:
    """Agents that start outside the workspace, each with the faces that it is to be within."""
    for name, agent in agents.items():
        position = agent.dynamics.position
        out = _outside(agent, space)
        if position is None or out <= held:
            continue

        def excess(
            states: Floats, position: Floats = position, tube: float = _tube(agent)
        ) -> Floats:
            """How far the states (K, n) are outside (K,) [m]."""
            beyond = states @ position.T @ space.normals.T - space.offsets + tube
            return np.asarray(np.maximum(beyond.max(axis=1), 0.0))

        faces = [
            _face(agent, dict(enumerate(-normal @ position)), offset, "m")
            for normal, offset in zip(space.normals, space.offsets, strict=True)
        ]
        yield Exceeded(name, "within the workspace", out, "m", excess), faces


def _face(agent: Agent, factors: Mapping[int, float], constant: float, unit: str) -> Linear:
    terms = tuple(
        (Signal(agent.name, Role.STATE, k), float(factor))
        for k, factor in sorted(factors.items())
        if factor
    )
    return Linear(terms, float(constant), unit)


def _in_wider_space(mission: Mission, space: Polytope, out: float) -> Mission:
    """Workspace and cells with room for who is outside; see `stlc.grids.beyond`."""
    return replace(carried_on(mission, out), workspace=_grown(space, beyond(space, out)))


def _grown(space: Polytope, by: float) -> Polytope:
    """Every face of the workspace moved outward [m]."""
    normals, offsets = space.normals, space.offsets + by
    pairs = zip(range(-1, len(normals) - 1), range(len(normals)), strict=True)
    corners = [np.linalg.solve(normals[[i, k]], offsets[[i, k]]) for i, k in pairs]
    return Polytope(normals, offsets, np.array(corners))


def _first(mission: Mission) -> int:
    """The first tier of a mission's own preferences."""
    return min((p.priority for p in mission.preferences if p.priority is not None), default=1)


def softened(
    mission: Mission, left: Mission, *, standing: bool = False
) -> tuple[Mission, Mapping[str, str]]:
    """An eased mission with its requirements as wishes that come before those of the mission that
    was `left`, and the requirement that each wish is of.

    Each conjunct is a wish of its own, violated by what its robustness lacks of the margin; what
    bounds lack comes first. With `standing` what has to hold at all times stays a requirement.
    """
    tier = _first(left) - 1
    wishes, owner, kept = [], {}, []
    for r in mission.requirements:
        for k, part in enumerate(conjuncts(r.formula)):
            if standing and (isinstance(part, Always) or not part.children):
                kept.append(replace(r, name=f"{r.name} ({k + 1})", formula=part))
                continue
            name = f"{r.name} ({k + 1})" if k else r.name
            wish = Preference(name, part, priority=tier, margin=r.margin, unit=unit_of(part))
            wishes.append(replace(wish, span=r.span))
            owner[name] = r.name
    costs = tuple(t for t in mission.objective if t.kind is not TermKind.ROBUSTNESS)
    plain = replace(
        mission, requirements=tuple(kept), objective=costs,
        preferences=(*wishes, *mission.preferences),
    )  # fmt: skip
    return plain, owner
