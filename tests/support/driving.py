"""The nonlinear models of robots, integrated by themselves: an oracle for tubes."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import atan2, cos, hypot, sin, tan

import numpy as np

from stlc.robots import Robot, RobotKind

FINE = 4  # Runge-Kutta steps in a control period


@dataclass(frozen=True)
class Driven:
    """What a robot did: fine times [steps], centres, headings; commands by period."""

    times: np.ndarray
    centres: np.ndarray
    headings: np.ndarray
    speeds: np.ndarray
    turns: np.ndarray  # rad/s, or the steering angle [rad] of a car


def law(robot: Robot, x: float, y: float, theta: float, goal: np.ndarray) -> tuple[float, float]:
    """The controller as the documentation states it, without limits: (v, omega)."""
    b, d = robot.lookahead, robot.period
    dx, dy = goal[0] - x - b * cos(theta), goal[1] - y - b * sin(theta)
    d1, d2 = cos(theta) * dx + sin(theta) * dy, -sin(theta) * dx + cos(theta) * dy
    h = 2.0 * atan2(d2, 2.0 * b + d1)
    shrink = np.sinc(h / 2.0 / np.pi)
    return (cos(h / 2.0) * d1 + sin(h / 2.0) * d2) / (d * shrink), h / d


def driven(robot: Robot, plan: np.ndarray, step: float) -> Driven:
    """Drives along the plan (T+1, 2) of the look-ahead point from the robot's heading."""
    periods = round(step / robot.period)
    b, theta = robot.lookahead, robot.heading
    x, y = plan[0] - b * np.array([cos(theta), sin(theta)])
    times, states, commands = [0.0], [(x, y, theta)], []
    for t, (start, end) in enumerate(pairwise(plan)):
        for k in range(periods):
            goal = start + (end - start) * (k + 1) / periods
            v, omega = law(robot, x, y, theta, goal)
            turn = omega
            if robot.kind is RobotKind.CAR:
                turn = atan2(robot.wheelbase * omega, v) if hypot(v, omega) > 1e-9 else 0.0
            commands.append((v, turn))
            for j in range(FINE):
                x, y, theta = _runge_kutta(robot, (x, y, theta), v, turn)
                times.append(t + (k + (j + 1) / FINE) / periods)
                states.append((x, y, theta))
    found, held = np.array(states), np.array(commands)
    return Driven(np.array(times), found[:, :2], found[:, 2], held[:, 0], held[:, 1])


def _runge_kutta(
    robot: Robot, state: tuple[float, float, float], v: float, turn: float
) -> tuple[float, float, float]:
    def flow(s: np.ndarray) -> np.ndarray:
        rate = v * tan(turn) / robot.wheelbase if robot.kind is RobotKind.CAR else turn
        return np.array([v * cos(s[2]), v * sin(s[2]), rate])

    s, h = np.array(state), robot.period / FINE
    k1 = flow(s)
    k2 = flow(s + h / 2.0 * k1)
    k3 = flow(s + h / 2.0 * k2)
    k4 = flow(s + h * k3)
    x, y, theta = s + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return float(x), float(y), float(theta)


def along(plan: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Places of the plan at fractional steps."""
    steps = np.arange(len(plan))
    return np.column_stack([np.interp(times, steps, plan[:, k]) for k in (0, 1)])
