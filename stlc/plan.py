"""A plan: one run of every agent, how it was come by, and what was found true of it."""

from __future__ import annotations

import csv
import hashlib
import io
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stlc.certificate import Certificate
from stlc.files import write_atomic
from stlc.grids import on_grids, shapes
from stlc.measurements import lessons, with_learned
from stlc.sense import Sense

if TYPE_CHECKING:
    from stlc.mission import Agent, Mission
    from stlc.radio.learned import Learned

Array = NDArray[np.float64]

FORMAT_VERSION = 1


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One agent's states (T+1, n) and inputs (T, m), with the names and units of the columns.

    `headings` [rad] of a robot are those that were measured on the way, by step.
    """

    states: Array
    inputs: Array
    state_names: tuple[str, ...]
    input_names: tuple[str, ...]
    state_units: tuple[str, ...]
    input_units: tuple[str, ...]
    headings: Mapping[int, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class RequirementValue:
    """Robustness of one requirement at step 0 and the margin it had to reach; None: not judged."""

    name: str
    robustness: float | None
    margin: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class LinkSeries:
    """What a channel gives one pair at the true positions at steps 0..T.

    `values` are (T+1,) arrays by quantity, those that the channel has: `distance` [m], `rssi`
    (mean) and `sigma` (one packet) [dBm, dB], `snr` [dB], `rate` [bit/s], `ber`, `prr`, and `cost`,
    the channel's table at the agents' cells (NaN outside every cell).
    """

    channel: str
    sender: str
    receiver: str
    values: Mapping[str, Array]


@dataclass(frozen=True, slots=True)
class SolveInfo:
    """How a plan was come by. Objective and bound go the way of `sense`; gap relative."""

    status: str = "unknown"
    objective: float | None = None
    bound: float | None = None
    gap: float | None = None
    backend: str = ""
    solver: str = ""
    encoding: str = ""
    seconds: Mapping[str, float] = field(default_factory=dict)
    sense: Sense = Sense.MINIMIZE


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """A run of the mission's agents over steps 0..horizon, `step` seconds apart.

    `mission` is the file's name, `sha256` the digest of its text, `params` what `-D` set,
    `grids` the cells along each axis of channels that chose them (`stlc.grids`).
    `learned` is what channels had learnt on the way when it was made (`stlc.measurements`).
    `certificate` holds what certification and the verifier found. The steps before `executed`
    were carried out already: states up to and with that step are as they were measured.
    """

    mission: str
    sha256: str
    step: float
    horizon: int
    runs: Mapping[str, Run]
    solve: SolveInfo = SolveInfo()
    requirements: tuple[RequirementValue, ...] = ()
    links: tuple[LinkSeries, ...] = ()
    certificate: Certificate = field(default_factory=Certificate)
    params: Mapping[str, str] = field(default_factory=dict)
    grids: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    executed: int = 0
    learned: Mapping[str, Learned] = field(default_factory=dict)

    @property
    def times(self) -> Array:
        """Seconds (T+1,) of the steps."""
        return np.asarray(np.arange(self.horizon + 1) * self.step, dtype=np.float64)

    def to_csv(self) -> str:
        """Waypoints as CSV: t, time [s], agent, then every state and input name.

        A cell is empty where an agent has no such column, and for the inputs at the last step.
        """
        states = _names(run.state_names for run in self.runs.values())
        inputs = _names(run.input_names for run in self.runs.values())
        header = [
            "t",
            "time",
            "agent",
            *states,
            *(f"{n}_input" if n in states else n for n in inputs),
        ]
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(header)
        for t, time in enumerate(self.times.tolist()):
            for name, run in self.runs.items():
                x, u = _cells(run, t)
                row = [x.get(s, "") for s in states] + [u.get(i, "") for i in inputs]
                writer.writerow([t, time, name, *row])
        return out.getvalue()

    def write_csv(self, path: str | os.PathLike[str]) -> None:
        """Write `to_csv`; OutputError when the file can't be written."""
        write_atomic(path, self.to_csv())

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the plan as JSON; OutputError when the file can't be written."""
        from stlc.plan_json import to_json

        write_atomic(path, to_json(self))


def read_plan(path: str | os.PathLike[str]) -> Plan:
    """Read a plan. UsageError, with the place, for a file that is missing or isn't a plan."""
    from stlc.plan_reader import read

    return read(path)


def as_planned(mission: Mission, plan: Plan) -> Mission:
    """The mission as a plan of it was made: on its grids, channels knowing what they had learnt.

    Raises UsageError where the mission has no such channels.
    """
    return with_learned(on_grids(mission, plan.grids), plan.learned)


def mission_digest(mission: Mission) -> str:
    """SHA-256 of the mission's text (UTF-8)."""
    return text_digest(mission.source.text)


def text_digest(text: str) -> str:
    """SHA-256 of a text (UTF-8)."""
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def make_plan(
    mission: Mission,
    states: Mapping[str, Array],
    inputs: Mapping[str, Array],
    solve: SolveInfo | None = None,
) -> Plan:
    """A plan from states (T+1, n) and inputs (T, m) of each agent, nothing judged yet."""
    runs = {
        name: Run(
            np.asarray(states[name], dtype=np.float64),
            np.asarray(inputs[name], dtype=np.float64),
            agent.dynamics.states,
            agent.dynamics.inputs,
            agent.dynamics.state_units,
            agent.dynamics.input_units,
        )
        for name, agent in mission.agents.items()
    }
    digest = mission_digest(mission)
    info = solve or SolveInfo()
    return Plan(
        mission.source.name, digest, mission.step, mission.horizon, runs, info,
        params=dict(mission.params), grids=shapes(mission), learned=lessons(mission),
    )  # fmt: skip


def shifted(plan: Plan, steps: int, agents: Mapping[str, Agent]) -> Plan:
    """The plan as seen `steps` later, of the same length: a start for the next solve.

    What is missing at the end is filled by inputs, within their bounds, that hold the state as
    still as one step can (least squares). Verdicts and solver's figures are dropped.
    """
    kept = min(max(steps, 0), plan.horizon)
    runs = {
        name: replace(run, states=states, inputs=inputs)
        for name, run in plan.runs.items()
        for states, inputs in [_advance(run, kept, agents[name])]
    }
    return replace(
        plan, runs=runs, solve=SolveInfo(), requirements=(), links=(), certificate=Certificate()
    )


def _advance(run: Run, steps: int, agent: Agent) -> tuple[Array, Array]:
    """The run from `steps` on, lengthened to its old length by inputs that keep the last state as
    nearly as bounds allow."""
    states, inputs = list(run.states[steps:]), list(run.inputs[steps:])
    for _ in range(steps):
        x, law = states[-1], agent.dynamics.law(len(inputs))
        drift = law.A @ x + law.drift
        u = np.linalg.lstsq(law.B, x - drift, rcond=None)[0]
        u = np.clip(np.rint(u) if agent.integer_inputs else u, agent.input_lower, agent.input_upper)
        inputs.append(u)
        states.append(drift + law.B @ u)
    width = run.inputs.shape[1]
    return np.array(states), np.array(inputs).reshape(len(inputs), width)


def _names(groups: Any) -> list[str]:
    return list(dict.fromkeys(name for group in groups for name in group))


def _cells(run: Run, t: int) -> tuple[dict[str, float], dict[str, float]]:
    x = dict(zip(run.state_names, run.states[t].tolist(), strict=True))
    if t >= len(run.inputs):
        return x, {}
    return x, dict(zip(run.input_names, run.inputs[t].tolist(), strict=True))
