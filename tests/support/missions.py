"""Checked missions built by hand, without parser and semantic analysis."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from stlc.dynamics import Dynamics, Flow
from stlc.ir.nodes import Always, And, Eventually, Linear, Node, Or, Role, Signal
from stlc.ir.requirement import Requirement
from stlc.mission import Agent, Channel, Mission, Station
from stlc.places import Obstacle, Polytope, Region
from stlc.source import Source

INF = math.inf


def box(x0: float, x1: float, y0: float, y1: float) -> Polytope:
    normals = np.array([[-1.0, 0], [1, 0], [0, -1], [0, 1]])
    vertices = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], dtype=float)
    return Polytope(normals, np.array([-x0, x1, -y0, y1], dtype=float), vertices)


def double_integrator(dt: float = 1.0) -> Dynamics:
    eye, zero = np.eye(2), np.zeros((2, 2))
    return Dynamics(
        "cart",
        np.block([[eye, dt * eye], [zero, eye]]),
        np.vstack([dt**2 / 2 * eye, dt * eye]),
        np.zeros(4),
        ("px", "py", "vx", "vy"),
        ("ux", "uy"),
        ("m", "m", "m/s", "m/s"),
        ("m/s^2", "m/s^2"),
        np.eye(2, 4),
        (2, 3),
        flow=Flow(np.block([[zero, eye], [zero, zero]]), np.vstack([zero, eye]), np.zeros(4)),
    )


def agent(name: str, start: Sequence[float], u_max: float = 1.0, **extra: Any) -> Agent:
    fields: dict[str, Any] = {
        "dynamics": double_integrator(),
        "state_lower": np.full(4, -INF),
        "state_upper": np.full(4, INF),
        "input_lower": np.full(2, -u_max),
        "input_upper": np.full(2, u_max),
        "effort_state": np.zeros(4),
        "effort_input": np.ones(2),
    } | extra
    x0 = np.concatenate([np.asarray(start, dtype=float), np.zeros(4 - len(start))])
    return Agent(name=name, start=x0, **fields)


def position(name: str, axis: int, shift: int = 0) -> Signal:
    return Signal(name, Role.STATE, axis, shift)


def _face(name: str, normal: np.ndarray, offset: float, sign: float) -> Linear:
    """sign * (normal . p - offset) >= 0."""
    terms = tuple((position(name, k), sign * float(normal[k])) for k in (0, 1) if normal[k])
    return Linear(terms, -sign * float(offset), "m")


def inside(name: str, shape: Polytope) -> Node:
    faces = zip(shape.normals, shape.offsets, strict=True)
    return And(tuple(_face(name, n, c, -1.0) for n, c in faces))


def outside(name: str, shape: Polytope, **extra: Any) -> Node:
    faces = zip(shape.normals, shape.offsets, strict=True)
    return Or(tuple(_face(name, n, c, 1.0) for n, c in faces), **extra)


def reach(name: str, shape: Polytope, horizon: int) -> Node:
    return Eventually(inside(name, shape), 0, horizon)


def avoid(name: str, shape: Polytope) -> Node:
    return Always(outside(name, shape), 0, None)


def mission(
    agents: Sequence[Agent],
    requirements: Sequence[Requirement] = (),
    *,
    horizon: int,
    channels: Sequence[Channel] = (),
    stations: Sequence[Station] = (),
    regions: Sequence[Region] = (),
    obstacles: Sequence[Obstacle] = (),
    **extra: Any,
) -> Mission:
    def named(things: Sequence[Any]) -> dict[str, Any]:
        return {thing.name: thing for thing in things}

    fields: dict[str, Any] = {"step": 1.0, "workspace": None, "objective": ()} | extra
    return Mission(
        source=Source("hand.stl", "# built by hand\n"),
        horizon=horizon,
        agents=named(agents),
        stations=named(stations),
        regions=named(regions),
        obstacles=named(obstacles),
        channels=named(channels),
        requirements=tuple(requirements),
        **fields,
    )


def obstacle(name: str, body: Polytope, inflated: Polytope | None = None) -> Obstacle:
    return Obstacle(name, ((inflated or body,),), ((body,),))


def roll(one: Agent, inputs: Any) -> tuple[np.ndarray, np.ndarray]:
    """States (T+1, n) and inputs (T, m) from an input sequence."""
    u = np.asarray(inputs, dtype=float)
    x = [one.start]
    for row in u:
        x.append(one.dynamics.A @ x[-1] + one.dynamics.B @ row + one.dynamics.drift)
    return np.array(x), u
