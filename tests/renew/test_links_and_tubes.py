"""Missions with links, and disturbed agents, planned anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stlc import api
from stlc.milp.compile import CompileOptions
from stlc.solve.outcome import SolveSettings
from stlc.verify import verify

CART = """step 1 s
horizon 8
workspace box [0, 10] x [0, 10]
agent a : double_integrator { start (2, 5); control |u| <= 1; speed <= 1.5; vx >= -1 }
obstacle wall = box [4, 5] x [0, 6]
require go: eventually[0, 8] a.y >= 6.5 m
require clear: always a outside wall
minimize effort
"""

RADIO = """step 1 s
horizon 6
workspace box [0, 10] x [0, 10]
agent a : double_integrator { start (2, 5); control |u| <= 1; speed <= 1.5 }
station base at (8, 5)
channel c { path_loss L0 = -30 dBm, n = 2; shadowing 2 dB^2, length 2 m; partition CELLS }
require talk: always rssi(a, base) >= -52 dBm
require go: eventually[0, 6] a.x >= 3.5 m
minimize effort + 0.01 * link_cost(c)
"""


@pytest.mark.parametrize("cells", ["5 x 5", "quadtree 4 x 4 tolerance 3 dB cells 60", "auto"])
def test_links_go_on_beyond_the_workspace(cells: str) -> None:
    """Cells at the border reach as far as an agent may have got."""
    text = RADIO.replace("CELLS", cells).replace("channel c {", "channel c { noise_floor -90 dBm;")
    mission = api.loads(text)
    plan = api.solve(mission).plan
    found = api.replan(mission, plan, 2, {"a": np.array([-0.3, 5.0, -0.2, 0.0])})
    assert [s.text for s in found.softened] == ["a: within the workspace"]
    assert (found.plan.runs["a"].states[4:, 0] >= -1e-6).all()
    assert found.plan.runs["a"].states[-1, 0] >= 0.5
    assert not found.lost


@pytest.mark.parametrize("cells", ["5 x 5", "quadtree 4 x 4 tolerance 3 dB cells 60", "auto"])
def test_links_beyond_the_workspace_are_judged_alike(cells: str) -> None:
    """Outside for some steps: whoever judges the plan later gives links the same values, those of
    the cells at the border."""
    text = RADIO.replace("CELLS", cells).replace("channel c {", "channel c { noise_floor -90 dBm;")
    mission = api.loads(text)
    plan = api.solve(mission).plan
    found = api.replan(mission, plan, 2, {"a": np.array([-4.0, 5.0, 0.0, 0.0])})
    assert (found.plan.runs["a"].states[3:, 0] < -1.0).any()
    (said,) = (r for r in found.report.requirements if r.name == "talk")
    (again,) = (r for r in verify(mission, found.plan).requirements if r.name == "talk")
    assert again.robustness is not None
    assert np.isfinite(again.robustness)
    assert again.robustness == said.robustness
    assert verify(mission, found.plan).objective == found.report.objective


def test_tables_that_a_loop_shares_are_those_of_its_cells() -> None:
    """Outside of the workspace cells go on: what was kept for those within is none of theirs."""
    text = RADIO.replace("CELLS", "5 x 5").replace("c {", "c { noise_floor -90 dBm;", 1)
    mission = api.loads(text)
    plan = api.solve(mission).plan
    settings = SolveSettings(compile=CompileOptions(tables={}))
    near, far = np.array([-0.3, 5.0, 0.0, 0.0]), np.array([-4.0, 5.0, 0.0, 0.0])
    assert not api.replan(mission, plan, 2, {"a": near}, settings=settings).given_up
    assert "talk" in api.replan(mission, plan, 2, {"a": far}, settings=settings).given_up


def test_disturbed_agents_begin_a_new_tube_where_they_are() -> None:
    text = CART.replace("vx >= -1", "disturbance |w| <= 0.02")
    mission = api.loads(text)
    plan = api.solve(mission).plan
    measured = plan.runs["a"].states[3] + [0.02, -0.03, 0.01, 0.02]
    found = api.replan(mission, plan, 3, {"a": measured})
    assert found.kept
    again = verify(mission, found.plan)
    assert again.ok
    late, early = (verify(mission, replace(found.plan, executed=k)) for k in (3, 0))
    rooms = [{r.name: r.robustness for r in v.requirements}["go"] for v in (late, early)]
    assert rooms[0] > rooms[1] + 1e-4  # the tube of a plan made earlier is wider by then


BY_CELLS = """step 1 s
workspace box [0, 10] x [0, 2]
agent a : single_integrator { start (1, 1); control |u| <= 2 }
station base at (0, 1)
channel radio { path_loss L0 = -40 dBm, n = 2; partition [0, 2, 6, 10] x [0, 2] }
require heard: always[0, 3] rssi(a, base) >= -52.1 dBm
minimize effort
"""


@pytest.mark.parametrize("step", [0, 1, 2, 3])
def test_the_step_that_was_measured_last_is_judged_where_agents_were(step: int) -> None:
    """At 3 m the base is heard, and not anywhere in that cell: what was measured there counts."""
    mission = api.loads(BY_CELLS.replace("[0, 3]", "[0, 4]"))
    plan = api.solve(mission).plan
    again = api.replan(mission, plan, step, {"a": np.array([3.0, 1.0])})
    judged = {r.name: r.robustness for r in again.report.requirements}["heard"]
    assert (judged >= 0.0) == again.kept == (step > 0)
    assert verify(mission, again.plan).ok == (step > 0)
