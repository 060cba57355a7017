"""Heights: which agents have one, and the layers that a channel's cells must cover."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

import numpy as np

from stlc.dynamics import Dynamics
from stlc.mission import Agent, Station
from stlc.sema import props
from stlc.sema.channel_errors import BadChannel
from stlc.sema.report import Mistake
from stlc.sema.scope import Scope
from stlc.sema.space_errors import UnboundedHeight
from stlc.sema.units import METRE
from stlc.sema.values import Env

if TYPE_CHECKING:
    from stlc.radio.gp import ChannelModel
    from stlc.sema.bounds import Bounds

Ends = tuple[float, float]
Levels = tuple[float, float]

THIN = 1e-3
"""Half the height [m] of a layer for agents that all keep to one height: thin enough to matter to
no link, far above what positions are judged to."""


EVERY: Levels = (-inf, inf)
"""A column of every height."""

HIGHEST = 1e6  # m, of an antenna

TOUCH = 1e-6
"""Heights this near touch [m]: the tolerance of every judgement."""


def kept_from(levels: Levels, thing: Agent | Station) -> Levels:
    """The heights that something keeps out of, for an obstacle between `levels` [m].

    There is no way of no height: an obstacle that reaches the lowest height of an agent goes on
    below it, and so above its highest. On the ground an obstacle is met if it stands there.
    """
    if isinstance(thing, Station):
        return levels
    row = thing.dynamics.altitude
    if row is None:
        return EVERY if levels[0] <= TOUCH and levels[1] > TOUCH else levels
    k = int(np.argmax(row))
    low, high = float(thing.state_lower[k]), float(thing.state_upper[k])
    return (
        -inf if levels[0] <= low + TOUCH else levels[0],
        inf if levels[1] >= high - TOUCH else levels[1],
    )


def flying(scope: Scope) -> tuple[Agent, ...]:
    """Agents whose height is a signal."""
    return tuple(a for a in scope.agents.values() if a.dynamics.altitude is not None)


def height_range(scope: Scope, channel: str, stations: bool) -> Ends | None:
    """Heights [m] between which all agents, and perhaps stations, are; None where no agent flies.

    Raises Mistake at an agent whose height is not bounded.
    """
    agents = flying(scope)
    if not agents:
        return None
    ends = [_bounds(agent, channel) for agent in agents]
    ends += [(s.height, s.height) for s in scope.stations.values() if stations]
    if len(agents) < sum(a.dynamics.position is not None for a in scope.agents.values()):
        ends.append((0.0, 0.0))
    low, high = min(e[0] for e in ends), max(e[1] for e in ends)
    return (low, high) if high > low else (low - THIN, high + THIN)


def _bounds(agent: Agent, channel: str) -> Ends:
    """Between which heights an agent's bounds keep it."""
    row = agent.dynamics.altitude
    assert row is not None
    k = int(np.argmax(row))
    low, high = float(agent.state_lower[k]), float(agent.state_upper[k])
    if np.isfinite([low, high]).all():
        return low, high
    state = agent.dynamics.states[k]
    raise Mistake(UnboundedHeight(span=agent.span, name=agent.name, channel=channel, state=state))


def check_samples(
    block: props.Block, channel: str, model: ChannelModel | None, scope: Scope
) -> None:
    """Samples in the plane say nothing of links in space. Raises Mistake."""
    raised = [(a.name, "flies") for a in flying(scope)]
    raised += [(a.name, "has a raised antenna") for a in scope.agents.values() if a.antenna]
    if not raised or model is None or model.posterior is None:
        return
    if model.posterior.centres.shape[1] == 4:
        problem = f"its samples have no heights, and `{raised[0][0]}` {raised[0][1]}"
        hint = "give heights of both ends in columns, such as `tx_z` and `rx_z`"
        span = block.by_key["samples"].span
        raise Mistake(BadChannel(span=span, channel=channel, problem=problem, hint=hint))


def stay_within(bounds: Bounds, scope: Scope) -> None:
    """Floor and ceiling of the workspace bound the height of who flies."""
    row, levels = bounds.dynamics.altitude, scope.space_levels
    if row is None or levels is None:
        return
    k = int(np.argmax(row))
    bounds.state_lower[k] = max(float(bounds.state_lower[k]), levels[0])
    bounds.state_upper[k] = min(float(bounds.state_upper[k]), levels[1])


def antenna(block: props.Block, base: Dynamics, env: Env, scope: Scope) -> float:
    """How high the antenna is [m]; on the ground where it isn't said."""
    item, usage = block.get("antenna"), "antenna 1.5 m"
    if item is None:
        return 0.0
    if base.altitude is not None or base.position is None:
        what = "is for agents on the ground: one that flies has its antenna where it is"
        raise props.bad(item, what if base.altitude is not None else "needs a position", usage)
    height = scope.number(props.only(item, usage), METRE, env)
    if not 0.0 <= height <= HIGHEST:
        raise props.bad(item, f"is from 0 to {HIGHEST:g} m", usage)
    return height
