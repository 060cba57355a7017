"""The search for link costs against the plain MILP: one optimum, no bound above it."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from support.link_missions import Variant, assert_same_optimum, compiled_mission

from stlc import backends
from stlc.api import load
from stlc.backends.base import SolveOptions, Status
from stlc.milp.compile import Compiled, compile_mission
from stlc.mission import Mission
from stlc.solve.certify import certify
from stlc.solve.relaxation.recognise import recognise
from stlc.solve.strategies import LINKS, run_strategy
from stlc.solve.strategy import Work
from stlc.verify import verify

FULL = os.environ.get("HYPOTHESIS_PROFILE") == "full"
VARIANTS = {
    "double": Variant(steps=4),
    "halves": Variant(dt=0.5, steps=4),
    "fine": Variant(cells=5, steps=4),
    "single": Variant(single=True, steps=4),
    "three": Variant(agents=3, steps=4, cells=3),
    "station": Variant(station=True, steps=4),
    "until": Variant(extra="a0 in west until[1, 4] a1 in east", steps=4),
    "linked": Variant(extra="always[2, 4] link_cost(radio, (a0, a1)) <= 5", steps=4),
}
SEEDS = range(8 if FULL else 2)
"""8 variants by 8 seeds; by 2 in the reduced profile."""


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", VARIANTS)
def test_same_optimum_as_the_plain_milp(name: str, seed: int, tmp_path: Path) -> None:
    assert_same_optimum(compiled_mission(tmp_path, seed, VARIANTS[name]))


def _verified(mission: Mission, compiled: Compiled, found: object) -> bool:
    from stlc.backends.base import Solution
    from stlc.plan import SolveInfo, make_plan

    assert isinstance(found, Solution)
    point = certify(compiled.model, found)
    assert point.status is Status.OPTIMAL
    assert point.x is not None
    run = compiled.decode(point.x)
    info = SolveInfo("optimal", point.objective, point.bound, point.gap, "highs", "", "auto")
    return verify(mission, make_plan(mission, run.states, run.inputs, info)).ok


def test_plain_missions_are_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "lonely.stl"
    path.write_text(
        "step 1 s\nhorizon 3\nworkspace box [0, 5] x [0, 5]\n"
        "agent a : double_integrator { start (1, 1); control |u| <= 1 }\n"
        "region home = box [1, 2] x [1, 2]\n"
        "require go: eventually[1, 3] a in home\nminimize effort\n",
        encoding="utf-8",
    )
    compiled = compile_mission(load(path))
    assert recognise(compiled) is None
    work = Work.of(compiled, backends.get("highs"), SolveOptions())
    assert LINKS.run(work) is work


def test_an_agent_on_a_face_counts_in_the_blocked_cell(tmp_path: Path) -> None:
    """Cells are closed and the outside of an obstacle is: the only cheap link is from the
    obstacle's own cell, which an agent on its face touches."""
    table = np.full((36, 36), 5.0)
    blocked, corner = 2 * 6 + 2, 0
    table[blocked, corner] = table[corner, blocked] = 0.1
    np.savetxt(tmp_path / "cost.csv", table, delimiter=",")
    path = tmp_path / "face.stl"
    path.write_text(
        "step 1 s\nhorizon 3\nworkspace box [0, 6] x [0, 6]\n"
        "agent a : double_integrator { start (2, 2.5); control |u| <= 1; speed <= 2 }\n"
        "agent b : double_integrator { start (0.5, 0.5); control |u| <= 1; speed <= 2 }\n"
        "obstacle block = box [2, 3] x [2, 3]\n"
        'channel radio { partition 6 x 6; table "cost.csv" }\n'
        "require clear: always[1, 3] a outside block\n"
        "minimize 0.1 * effort + 1.0 * link_cost(radio)\n",
        encoding="utf-8",
    )
    compiled = compile_mission(load(path))
    found = run_strategy("links", compiled, backends.get("highs"), SolveOptions(gap=1e-6))
    assert found.status is Status.OPTIMAL
    assert found.objective == pytest.approx(0.3, abs=1e-6)


def test_a_limit_leaves_a_valid_bound(tmp_path: Path) -> None:
    """Stopped at once, nothing is claimed."""
    compiled = compiled_mission(tmp_path, 0, VARIANTS["double"])
    options = SolveOptions(should_stop=lambda: True)
    found = run_strategy("links", compiled, backends.get("highs"), options)
    assert found.status in (Status.NO_SOLUTION, Status.FEASIBLE)
    assert found.gap is None or found.gap >= 0
