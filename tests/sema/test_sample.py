"""The mission of the README, from text to the checked mission."""

from __future__ import annotations

import numpy as np
import pytest

from stlc.api import loads
from stlc.ir.nodes import Always, And, Eventually, Link, Quantity, Relation
from stlc.mission import Mission, TermKind

SAMPLE = """
step 1 s
workspace box [0, 10] x [0, 10]
dynamics cart = double_integrator
agent r1 : cart { start (1, 1); control |u| <= 1; speed <= 2; turn_rate on; mass 1 kg }
agent r2 : cart { start (9, 1); control |u| <= 1; speed <= 2 }
station base at (5, 0)
region goal1 = box [8, 9] x [8, 9]
region goal2 = polygon (1, 8) (2, 8) (2, 9) (1, 9)
obstacle pillar = box [4, 6] x [4, 6] inflate 0.3 m
channel radio {
  path_loss L0 = -12.89 dBm, n = 3
  fading 10 dB^2, shadowing 10 dB^2, length 2 m
  noise_floor -30 dBm, modulation oqpsk_802_15_4
  partition 10 x 10
}
let home(a, g) = eventually[0, 8] a in g
require reach1: home(r1, goal1)
require reach2: home(r2, goal2)
require clear:  always forall a in agents: a outside pillar
require apart:  always separation(r1, r2) >= 0.5 m
require talk:   always[2, 6] ber(r1, r2) <= 1e-3
require sure:   eventually[0, 8] P(rssi(r1, base) >= -36 dBm) >= 0.95
minimize 0.1 * effort + 0.9 * link_cost(radio)
"""


@pytest.fixture(scope="module")
def mission() -> Mission:
    return loads(SAMPLE)


def test_horizon_comes_from_the_intervals(mission: Mission) -> None:
    assert mission.horizon == 8
    assert mission.step == 1.0


def test_agents(mission: Mission) -> None:
    r1 = mission.agents["r1"]
    assert np.array_equal(r1.start, [1, 1, 0, 0])
    assert np.array_equal(r1.input_upper, [1, 1])
    assert r1.state_norms[0].limit == 2.0
    assert r1.turn_rate is not None
    assert (r1.turn_rate.u_max, r1.turn_rate.v_max) == (1.0, 2.0)
    assert r1.dynamics.flow is not None


def test_obstacle_is_inflated_as_a_box(mission: Mission) -> None:
    pillar = mission.obstacles["pillar"]
    corners = pillar.frames[0][0].vertices
    assert sorted(map(tuple, np.round(corners, 9))) == [
        (3.7, 3.7),
        (3.7, 6.3),
        (6.3, 3.7),
        (6.3, 6.3),
    ]
    assert pillar.bodies[0][0].vertices.max() == 6.0


def test_channel(mission: Mission) -> None:
    radio = mission.channels["radio"]
    assert radio.model is not None
    assert (radio.model.l0, radio.model.exponent, radio.model.length) == (-12.89, 3.0, 2.0)
    assert radio.budget is not None
    assert radio.budget.noise_floor == -30.0
    assert radio.partition.shape == (10, 10)


def test_formulas(mission: Mission) -> None:
    by_name = {r.name: r.formula for r in mission.requirements}
    reach = by_name["reach1"]
    assert isinstance(reach, Eventually)
    assert isinstance(reach.arg, And)
    assert len(reach.arg.args) == 4
    clear = by_name["clear"]
    assert isinstance(clear, Always)
    assert clear.end is None
    talk = by_name["talk"]
    assert isinstance(talk, Always)
    link = talk.arg
    assert isinstance(link, Link)
    assert (link.quantity, link.relation, link.threshold) == (Quantity.BER, Relation.AT_MOST, 1e-3)
    sure = by_name["sure"]
    assert isinstance(sure, Eventually)
    assert isinstance(sure.arg, Link)
    assert sure.arg.probability == 0.95


def test_objective(mission: Mission) -> None:
    effort, link = mission.objective
    assert (effort.kind, effort.weight, effort.agents) == (TermKind.EFFORT, 0.1, ("r1", "r2"))
    assert (link.kind, link.weight, link.pairs) == (TermKind.LINK_COST, 0.9, (("r1", "r2"),))
