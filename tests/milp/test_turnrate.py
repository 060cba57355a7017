"""The turning rate: sound, and as tight as it claims."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.worlds import mission, most_robust

from stlc.backends import get
from stlc.backends.base import SolveOptions, Status
from stlc.dynamics import Dynamics
from stlc.ir.nodes import Linear, Role, Signal
from stlc.ir.requirement import Requirement
from stlc.milp.compile import compile_mission
from stlc.mission import Agent, Mission, TurnRate
from stlc.trajectories import Trajectories


def cart(turn: TurnRate, velocity: tuple[float, float]) -> Agent:
    """A double integrator in the plane."""
    A = np.block([[np.eye(2), np.eye(2)], [np.zeros((2, 2)), np.eye(2)]])
    B = np.vstack([0.5 * np.eye(2), np.eye(2)])
    states = ("px", "py", "vx", "vy")
    dynamics = Dynamics("cart", A, B, np.zeros(4), states, ("ux", "uy"), ("",) * 4, ("",) * 2,
                        np.eye(2, 4), (2, 3))  # fmt: skip
    ends, push = np.array([20.0, 20.0, 2.0, 2.0]), np.ones(2)
    return Agent("a", dynamics, np.array([0.0, 0.0, *velocity]), -ends, ends, -push, push,
                 np.zeros(4), np.ones(2), turn_rate=turn)  # fmt: skip


def farthest(agent: Agent, index: int, horizon: int = 5) -> tuple[float, Trajectories] | None:
    """The greatest state `index` that the agent reaches."""
    reach = Linear(((Signal("a", Role.STATE, index, horizon), 1.0),), 10.0)
    world: Mission = mission((agent,), horizon, (Requirement("far", reach),), most_robust())
    compiled = compile_mission(world)
    found = get("highs").solve(compiled.model, SolveOptions(threads=1))
    if found.x is None or found.objective is None:
        assert found.status is Status.INFEASIBLE
        return None
    return -found.objective - 10.0, compiled.decode(found.x)


@pytest.mark.parametrize("directions", [4, 8, 16])
@pytest.mark.parametrize("literal", [False, True])
def test_every_run_keeps_the_euclidean_rate(directions: int, literal: bool) -> None:
    turn = TurnRate(1.0, 2.0, directions, literal, rest_speed=0.2)
    found = farthest(cart(turn, (1.0, 0.0)), 1)
    assert found is not None
    run = found[1]
    speed = np.linalg.norm(run.states["a"][:-1, 2:], axis=1)
    push = np.linalg.norm(run.inputs["a"], axis=1)
    resting = (speed <= turn.rest_speed + 1e-6) & (not literal)
    assert ((push <= turn.u_max / turn.v_max * speed + 1e-6) | resting).all()


def test_finer_directions_lose_less() -> None:
    turns = [TurnRate(1.0, 2.0, k, literal=True) for k in (4, 8, 16)]
    found = [farthest(cart(t, (1.0, 0.0)), 1) for t in turns]
    reached = [f[0] for f in found if f is not None]
    assert len(reached) == 3
    assert reached[0] < reached[1] < reached[2]
    # Straight ahead nothing is lost but cos(pi / 16): speed grows by a factor 1 + 0.98 / 2 a step.
    ahead = farthest(cart(turns[2], (0.2, 0.0)), 2, 4)
    assert ahead is not None
    assert ahead[0] == pytest.approx(0.2 * (1 + np.cos(np.pi / 16) ** 2 / 2) ** 4, rel=0.05)


def test_literal_freezes_an_agent_at_rest() -> None:
    turn = TurnRate(1.0, 2.0, 8, literal=True)
    frozen = farthest(cart(turn, (0.0, 0.0)), 1)
    free = farthest(cart(replace(turn, literal=False), (0.0, 0.0)), 1)
    assert frozen is not None
    assert free is not None
    assert frozen[0] == pytest.approx(0.0, abs=1e-6)
    assert free[0] > 1.0
