"""`partition auto`: a grid to begin with, finer ones where whole cells rule a plan out."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stlc.api import loads, solve, verify
from stlc.errors import InfeasibleError, MissionError
from stlc.grids import FIRST, MOST, finer, first_grid, on_grids, shapes
from stlc.plan import read_plan
from stlc.solve.events import Event, StatusEvent
from stlc.solve.outcome import SolveSettings
from tests.support.command import stlc

WORLD = """step 1 s
horizon 6
workspace box [0, 40] x [0, 20]
agent r : single_integrator { start (38, 18); control |u| <= 12 }
station base at (1, 1)
channel c { path_loss L0 = -40 dBm, n = 3; shadowing 4 dB^2, length 5 m; PARTITION }
require link: eventually[1, 6] rssi(r, base) >= LEVEL dBm
minimize effort
"""


def world(partition: str, level: float = -55.0) -> str:
    return WORLD.replace("; PARTITION", partition).replace("LEVEL", str(level))


@pytest.mark.parametrize(
    ("length", "expected"), [(None, (8, 4)), (0.1, (8, 4)), (8.0, (5, 3)), (100.0, (4, 2))]
)
def test_cells_are_about_as_wide_as_shadowing_is_long(
    length: float | None, expected: tuple[int, int]
) -> None:
    assert first_grid([(0, 40), (0, 20)], length).shape == expected


@pytest.mark.parametrize("partition", ["", "; partition auto"])
def test_without_a_partition_and_with_auto(partition: str) -> None:
    mission = loads(world(partition))
    assert shapes(mission) == {"c": (8, 4)}


def test_a_given_partition_stays() -> None:
    mission = loads(world("; partition 3 x 3"))
    assert shapes(mission) == {}
    assert finer(mission) is None
    with pytest.raises(InfeasibleError):
        solve(mission)


def test_solve_refines_until_cells_do_and_the_plan_says_on_which(tmp_path: Path) -> None:
    mission, told = loads(world("")), list[Event]()
    outcome = solve(mission, SolveSettings(save_to=tmp_path / "plan.json"), told.append)
    grid = outcome.plan.grids["c"]
    assert grid[0] > FIRST
    refined = [e.message for e in told if isinstance(e, StatusEvent) and e.stage == "refine"]
    assert len(refined) == np.log2(grid[0] / FIRST)
    assert refined[-1].endswith(f"`c` on {grid[0]} x {grid[1]} cells")
    again = read_plan(tmp_path / "plan.json")
    assert again.grids == outcome.plan.grids
    report = verify(mission, again)
    assert report.ok
    assert any(f"`c` on {grid[0]} x {grid[1]} cells" in note for note in report.notes)
    coarse = verify(mission, replace(again, grids={}))
    assert not coarse.ok, "on the first grid the same plan has no link"


def test_what_is_out_of_reach_at_points_too_is_not_refined() -> None:
    told = list[Event]()
    with pytest.raises(InfeasibleError):
        solve(loads(world("", -20.0)), None, told.append)
    assert not [e for e in told if isinstance(e, StatusEvent) and e.stage == "refine"]


def test_refinement_ends() -> None:
    mission = loads(world(""))
    seen = [shapes(mission)["c"]]
    while (mission_ := finer(mission)) is not None:
        mission = mission_
        seen.append(shapes(mission)["c"])
    assert seen == [(8, 4), (16, 8), (32, 16)]
    assert max(seen[-1]) <= MOST


def test_other_grids_are_taken_for_channels_that_choose_only() -> None:
    mission = loads(world("; partition 3 x 3"))
    assert on_grids(mission, {"c": (9, 9)}).channels["c"].partition.shape == (3, 3)


def test_a_table_needs_its_own_partition(tmp_path: Path) -> None:
    text = world("").replace("path_loss L0 = -40 dBm, n = 3; shadowing 4 dB^2, length 5 m", "TAB")
    text = text.replace("rssi(r, base) >= -55.0 dBm", "link_cost(c, (r, base)) <= 3")
    np.savetxt(tmp_path / "t.csv", np.zeros(4), delimiter=",")
    for given in ('table "t.csv"', 'table "t.csv"; partition auto'):
        with pytest.raises(MissionError) as found:
            loads(text.replace("TAB", given), folder=tmp_path)
        assert found.value.diagnostics[0].code in ("E0601", "E0208")


def test_commands_tell_and_agree(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(world(""))
    done = stlc("solve", "m.stl", "-o", "p.json", "--json", "--progress", "none", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    notes = json.loads(done.stdout)["notes"]
    assert any("chosen by `partition auto`" in note for note in notes)
    assert stlc("verify", "m.stl", "p.json", folder=tmp_path).returncode == 0
    damaged = json.loads((tmp_path / "p.json").read_text()) | {"grids": {"c": [1e9, 4]}}
    (tmp_path / "p.json").write_text(json.dumps(damaged))
    told = stlc("verify", "m.stl", "p.json", folder=tmp_path)
    assert told.returncode == 2
    assert "whole numbers of cells" in told.stderr
