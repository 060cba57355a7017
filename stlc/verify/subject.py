"""What is judged: a plan that fits its mission, with positions and tables at hand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stlc.channels import ChannelTables
from stlc.dynamics import Dynamics
from stlc.errors import UsageError
from stlc.grids import carried_on
from stlc.ir.nodes import Role
from stlc.mission import Mission
from stlc.plan import Plan, Run, mission_digest
from stlc.verify.robots import Drive, drives

Array = NDArray[np.float64]

TOLERANCE = 1e-6
"""Slack on every condition, in its own unit; relative where numbers are larger than 1."""


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """A plan beside its mission.

    `positions` are (T+1, 3) [m], heights last, of every agent and station that is somewhere, as
    planned; robots are where their `drives` take them (`places`).
    """

    mission: Mission
    plan: Plan
    tables: ChannelTables
    positions: Mapping[str, Array]
    drives: Mapping[str, Drive] = field(default_factory=dict)

    @property
    def places(self) -> dict[str, Array]:
        """The true `positions`."""
        driven = {name: np.pad(d.at_steps(), ((0, 0), (0, 1))) for name, d in self.drives.items()}
        return {**self.positions, **driven}

    @property
    def signals(self) -> dict[tuple[str, Role], Array]:
        """States and inputs as the signals of formulas."""
        runs = self.plan.runs.items()
        states = {(name, Role.STATE): run.states for name, run in runs}
        return states | {(name, Role.INPUT): run.inputs for name, run in runs}


def make_subject(mission: Mission, plan: Plan, tables: ChannelTables | None) -> Subject:
    """Join plan and mission. Raises UsageError when the plan is of another mission's shape."""
    check_shape(mission, plan)
    length = mission.horizon + 1
    positions = {s.name: np.tile(s.place, (length, 1)) for s in mission.stations.values()}
    for name, agent in mission.agents.items():
        space = agent.dynamics.space
        if space is not None:
            positions[name] = plan.runs[name].states @ space.T
    driven = drives(mission, plan.runs, plan.executed)
    return Subject(mission, plan, tables or ChannelTables(mission), positions, driven)


def with_room(subject: Subject) -> Subject:
    """Where a run gets out of the workspace on its way, cells at the border go on, as far as where
    it was measured asks for."""
    space, now = subject.mission.workspace, subject.plan.executed
    if space is None or not now:
        return subject
    places = [at[now:, :2] for n, at in subject.positions.items() if n in subject.mission.agents]
    out = [(p @ space.normals.T - space.offsets).max(axis=1) for p in places]
    if not max((float(o.max()) for o in out), default=0.0) > TOLERANCE:
        return subject
    measured = max(max(float(o[0]) for o in out), 0.0)
    mission = carried_on(subject.mission, measured)
    return replace(subject, mission=mission, tables=ChannelTables(mission))


_LARGEST = 1e15  # of states and inputs: beyond it doubles have no digits after the point


def check_shape(mission: Mission, plan: Plan) -> None:
    """UsageError when the plan's agents, steps or names are not those of the mission."""
    if set(plan.runs) != set(mission.agents):
        theirs, ours = (", ".join(sorted(names)) for names in (plan.runs, mission.agents))
        raise UsageError(f"the plan is for agents {theirs}; the mission has {ours}")
    if plan.horizon != mission.horizon:
        raise UsageError(f"the plan has {plan.horizon} steps; the mission has {mission.horizon}")
    if not abs(plan.step - mission.step) <= 1e-12 * mission.step:
        raise UsageError(f"the plan's step is {plan.step:g} s; the mission's is {mission.step:g} s")
    for name, agent in mission.agents.items():
        run, (n, m) = plan.runs[name], agent.dynamics.B.shape
        if run.states.shape != (plan.horizon + 1, n) or run.inputs.shape != (plan.horizon, m):
            raise UsageError(
                f"the plan gives {name} states of shape {run.states.shape} and inputs of shape "
                f"{run.inputs.shape}; the mission needs {(plan.horizon + 1, n)} and "
                f"{(plan.horizon, m)}"
            )
        if not (np.isfinite(run.states).all() and np.isfinite(run.inputs).all()):
            raise UsageError(f"the plan holds numbers for {name} that are not finite")
        if max(np.abs(run.states).max(initial=0.0), np.abs(run.inputs).max(initial=0.0)) > _LARGEST:
            raise UsageError(f"the plan holds numbers for {name} beyond {_LARGEST:g}")
        _check_labels(name, agent.dynamics, run)
    _check_claims(plan)


def _check_labels(name: str, model: Dynamics, run: Run) -> None:
    """The columns are those that the mission means, in its order and units."""
    for what, theirs, ours in (
        ("states", run.state_names, model.states),
        ("inputs", run.input_names, model.inputs),
        ("units of states", run.state_units, model.state_units),
        ("units of inputs", run.input_units, model.input_units),
    ):
        if tuple(theirs) != tuple(ours):
            raise UsageError(
                f"the plan's {what} of {name} are {_listed(theirs)}; the mission's are "
                f"{_listed(ours)}"
            )


def _listed(labels: Sequence[str]) -> str:
    return "(" + ", ".join(label or "-" for label in labels) + ")"


def _check_claims(plan: Plan) -> None:
    """No claim is NaN; an objective is finite, a bound may be infinitely good, no worse."""
    solve = plan.solve
    for name, value in (("objective", solve.objective), ("bound", solve.bound), ("gap", solve.gap)):
        if value is not None and math.isnan(value):
            raise UsageError(f"the plan's {name} is not a number")
    if solve.objective is not None and not math.isfinite(solve.objective):
        raise UsageError("the plan's objective is not finite")
    if solve.sense.own(solve.bound) == math.inf:
        raise UsageError("the plan's bound is not finite")
    for item in plan.requirements:
        if math.isnan(item.margin) or (item.robustness is not None and math.isnan(item.robustness)):
            raise UsageError(f"the plan's robustness of {item.name} is not a number")


def stale(mission: Mission, plan: Plan) -> bool:
    """The mission's text has changed since the plan was made."""
    return plan.sha256 != mission_digest(mission)
