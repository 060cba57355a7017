"""What a plan made anew gives up: no more than what cannot be kept."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.command import inside as stlc

from stlc import api

GOALS = """horizon 8
workspace box [0, 10] x [0, 10]
agent a : single_integrator { start (1, 1); speed <= 2 }
agent b : single_integrator { start (9, 1); control |u| <= 2 }
region dock = box [8, 9] x [5, 6]
region yard = box [1, 2] x [5, 6]
obstacle pil = box [4, 6] x [3, 4]
require go: eventually[0, 7] a in dock
require go2: eventually[0, 7] b in yard
require clear: always a outside pil swept
minimize effort
"""


def test_what_is_lost_takes_nothing_else_with_it() -> None:
    """The pillar is left from 0.5 m deep; both goals are in reach, effort pulls away from them."""
    mission = api.loads(GOALS)
    found = api.replan(mission, api.solve(mission).plan, 3, {"a": np.array([5.0, 3.5])})
    assert found.given_up == ("clear",)
    by = {r.name: r for r in found.report.requirements}
    assert by["go"].robustness >= -1e-6
    assert by["go2"].robustness >= -1e-6
    assert by["clear"].robustness == pytest.approx(-0.5, abs=1e-6)


def test_what_is_missed_is_missed_by_no_more_than_need_be() -> None:
    """Two steps of at most 2 m are left for 5 m, from 4 m outside: 1 m is missing, 2 m outside."""
    text = GOALS.replace("[0, 7] a", "[0, 5] a").replace("speed <= 2", "control |u| <= 2")
    mission = api.loads(text)
    found = api.replan(mission, api.solve(mission).plan, 3, {"a": np.array([14.0, 5.0])})
    assert found.given_up == ("go",)
    by = {r.name: r for r in found.report.requirements}
    assert by["go"].robustness == pytest.approx(-1.0, abs=1e-6)
    (soft,) = found.softened
    assert soft.most == pytest.approx(2.0, abs=1e-6)


def test_a_broken_bound_is_told_by_the_exit_status(tmp_path: Path) -> None:
    """Kept again from the next step on, and yet broken."""
    text = GOALS.replace("speed <= 2", "control |u| <= 2").replace(" swept", "")
    (tmp_path / "m.stl").write_text(text)
    api.solve(api.loads(text)).plan.write(tmp_path / "p.json")
    (tmp_path / "now.json").write_text('{"states": {"a": [12, 5]}}')
    words = ("replan", "m.stl", "p.json", "--at", 2, "--state", "now.json")
    done = stlc(*words, folder=tmp_path)
    assert "kept again from the next step on" in done.stdout
    assert done.returncode == 6
