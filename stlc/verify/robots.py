"""Unicycles and cars driven along their plans: the nonlinear models under the stated controller.

The controller acts at even times of each step and holds its command; the robot then moves on an
arc, which is followed exactly. Nothing of what makes a plan trackable is taken for granted: where
the robot's limits keep it from its plan, it is off by that, and its tube doesn't hold it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import atan2, cos, pi, sin

import numpy as np

from stlc.mission import Mission
from stlc.plan import Plan, Run
from stlc.robots import Robot, RobotKind, command
from stlc.verify.paths import Path, paths
from stlc.verify.report import Violation
from stlc.verify.trace import Array

_TOLERANCE = 1e-6
_MOVING = 1e-6
"""m/s: slower than that a car rests, whatever steering its wheels' rounding errors would need."""

_MOST = 0.9  # of its speed that a unicycle may use before it is said what keeps it from the rest


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """A drive of N control periods, `periods` a step.

    `places` (N+1, 2) [m] of the axle's centre and `headings` (N+1,) [rad] at the ends of periods;
    `speeds` (N,) [m/s] and `rates` (N,) [rad/s] held within them; `aims` (N+1, 2) of the plan.
    """

    periods: int
    places: Array
    headings: Array
    speeds: Array
    rates: Array
    aims: Array

    @property
    def middles(self) -> Array:
        """Places in the middle of each period's arc (N, 2)."""
        turned = np.diff(self.headings)
        chord = np.diff(self.places, axis=0)
        # Seen from its chord, the middle of an arc of angle h lies tan(h / 4) / 2 chords aside.
        aside = np.tan(turned / 4.0)[:, None] / 2.0 * np.column_stack([chord[:, 1], -chord[:, 0]])
        return np.asarray((self.places[:-1] + self.places[1:]) / 2.0 + aside)

    @property
    def off(self) -> Array:
        """How far the centre is off the plan (N,) [m]: the greater of a period's end and middle."""
        between = np.linalg.norm(self.middles - (self.aims[:-1] + self.aims[1:]) / 2.0, axis=1)
        ends = np.linalg.norm(self.places - self.aims, axis=1)[1:]
        return np.asarray(np.maximum(between, ends))

    def heading_at(self, steps: Array) -> Array:
        """Headings (K,) [rad] at fractional steps (K,): they turn evenly within a period."""
        along = np.arange(len(self.headings)) / self.periods
        return np.asarray(np.interp(steps, along, self.headings))

    def at_steps(self) -> Array:
        """Places (T+1, 2) [m] at the steps."""
        return self.places[:: self.periods]

    def path(self, width: int = 2) -> Path:
        """The motion as chords, one for each period; `width` 3 with its height, which is none."""
        move = np.vstack([np.diff(self.places, axis=0), np.zeros((self.periods, 2))])
        start = np.vstack([self.places, np.repeat(self.places[-1:], self.periods - 1, axis=0)])
        start, move = (np.pad(part, ((0, 0), (0, width - 2))) for part in (start, move))
        return Path(start, move, np.zeros_like(move), self.periods)


def drive(robot: Robot, run: Run, step: float, past: int = 0) -> Drive:
    """What the robot does along a run (T+1, 2) of its look-ahead point, with steps of `step` [s].

    At the first `past` steps, which were carried out, its look-ahead point is where it was
    measured, and where its heading was measured that is what it was.
    """
    periods = max(round(step / robot.period), 1)
    share = np.arange(periods)[:, None] / periods
    legs = run.states[:-1, None] + share * np.diff(run.states, axis=0)[:, None]
    aims = np.vstack([legs.reshape(-1, 2), run.states[-1:]])
    theta, b = robot.heading, robot.lookahead
    x, y = aims[0, 0] - b * cos(theta), aims[0, 1] - b * sin(theta)
    places, headings, held = [(x, y)], [theta], []
    goals = aims.tolist()
    for k, (goal_x, goal_y) in enumerate(goals[1:]):
        if k % periods == 0 and k // periods <= past:
            theta = headings[-1] = run.headings.get(k // periods, theta)
            x, y = goals[k][0] - b * cos(theta), goals[k][1] - b * sin(theta)
            places[-1] = (x, y)
        dx, dy = goal_x - x - b * cos(theta), goal_y - y - b * sin(theta)
        ahead, aside = cos(theta) * dx + sin(theta) * dy, cos(theta) * dy - sin(theta) * dx
        v, omega = command(robot, ahead, aside)
        (x, y), theta = _along((x, y), theta, v * robot.period, omega * robot.period)
        places.append((x, y))
        headings.append(theta)
        held.append((v, omega))
    commands = np.array(held).reshape(-1, 2)
    return Drive(
        periods, np.array(places), np.array(headings), commands[:, 0], commands[:, 1], aims
    )


def _along(
    place: tuple[float, float], heading: float, way: float, turn: float
) -> tuple[tuple[float, float], float]:
    """Place and heading after an arc of length `way` [m] that turns by `turn` [rad]."""
    half = turn / 2.0
    chord = way * (sin(half) / half if abs(half) > 1e-9 else 1.0)
    x, y = place
    return (x + chord * cos(heading + half), y + chord * sin(heading + half)), heading + turn


def heading_at(robot: Robot, run: Run, step: float) -> float:
    """The heading [rad] at the end of a run that was carried out, its steps as measured: the one
    that was measured too, or the one that its controller has made by then."""
    driven = float(drive(robot, run, step, len(run.inputs)).headings[-1])
    theta = run.headings.get(len(run.inputs), driven)
    return atan2(sin(theta), cos(theta))


def drives(mission: Mission, runs: Mapping[str, Run], past: int = 0) -> dict[str, Drive]:
    """The drive of every robot."""
    robots = {n: a.robot for n, a in mission.agents.items() if a.robot is not None}
    return {n: drive(robot, runs[n], mission.step, past) for n, robot in robots.items()}


def true_paths(mission: Mission, plan: Plan) -> dict[str, Path]:
    """Where agents and stations move, robots as they drive, each in as many pieces as it has."""
    width = 3 if mission.aerial else 2
    found = drives(mission, plan.runs, plan.executed)
    driven = {name: each.path(width) for name, each in found.items()}
    return {**paths(mission, plan.runs), **driven}


def robot_violations(
    mission: Mission, found: Mapping[str, Drive], past: int
) -> Iterator[Violation]:
    """Robots that leave their tubes after step `past`, each where it is farthest off."""
    for name, driven in found.items():
        agent = mission.agents[name]
        assert agent.robot is not None
        off = driven.off[past * driven.periods :]
        if not len(off) or off.max() <= agent.robot.radius + _TOLERANCE:
            continue
        when = past + (int(off.argmax()) + 1) / driven.periods
        text = (
            f"{name} can't follow its plan: at {when * mission.step:.4g} s it is {off.max():.6g} m "
            f"off, outside its tube of {agent.robot.radius:.6g} m"
        )
        yield Violation("tracking", text, float(off.max()) - agent.robot.radius, when, name,
                        agent.span)  # fmt: skip


def robot_notes(mission: Mission, found: Mapping[str, Drive]) -> Iterator[str]:
    """What the plan says of a robot, and what the robot does along it."""
    for name, driven in found.items():
        robot = mission.agents[name].robot
        assert robot is not None
        if not len(driven.speeds):
            continue
        yield (
            f"{name} drives within {robot.radius:.4g} m of the plan, that of a point "
            f"{robot.lookahead:.4g} m ahead of it: at most {np.abs(driven.speeds).max():.3g} m/s"
            f"{_held_back(robot)}, {_turning(robot, driven)}"
        )


def _held_back(robot: Robot) -> str:
    """What a short lookahead leaves of a unicycle's speed, where that is well below it."""
    b = robot.lookahead
    if robot.kind is not RobotKind.UNICYCLE or b * robot.turning > _MOST * robot.speed:
        return ""
    return (
        f" (its `lookahead` times `turn_rate` allows {b * robot.turning:.3g} of {robot.speed:.3g})"
    )


def _turning(robot: Robot, driven: Drive) -> str:
    """How sharply it turns: by the angle of a car's front wheels, else by its rate."""
    if robot.kind is RobotKind.UNICYCLE:
        return f"turning at most {np.abs(driven.rates).max():.3g} rad/s"
    speeds = np.abs(driven.speeds)
    angles = np.arctan2(robot.wheelbase * np.abs(driven.rates), speeds)[speeds > _MOVING]
    return f"steering at most {angles.max(initial=0.0) * 180.0 / pi:.3g} deg"
