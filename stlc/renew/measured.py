"""States as they were measured, read from JSON.

    {"states": {"r1": [1.2, 3.4, 0.1, 0.0], "r2": {"px": 8.1}},
     "history": {"r1": {"states": [[1, 1, 0, 0], ..], "inputs": [[1, 0], ..]}}}

An agent's state is a list, or an object of those states that differ from the plan; `history`, what
was measured and applied at the steps before, may be left out. Of a robot
`{"x": 1.2, "y": 3.4, "heading": 0.7}` is where its axle's centre is [m] and where it looks [rad];
its states `px` and `py` are those of the point that the plan is of, and a heading may stand beside
them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import cos, sin
from pathlib import Path
from typing import Any

import numpy as np

from stlc.arrays import Floats
from stlc.errors import UsageError
from stlc.inputs import InputError, read_input
from stlc.mission import Mission
from stlc.plan import Plan
from stlc.renew.past import Past, along


def read_past(path: Path, mission: Mission, plan: Plan, step: int) -> Past:
    """What has happened up to `step`. Raises UsageError, with the place, for what is no such file
    or doesn't fit the mission."""
    try:
        value = json.loads(read_input(path))
    except InputError as error:
        raise UsageError(f"{path}: {error}") from None
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{path}: not JSON: {error}") from None
    top = _mapping(value, f"{path}")
    unknown = top.keys() - {"states", "history", "step"}
    if unknown:
        raise UsageError(f"{path}: unknown entry {min(unknown)!r}: states, history, step")
    if "step" in top and top["step"] != step:
        raise UsageError(f"{path} was measured at step {top['step']}, not at {step}")
    states = _mapping(top.get("states"), f"{path}: states")
    history = _mapping(top.get("history", {}), f"{path}: history")
    posed = {n: _pose(v, n, f"{path}: states.{n}", mission) for n, v in states.items()}
    return along(
        mission, plan, step,
        {n: _state(v, n, f"{path}: states.{n}", mission, plan, step)
         for n, (v, _) in posed.items()},
        {n: _both(v, f"{path}: history.{n}") for n, v in history.items()},
        {n: heading for n, (_, heading) in posed.items() if heading is not None},
    )  # fmt: skip


def _pose(value: Any, name: str, where: str, mission: Mission) -> tuple[Any, float | None]:
    """A measured state without the heading of a robot, its axle's centre as the plan's point."""
    agent = mission.agents.get(name)
    robot = None if agent is None else agent.robot
    if robot is None or not isinstance(value, dict) or not {"x", "y", "heading"} & value.keys():
        return value, None
    rest = {k: v for k, v in value.items() if k not in ("x", "y", "heading")}
    if "heading" not in value:
        raise UsageError(f"{where}: where the axle's centre is tells nothing without a `heading`")
    heading = float(_numbers(value["heading"], f"{where}.heading"))
    if not {"x", "y"} & value.keys():
        return rest, heading
    if rest or not {"x", "y"} <= value.keys():
        raise UsageError(f"{where}: `x`, `y` and `heading`, or states and `heading`, are needed")
    x, y = (float(_numbers(value[k], f"{where}.{k}")) for k in ("x", "y"))
    b = robot.lookahead
    return [x + b * cos(heading), y + b * sin(heading)], heading


def _mapping(value: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise UsageError(f"{where}: an object is needed")
    return value


def _state(value: Any, name: str, where: str, mission: Mission, plan: Plan, step: int) -> Floats:
    """A state (n,): a list, or the plan's with some values in their place."""
    if isinstance(value, list):
        return _numbers(value, where)
    run = plan.runs.get(name)
    if run is None:
        raise UsageError(f"{where}: the mission has no agent {name!r}")
    found = np.array(run.states[step])
    for key, number in _mapping(value, where).items():
        if key not in run.state_names:
            raise UsageError(f"{where}: no state {key!r}; states: {', '.join(run.state_names)}")
        found[run.state_names.index(key)] = _numbers(number, f"{where}.{key}")
    return found


def _both(value: Any, where: str) -> tuple[Floats, Floats]:
    given = _mapping(value, where)
    if given.keys() != {"states", "inputs"}:
        raise UsageError(f"{where}: `states` and `inputs` are needed")
    states, inputs = (_numbers(given[k], f"{where}.{k}") for k in ("states", "inputs"))
    return states, inputs


def _numbers(value: Any, where: str) -> Floats:
    try:
        found = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise UsageError(f"{where}: numbers are needed") from None
    if not np.isfinite(found).all():
        raise UsageError(f"{where}: finite numbers are needed")
    return found
