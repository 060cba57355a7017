"""States and inputs over time, by their own names and units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stlc.arrays import Floats
from stlc.mission import Agent, Mission
from stlc.plan import Plan
from stlc.plot.clock import Clock
from stlc.plot.style import Look

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_COMPONENTS = 3  # agents up to which each component is drawn
MOST_NAMES = 4  # of one panel: so many line styles can be told apart
ROUNDING = 1e-9  # below it a signal is 0: no axis of 1e-17

_STYLES: tuple[Any, ...] = ("-", (0, (4, 1.5)), (0, (1, 1)), (0, (6, 1.5, 1, 1.5)))
_ON_THE_MAP = ("px", "py", "pz")  # positions of the dynamics of the language: map and heights
_VELOCITY = ("vx", "vy", "vz")


@dataclass(frozen=True, slots=True)
class Curve:
    """One signal (steps,) of one agent."""

    agent: str
    name: str
    values: Floats


@dataclass(frozen=True, slots=True)
class SignalPanel:
    """Signals of one unit; `norm` is the symbol of vectors whose lengths are drawn instead."""

    title: str
    unit: str
    hold: bool
    curves: tuple[Curve, ...]
    norm: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the signals, each once."""
        return tuple(dict.fromkeys(curve.name for curve in self.curves))


def signal_panels(mission: Mission, plan: Plan) -> list[SignalPanel]:
    """Velocities, all other states that the map doesn't show, and inputs; none without a curve."""
    velocities = [c for a in mission.agents.values() for c in _states(a, plan) if _moves(a, c[0])]
    states = [c for a in mission.agents.values() for c in _states(a, plan) if _own(a, c[0])]
    inputs = [c for a in mission.agents.values() for c in _inputs(a, plan)]
    return [
        *_grouped("Velocity", "v", velocities, hold=False),
        *_grouped("State", "", states, hold=False),
        *_grouped("Input", "u", inputs, hold=True),
    ]


_Named = tuple[Curve, str]  # a curve and its unit


def _states(agent: Agent, plan: Plan) -> Iterator[tuple[int, _Named]]:
    run = plan.runs[agent.name]
    for k, (name, unit) in enumerate(zip(run.state_names, run.state_units, strict=True)):
        yield k, (Curve(agent.name, name, _clean(run.states[:, k])), unit)


def _inputs(agent: Agent, plan: Plan) -> Iterator[tuple[int, _Named]]:
    run = plan.runs[agent.name]
    if not len(run.inputs):
        return
    for k, (name, unit) in enumerate(zip(run.input_names, run.input_units, strict=True)):
        yield k, (Curve(agent.name, name, _clean(run.inputs[:, k])), unit)


def _clean(values: Floats) -> Floats:
    return np.asarray(np.where(np.abs(values) < ROUNDING, 0.0, values))


def _moves(agent: Agent, k: int) -> bool:
    """Whether a state is a component of the velocity, by that name."""
    velocity = agent.dynamics.velocity
    return velocity is not None and k in velocity and agent.dynamics.states[k] in _VELOCITY


def _own(agent: Agent, k: int) -> bool:
    """Whether a state has a name of its own, so that no other panel shows it."""
    model = agent.dynamics
    placed = model.position is not None and model.states[k] in _ON_THE_MAP
    return not placed and not _moves(agent, k)


def _grouped(
    title: str, symbol: str, found: Sequence[tuple[int, _Named]], *, hold: bool
) -> list[SignalPanel]:
    """A panel for each unit; of many agents with vectors the lengths, of many names a few each."""
    units: dict[str, list[Curve]] = {}
    for _, (curve, unit) in found:
        units.setdefault(unit, []).append(curve)
    panels = []
    for unit, curves in units.items():
        if symbol and len({c.agent for c in curves}) > MOST_COMPONENTS:
            panels.append(SignalPanel(title, unit, hold, tuple(_lengths(curves, symbol)), symbol))
            continue
        names = list(dict.fromkeys(c.name for c in curves))
        for start in range(0, len(names), MOST_NAMES):
            some = names[start : start + MOST_NAMES]
            mine = tuple(c for c in curves if c.name in some)
            panels.append(SignalPanel(title, unit, hold, mine))
    return panels


def _lengths(curves: Sequence[Curve], symbol: str) -> Iterator[Curve]:
    """The norm of each agent's signals."""
    for agent in dict.fromkeys(c.agent for c in curves):
        parts = np.array([c.values for c in curves if c.agent == agent])
        yield Curve(agent, f"|{symbol}|", np.linalg.norm(parts, axis=0))


def draw_signals(axes: Axes, panel: SignalPanel, clock: Clock, look: Mapping[str, Look]) -> None:
    """Colours are agents, line styles are names; inputs are held from step to step."""
    names = panel.names
    for curve in panel.curves:
        style = _STYLES[names.index(curve.name) % len(_STYLES)]
        colour, values = look[curve.agent].colour, curve.values
        if panel.hold:
            axes.stairs(values, clock.times[: len(values) + 1], baseline=None, linewidth=1.5,
                        edgecolor=colour, linestyle=style)  # fmt: skip
        else:
            axes.plot(clock.times, values, color=colour, linewidth=1.5, linestyle=style)
    listed = ", ".join(names)
    label = listed if panel.title == "State" and len(listed) <= 18 else panel.title.lower()
    pretty = panel.unit.replace("^2", "\N{SUPERSCRIPT TWO}")
    axes.set_ylabel(f"{label} [{pretty}]" if pretty else label)
    axes.set_title(panel.title)
    if len(names) > 1:
        _key(axes, names)


def _key(axes: Axes, names: Sequence[str]) -> None:
    """A key of line styles, which stand for names; colours stand for agents."""
    from matplotlib.lines import Line2D

    items = [
        Line2D([], [], color="#404040", linestyle=_STYLES[k % len(_STYLES)], label=name)
        for k, name in enumerate(names)
    ]
    axes.legend(handles=items, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(names),
                borderaxespad=0.2, handlelength=2.4, columnspacing=1.2)  # fmt: skip
