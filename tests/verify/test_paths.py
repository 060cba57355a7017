"""Motion between samples that doubles can't follow is never taken for fine."""

from dataclasses import replace

import numpy as np
import pytest

from stlc.api import loads
from stlc.dynamics import Flow
from stlc.plan import make_plan
from stlc.verify import verify
from stlc.verify.chains import Chain
from stlc.verify.paths import FINE, MOST_PIECES, least_pieces, path_of

TEXT = """step 1 s
horizon 2
workspace box [0, 10] x [0, 10] sampled
dynamics k { A = [[1, 0], [0, 1]]; B = [[1, 0], [0, 1]]; states px py; position px py }
agent r : k { start (1, 1); control |u| <= 5 }
obstacle o = box [4, 6] x [4, 6]
region g = box [0, 3] x [0, 3]
"""


def _restless(text, growth):
    """A mission whose agent is at rest at its samples, by a flow that grows by far in a step."""
    mission = loads(TEXT + text)
    agent = mission.agents["r"]
    n = len(agent.dynamics.A)
    flow = Flow(growth * np.diag([1.0, -1.0]), np.zeros((n, 2)), np.zeros(n))
    model = replace(agent.dynamics, flow=flow)
    mission = replace(mission, agents={"r": replace(agent, dynamics=model)})
    return mission, make_plan(mission, {"r": np.ones((3, n))}, {"r": np.zeros((2, 2))})


SWEPT = {
    "outside": "require: always r outside o swept",
    "inside": "require: always r in g swept",
    "condition": "require: always (r.x <= 9 m) swept",
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("growth", [1e3, 1e110, 1e308])
@pytest.mark.parametrize("text", SWEPT.values(), ids=SWEPT.keys())
def test_what_overflows_between_samples_fails_every_swept_requirement(text, growth):
    mission, plan = _restless(text + "\n", growth)
    report = verify(mission, plan)
    assert "swept" in [v.kind for v in report.violations]
    (requirement,) = report.requirements
    assert requirement.robustness > 0.0
    assert not requirement.satisfied


@pytest.mark.filterwarnings("error")
def test_what_overflows_between_samples_leaves_the_workspace():
    mission, plan = _restless("require: always r.x <= 9 m\n", 1e110)
    assert verify(mission, plan).ok  # it holds at the samples, and nothing more is asked
    report = verify(replace(mission, workspace_swept=True), plan)
    assert [v.kind for v in report.violations] == ["workspace"]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("growth", [1e110, 1e200, 1e308])
def test_an_error_bound_that_overflows_is_infinite(growth):
    mission, plan = _restless("require: always r.x <= 9 m\n", growth)
    agent, run = mission.agents["r"], plan.runs["r"]
    assert least_pieces(agent, run, 1.0) == MOST_PIECES
    path = path_of(agent, run, 1.0)
    assert np.isposinf(path.room[: 2 * path.pieces]).all()
    assert np.isfinite(path.c0).all()


def test_a_chain_is_off_by_what_its_path_is():
    mission, plan = _restless("require: always r.x <= 9 m\n", 0.5)
    agent, run = mission.agents["r"], plan.runs["r"]
    path = path_of(agent, run, 1.0)
    assert path.room.max() <= FINE
    assert not Chain.of(path).room.any()
    off = replace(path, error=np.full(len(path.c0), 1e-3))
    assert (Chain.of(off).room == 1e-3).all()
