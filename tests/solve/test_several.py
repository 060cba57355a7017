"""Several plans: each verified, far enough from the others, and the best of those that are."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import numpy as np
import pytest
from support.command import inside as stlc

from stlc import api
from stlc.errors import UsageError
from stlc.mission import Mission
from stlc.plan import read_plan
from stlc.solve.outcome import Outcome, SolveSettings
from stlc.solve.several import solve_several

MISSION = """step 1 s
horizon 3
workspace box [0, 4] x [0, 4]
agent a : single_integrator { start (1, 1); control |u| <= 1; integer }
agent b : single_integrator { start (3, 3); control |u| <= 1; integer }
require go: eventually[0, 3] a.x >= 2 m
minimize effort(a) + 2 * effort(b)
"""


def _apart(one: Outcome, other: Outcome) -> float:
    """The largest separation of an agent from its other run at any step."""
    runs = one.plan.runs
    return max(float(np.abs(runs[n].states - other.plan.runs[n].states).max()) for n in runs)


def _brute(mission: Mission, chosen: list[np.ndarray], distance: float) -> float:
    """Least cost of all runs that differ from those chosen, stacked (T+1, 4)."""
    moves = np.array(list(itertools.product((-1, 0, 1), repeat=4)), dtype=float)
    start = np.concatenate([mission.agents[n].start for n in "ab"])
    first = start + moves
    best = np.inf
    cost = np.abs(moves) @ [1, 1, 2, 2]
    for i, j in itertools.product(range(len(moves)), repeat=2):
        p2 = first[i] + moves[j]
        p3 = p2 + moves
        total = cost[i] + cost[j] + cost
        good = (p3 >= 0).all(axis=1) & (p3 <= 4).all(axis=1)
        good &= bool((first[i] >= 0).all() and (first[i] <= 4).all())
        good &= bool((p2 >= 0).all() and (p2 <= 4).all())
        good &= (p3[:, 0] >= 2) | (p2[0] >= 2) | (first[i][0] >= 2)
        for other in chosen:
            near = max(np.abs(first[i] - other[1]).max(), np.abs(p2 - other[2]).max())
            good &= np.maximum(near, np.abs(p3 - other[3]).max(axis=1)) >= distance - 1e-6
        best = min(best, float(total[good].min(initial=np.inf)))
    return best


@pytest.mark.parametrize("distance", [1.0, 2.0])
def test_each_is_the_best_of_those_that_differ(distance: float) -> None:
    mission = api.loads(MISSION)
    found = solve_several(mission, SolveSettings(), 3, distance).plans
    assert len(found) == 3
    chosen: list[np.ndarray] = []
    for outcome in found:
        assert api.verify(mission, outcome.plan).ok
        assert outcome.plan.solve.objective == pytest.approx(_brute(mission, chosen, distance))
        chosen.append(np.hstack([np.round(outcome.plan.runs[n].states) for n in "ab"]))
        assert [r.name for r in outcome.plan.requirements] == ["go"]
    for one, other in itertools.combinations(found, 2):
        assert _apart(one, other) >= distance - 1e-5


def test_it_says_when_there_are_no_more() -> None:
    mission = api.loads(
        "step 1 s\nhorizon 1\nworkspace box [0, 2] x [0, 1]\n"
        "agent a : single_integrator { start (1, 0); control |u| <= 1; integer }\n"
        "require low: always a.y <= 0.5 m\nminimize effort\n"
    )
    found = solve_several(mission, SolveSettings(), 5, 1.0)
    assert sorted(round(float(o.plan.runs["a"].states[1, 0])) for o in found.plans) == [0, 1, 2]
    assert found.fewer == "3 plans of the 5 asked for: no other differs from each of them by 1 m"
    assert solve_several(mission, SolveSettings(), 3, 1.0).fewer is None


def test_the_command_says_so_whatever_progress_it_shows(tmp_path: Path) -> None:
    """Names that only the search gives stay in it; files of an earlier run are left, and named."""
    (tmp_path / "m.stl").write_text(MISSION)
    words = ("solve", "m.stl", "--progress", "none", "-o", "p.json", "--different")
    three = stlc(*words, "1 m", "--solutions", "3", folder=tmp_path)
    assert "different_" not in three.stdout
    assert "note: p" not in three.stdout
    one = stlc(*words, "3.5 m", "--solutions", "2", folder=tmp_path)
    assert one.returncode == 0
    told = "1 plan of the 2 asked for: no other differs from it by 3.5 m"
    assert f"note: {told}\n" in one.stdout
    assert "note: p-2.json is of an earlier run" in one.stdout
    assert "note: p-3.json is of an earlier run" in one.stdout
    again = json.loads(stlc(*words, "3.5 m", "--solutions", "2", "--json", folder=tmp_path).stdout)
    assert again["fewer"] == told
    assert again["left_over"] == ["p-2.json", "p-3.json"]


def test_plans_in_space_may_differ_by_height() -> None:
    mission = api.loads(
        "step 1 s\nhorizon 1\nworkspace box [0, 2] x [0, 2]\n"
        "dynamics drone = single_integrator { dimensions 3; pz in [0, 4] }\n"
        "agent a : drone { start (1, 1, 1); uz in [-1, 1]; ux in [0, 0]; uy in [0, 0] }\n"
        "require low: always a.z <= 5 m\nminimize effort\n"
    )
    found = solve_several(mission, SolveSettings(), 3, 1.0).plans
    assert sorted(round(float(o.plan.runs["a"].states[1, 2])) for o in found) == [0, 1, 2]


def test_plans_of_what_is_nowhere_cannot_differ() -> None:
    mission = api.loads(
        "horizon 2\ndynamics tank { states level; inputs pump; A = [[1]]; B = [[1]] }\n"
        "agent t : tank { start (1); pump in [0, 1] }\nrequire a: always t.level >= 0 m\n"
    )
    with pytest.raises(UsageError, match="differ"):
        solve_several(mission, SolveSettings(), 2, 1.0)


def test_the_command_writes_them_all(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(MISSION)
    words = ("solve", "m.stl", "--solutions", "3", "-o", "p.json", "--json")
    done = stlc(*words, "--different", "200 cm", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    values = [said["objective"], *(other["objective"] for other in said["others"])]
    assert values == sorted(values)
    for name, value in zip(("p.json", "p-2.json", "p-3.json"), values, strict=True):
        assert read_plan(tmp_path / name).solve.objective == pytest.approx(value)
    assert stlc("solve", "m.stl", "--different", "2 dB", folder=tmp_path).returncode == 2
