"""What holds of a mission besides its requirements: bounds, starts, the workspace, partitions.

Each may be taken out of a question to see whether a conflict needs it. Taken out means:

    control    a hundred times as wide          workspace   none
    speed      none                             turn rate   none
    state      none                             start       anywhere in the workspace
    partition  links hold wherever they do at some point of a cell      disturbance  none
    tube       a robot is where its plan is, and goes anywhere          steering     on the spot
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np

from stlc.explain.places import place_of, places_of
from stlc.mission import Agent, Mission
from stlc.places import Polytope
from stlc.robots import Robot, RobotKind
from stlc.source import Span

WIDER = 100.0
"""What a control bound that is taken out is multiplied by: without any, big-M has no end."""


class Kind(Enum):
    """What is given; a conflict drops them in this order where it can."""

    PARTITION = "partition"
    DISTURBANCE = "disturbance"
    TUBE = "tube"
    STEERING = "steering"
    TURN_RATE = "turn_rate"
    WORKSPACE = "workspace"
    STATE = "state"
    SPEED = "speed"
    CONTROL = "control"
    START = "start"


@dataclass(frozen=True, slots=True)
class Given:
    """One of them: `owner` is an agent or a channel, `index` a state; `span` its place, `others`
    the places of more that is taken out with it."""

    kind: Kind
    owner: str = ""
    index: int = -1
    span: Span | None = field(default=None, compare=False)
    others: tuple[Span, ...] = field(default=(), compare=False)

    def __str__(self) -> str:
        where = "" if not self.owner else f" of {self.owner}"
        if self.kind is Kind.WORKSPACE or self.span is None:
            return f"the {self.kind.value.replace('_', ' ')}{where}"
        return f"`{self.span.text}`{where}"


def givens_of(mission: Mission, agents: Iterable[str], channels: Iterable[str]) -> list[Given]:
    """What these agents and channels are given, in the order of `Kind`."""
    found = [Given(Kind.PARTITION, c, span=place_of(mission, c, ("partition",))) for c in channels]
    names = list(agents)
    if mission.workspace is not None and names:
        found.append(Given(Kind.WORKSPACE, span=place_of(mission, None, ())))
    for name in names:
        found += _of(mission, mission.agents[name])
    order = list(Kind)
    return sorted(found, key=lambda g: order.index(g.kind))


def _of(mission: Mission, agent: Agent) -> Iterator[Given]:
    """The bounds and the start of an agent."""
    model, fast = agent.dynamics, _speeds(agent)
    keys = {
        Kind.TURN_RATE: ("turn_rate",),
        Kind.SPEED: ("speed", "v", "velocity", *(model.states[k] for k in fast)),
        Kind.CONTROL: ("control", "u", "input", *model.inputs, "speed"),
        Kind.START: ("start",),
    }
    here = {k: place_of(mission, agent.name, words) for k, words in keys.items()}
    if agent.tube is not None:
        place = place_of(mission, agent.name, ("disturbance",))
        yield Given(Kind.DISTURBANCE, agent.name, span=place)
    if agent.robot is not None:
        yield Given(Kind.TUBE, agent.name, span=place_of(mission, agent.name, ("lookahead",)))
        if agent.robot.kind is RobotKind.CAR:
            place = place_of(mission, agent.name, ("steering",))
            yield Given(Kind.STEERING, agent.name, span=place)
    if agent.turn_rate is not None:
        yield Given(Kind.TURN_RATE, agent.name, span=agent.turn_rate.span)
    for k, name in enumerate(model.states):
        if k not in fast and (np.isfinite([agent.state_lower[k], agent.state_upper[k]]).any()):
            words = (name, "state", "position")
            yield Given(Kind.STATE, agent.name, k, place_of(mission, agent.name, words))
    bounded = [np.isfinite([agent.state_lower[k], agent.state_upper[k]]).any() for k in fast]
    if agent.state_norms or any(bounded):
        places = places_of(mission, agent.name, keys[Kind.SPEED])
        yield Given(Kind.SPEED, agent.name, -1, here[Kind.SPEED], places[1:])
    if agent.input_norms or np.isfinite([agent.input_lower, agent.input_upper]).any():
        yield Given(Kind.CONTROL, agent.name, span=here[Kind.CONTROL])
    if mission.workspace is not None and model.position is not None:
        yield Given(Kind.START, agent.name, span=here[Kind.START])


def _speeds(agent: Agent) -> tuple[int, ...]:
    return agent.dynamics.velocity or ()


def without(mission: Mission, free: Iterable[Given]) -> Mission:
    """The mission with these taken out (partitions apart: see `CompileOptions.hopeful`)."""
    agents, space = dict(mission.agents), mission.workspace
    for given in free:
        if given.kind is Kind.WORKSPACE:
            space = None
        if given.owner in agents:
            agents[given.owner] = _freed(agents[given.owner], given, mission.workspace)
    return replace(mission, agents=agents, workspace=space)


def _freed(agent: Agent, given: Given, space: Polytope | None) -> Agent:
    """The agent without `given`; controls are widened only, by a factor, lest the model be
    unbounded.
    """
    match given.kind:
        case Kind.TURN_RATE:
            return replace(agent, turn_rate=None)
        case Kind.DISTURBANCE:
            return replace(agent, tube=None)
        case Kind.TUBE:
            return replace(agent, robot=None)
        case Kind.STEERING:
            return replace(agent, robot=_unsteered(agent.robot))
        case Kind.STATE:
            return _unbounded(agent, (given.index,))
        case Kind.SPEED:
            return replace(_unbounded(agent, _speeds(agent)), state_norms=())
        case Kind.CONTROL:
            norms = tuple(replace(n, limit=n.limit * WIDER) for n in agent.input_norms)
            ends = agent.input_lower * WIDER, agent.input_upper * WIDER
            return replace(agent, input_lower=ends[0], input_upper=ends[1], input_norms=norms)
        case Kind.START:
            return replace(agent, starts=_anywhere(agent, space))
        case _:
            return agent


def _unsteered(robot: Robot | None) -> Robot | None:
    """A unicycle as fast as a car, in the same tube."""
    if robot is None:
        return None
    turning = robot.speed / robot.lookahead
    return replace(robot, kind=RobotKind.UNICYCLE, turning=turning, directions=0)


def _unbounded(agent: Agent, states: tuple[int, ...]) -> Agent:
    lower, upper = agent.state_lower.copy(), agent.state_upper.copy()
    lower[list(states)], upper[list(states)] = -np.inf, np.inf
    return replace(agent, state_lower=lower, state_upper=upper)


def _anywhere(agent: Agent, space: Polytope | None) -> tuple[np.ndarray, np.ndarray] | None:
    """Ends of the start with the position free: as far as the workspace goes, or went."""
    position = agent.dynamics.position
    lower, upper = agent.start.astype(float), agent.start.astype(float)
    if space is None or position is None:
        return agent.starts
    for row, low, high in zip(
        position, space.vertices.min(axis=0), space.vertices.max(axis=0), strict=True
    ):
        used = np.flatnonzero(row)
        if len(used) == 1:
            ends = sorted((low / row[used[0]], high / row[used[0]]))
            lower[used[0]], upper[used[0]] = ends
    return lower, upper
