"""Why a plan is as it is: tight requirements, what decides them, what their margins cost."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from support.command import MISSION
from support.command import inside as stlc

from stlc.api import loads, solve
from stlc.explain.tight import Explained, explain_plan
from stlc.mission import Mission
from stlc.plan import Plan

WORLD = """horizon 6
workspace box [0, 10] x [0, 10]
agent a : double_integrator { start (1, 1); control |u| <= 1; speed <= 2 }
agent b : single_integrator { start (8, 2); control |u| <= 1 }
region goal = box [4, 5] x [1, 2]
obstacle pillar = box [7, 8] x [5, 6]
require go: eventually[0, 6] a in goal
require up: always[5, 6] b.y >= 4 m
require clear: always forall r in agents: r outside pillar
"""


def planned(text: str) -> tuple[Mission, Plan]:
    mission = loads(text)
    return mission, solve(mission).plan


def prices(found: Explained) -> dict[str, float | None]:
    return {s.name: s.price for s in found.standings}


@pytest.mark.parametrize(
    "objective", ["minimize effort", "maximize -1 * effort", "minimize effort + 0.5 * effort(a)"]
)
@pytest.mark.parametrize("name", ["go", "up"])
def test_a_price_is_what_a_little_more_margin_costs(objective: str, name: str) -> None:
    """Against a solve with the margin raised: small enough for the integers to stay."""
    mission, plan = planned(f"{WORLD}{objective}\n")
    price = prices(explain_plan(mission, plan))[name]
    more = tuple(
        replace(r, margin=r.margin + 0.01) if r.name == name else r for r in mission.requirements
    )
    other = solve(replace(mission, requirements=more)).plan
    assert price is not None
    assert plan.solve.objective is not None
    assert other.solve.objective is not None
    assert price * 0.01 == pytest.approx(other.solve.objective - plan.solve.objective, rel=0.05)
    assert abs(price) > 0.1


def test_what_is_tight_and_what_decides_it() -> None:
    mission, plan = planned(f"{WORLD}minimize effort\n")
    found = explain_plan(mission, plan)
    by_name = {s.name: s for s in found.standings}
    assert {s.name for s in found.standings if s.tight} == {"go", "up"}
    assert (by_name["go"].decides, by_name["go"].step) == ("a in goal", 6)
    assert (by_name["up"].decides, by_name["up"].step) == ("b.y >= 4 m", 5)
    assert by_name["clear"].slack == pytest.approx(1.0)
    assert by_name["clear"].price is None
    assert "b outside pillar" in found.text()
    assert "LP with the plan's integers fixed" in found.text()


def test_without_an_objective_nothing_has_a_price() -> None:
    mission, plan = planned(WORLD)
    assert set(prices(explain_plan(mission, plan)).values()) == {None}


def test_links_are_told_with_their_levels() -> None:
    link = """station base at (5, 0)
channel radio { path_loss L0 = -40 dBm, n = 3; partition 10 x 10 }
require talk: always rssi(b, base) >= -70 dBm
minimize effort
"""
    mission, plan = planned(WORLD + link)
    (talk,) = (s for s in explain_plan(mission, plan).standings if s.name == "talk")
    assert talk.decides == "rssi(b, base) >= -70 dBm"
    assert talk.unit == "dB"


def test_as_a_person_calls_it(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(MISSION)
    done = stlc("solve", "m.stl", "-o", "p.json", "--progress", "none", folder=tmp_path)
    assert "tight: visit (a in near at step 4)" in done.stdout
    assert "tight: visit" in stlc("verify", "m.stl", "p.json", folder=tmp_path).stdout
    told = stlc("explain", "m.stl", "p.json", "--json", folder=tmp_path)
    assert told.returncode == 0
    first = json.loads(told.stdout)["requirements"][0]
    assert first["requirement"] == "visit"
    assert first["tight"]
    assert first["marginal_cost"] == pytest.approx(4 / 7, rel=1e-4)  # in x and in y
    assert stlc("explain", "m.stl", "p.json", "--fix", folder=tmp_path).returncode == 2
    (tmp_path / "n.stl").write_text(MISSION.replace("[2, 3] x [1, 2]", "[2.5, 3] x [1, 2]"))
    broken = stlc("explain", "n.stl", "p.json", folder=tmp_path)
    assert broken.returncode == 6
    assert "violates" in broken.stdout
    plan = json.loads((tmp_path / "p.json").read_text())
    plan["agents"]["a"]["inputs"][1][0] += 0.5
    (tmp_path / "off.json").write_text(json.dumps(plan))
    told = stlc("verify", "m.stl", "off.json", folder=tmp_path).stdout
    lines = [line for line in told.splitlines() if line.startswith("  violated: ")]
    off = stlc("explain", "m.stl", "off.json", folder=tmp_path)
    assert off.returncode == 6
    assert lines
    assert off.stdout.splitlines()[1 : 1 + len(lines)] == lines
