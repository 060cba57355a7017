"""What has happened so far: the steps that were carried out, as they were measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from stlc.arrays import Floats
from stlc.certificate import Certificate
from stlc.errors import UsageError
from stlc.measurements import lessons
from stlc.mission import Mission
from stlc.plan import Plan


@dataclass(frozen=True, slots=True, eq=False)
class Past:
    """Steps 0..step of every agent: states (step + 1, n), the last one measured now, and the
    inputs (step, m) that were applied. `headings` [rad] of robots were measured at some steps."""

    step: int
    states: Mapping[str, Floats]
    inputs: Mapping[str, Floats]
    headings: Mapping[str, Mapping[int, float]] = field(default_factory=dict)

    def then(self, inputs: Mapping[str, Floats], states: Mapping[str, Floats]) -> Past:
        """One step later: after inputs (m,) of each agent its state (n,) is measured."""
        return Past(
            self.step + 1,
            {name: np.vstack([run, states[name]]) for name, run in self.states.items()},
            {name: np.vstack([run, inputs[name]]) for name, run in self.inputs.items()},
            self.headings,
        )


def beginning(mission: Mission) -> Past:
    """Nothing has happened yet: agents are where the mission starts them."""
    agents = mission.agents.items()
    return Past(
        0,
        {name: np.asarray(a.start, dtype=np.float64)[None, :] for name, a in agents},
        {name: np.empty((0, a.dynamics.B.shape[1])) for name, a in agents},
    )


def along(
    mission: Mission,
    plan: Plan,
    step: int,
    measured: Mapping[str, Floats],
    history: Mapping[str, tuple[Floats, Floats]] | None = None,
    headings: Mapping[str, float] | None = None,
) -> Past:
    """The past of a plan that was followed up to `step`, with the states (n,) measured there.

    `history` are states (step, n) and inputs (step, m) that are known to be others than planned,
    `headings` [rad] those that robots were measured to have now.
    Agents that nobody measured are where the plan has them. Raises UsageError where shapes, names
    or numbers don't fit the mission.
    """
    if not 0 <= step < mission.horizon:
        raise UsageError(
            f"a plan of {mission.horizon} steps is made anew at a step from 0 to "
            f"{mission.horizon - 1}, not {step}"
        )
    history = history or {}
    for name in (*measured, *history):
        if name not in mission.agents:
            raise UsageError(f"the mission has no agent {name!r}")
    states, inputs = {}, {}
    for name, agent in mission.agents.items():
        run, (n, m) = plan.runs[name], agent.dynamics.B.shape
        before = history.get(name, (run.states[:step], run.inputs[:step]))
        now = measured.get(name, run.states[step])
        states[name] = np.vstack([_shaped(before[0], (step, n), name), _shaped(now, (n,), name)])
        inputs[name] = _shaped(before[1], (step, m), name)
    return Past(step, states, inputs, _headings(mission, plan, step, headings or {}))


def _headings(
    mission: Mission, plan: Plan, step: int, now: Mapping[str, float]
) -> dict[str, dict[int, float]]:
    """What the plan knows of headings before a step, and those of now. UsageError for one of an
    agent that is no robot, or that is no number."""
    for name, angle in now.items():
        agent = mission.agents.get(name)
        if agent is None or agent.robot is None:
            raise UsageError(f"the mission has no robot {name!r}, whose heading was measured")
        if not np.isfinite(angle):
            raise UsageError(f"the heading of {name} is not finite")
    found = {
        name: {t: angle for t, angle in plan.runs[name].headings.items() if t < step}
        for name, agent in mission.agents.items() if agent.robot is not None
    }  # fmt: skip
    for name, angle in now.items():
        found[name][step] = float(angle)
    return {name: known for name, known in found.items() if known}


def _shaped(values: Floats, shape: tuple[int, ...], agent: str) -> Floats:
    """Finite numbers of that shape. Raises UsageError for others."""
    found = np.asarray(values, dtype=np.float64)
    if found.size == 0 and 0 in shape:
        return np.empty(shape)
    if found.shape != shape:
        raise UsageError(
            f"measured values of {agent} have the shape {found.shape}; {shape} is needed"
        )
    if not np.isfinite(found).all():
        raise UsageError(f"measured values of {agent} are not all finite")
    return found


def joined(past: Past, rest: Plan, mission: Mission) -> Plan:
    """The whole run: what was carried out, and the plan for what is left from there on."""
    runs = {
        name: replace(
            run,
            states=np.vstack([past.states[name][:-1], run.states]),
            inputs=np.vstack([past.inputs[name], run.inputs]),
            headings=past.headings.get(name, {}),
        )
        for name, run in rest.runs.items()
    }
    return replace(
        rest, horizon=mission.horizon, runs=runs, executed=past.step, requirements=(), links=(),
        certificate=Certificate(), learned=lessons(mission),
    )  # fmt: skip
