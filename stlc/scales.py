"""Static ranges of costs: what `normalised(cost)` divides by. Shared by encoders and verifier."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stlc.errors import StlcError
from stlc.mission import Agent, Mission, ObjectiveTerm, TermKind

if TYPE_CHECKING:
    from stlc.channels import ChannelTables

Array = NDArray[np.float64]
_UNSCALED = (TermKind.ROBUSTNESS, TermKind.VIOLATION, TermKind.TOTAL)


def static_range(mission: Mission, term: ObjectiveTerm, tables: ChannelTables) -> float:
    """Highest minus lowest value that a cost term can take by its declared bounds and tables.

    1 for a term that isn't normalised, or whose range is empty. Raises StlcError when an agent's
    weighted state or input has no finite bound.
    """
    if not term.normalised or term.kind in _UNSCALED:
        return 1.0
    effort = term.kind is TermKind.EFFORT
    width = _effort(mission, term) if effort else _link_cost(mission, term, tables)
    return width if width > 0 else 1.0


def steps_of(mission: Mission, term: ObjectiveTerm) -> tuple[range, range]:
    """Steps at which a term counts states (and links), and those at which it counts inputs."""
    first, last = term.window or (0, mission.horizon)
    states = range(max(first, 1), min(last, mission.horizon) + 1)
    return states, range(max(first, 0), min(last, mission.horizon - 1) + 1)


def _effort(mission: Mission, term: ObjectiveTerm) -> float:
    states, inputs = steps_of(mission, term)
    total = 0.0
    for name in term.agents or mission.agents:
        agent = mission.agents[name]
        x, u = _width(agent, "state"), _width(agent, "input")
        total += len(states) * x + len(inputs) * u
    return total


def unbounded(agent: Agent) -> str | None:
    """Whether effort weighs a "state" or an "input" that has no bound: its range is infinite."""
    kinds = ("state", "input")
    return next((what for what in kinds if not np.isfinite(_weighed(agent, what)[1]).all()), None)


def _width(agent: Agent, what: str) -> float:
    """Width of the range of weights'|y|."""
    weights, box = _weighed(agent, what)
    if not np.isfinite(box).all():
        raise StlcError(
            f"normalised(effort) needs a bound on every {what} of {agent.name} it weighs"
        )
    ends = np.abs(box)
    crossing = (box[0] < 0) & (box[1] > 0)
    return float(weights @ (ends.max(axis=0) - np.where(crossing, 0.0, ends.min(axis=0))))


def _weighed(agent: Agent, what: str) -> tuple[Array, Array]:
    """Weights (k,) that are not zero, and the box (2, k) of what they weigh, tightened by the
    norm limits."""
    if what == "state":
        weights, box = agent.effort_state, np.stack([agent.state_lower, agent.state_upper])
    else:
        weights, box = agent.effort_input, np.stack([agent.input_lower, agent.input_upper])
    for bound in agent.state_norms if what == "state" else agent.input_norms:
        columns = list(bound.indices)
        box[:, columns] = np.clip(box[:, columns], -bound.limit, bound.limit)
    used = weights != 0
    return weights[used], box[:, used]


def _link_cost(mission: Mission, term: ObjectiveTerm, tables: ChannelTables) -> float:
    assert term.channel is not None
    spans = [float(np.ptp(tables.cost(term.channel, pair))) for pair in term.pairs]
    return sum(spans) * len(steps_of(mission, term)[0])
