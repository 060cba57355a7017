"""Missions with a drone and a cart, and plans of where they are step by step."""

import numpy as np

from stlc.api import loads
from stlc.mission import Mission
from stlc.plan import Plan, make_plan

HEAD = """
step 1 s
horizon 4
workspace box [0, 10] x [0, 10]
dynamics drone = single_integrator {{ dimensions 3; pz in [0, 10]; control |u| <= 4 }}
agent a : drone {{ start (1, 5, 2) }}
agent g : single_integrator {{ start (1, 1); control |u| <= 4 }}
{}
"""


def mission(text: str) -> Mission:
    """The mission with some statements more."""
    return loads(HEAD.format(text))


def flown(found: Mission, *places: tuple[float, float, float]) -> Plan:
    """The plan whose drone is at these places, step by step, and whose cart rests."""
    run = np.array([*places, *[places[-1]] * (found.horizon + 1 - len(places))], dtype=float)
    rest = np.tile(found.agents["g"].start, (found.horizon + 1, 1))
    runs = {"a": run, "g": rest}
    return make_plan(found, runs, {n: np.diff(r, axis=0) for n, r in runs.items()})
