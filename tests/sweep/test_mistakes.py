"""Sweeps over what a mission doesn't take, and over what has no plan."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.command import inside as stlc
from support.sweeps import MISSION


@pytest.mark.parametrize("values", ["1,2 kg", "2 kg,1 m/s", "1,2,-1", "1,x"])
def test_values_that_the_mission_does_not_take_are_told_first(tmp_path: Path, values: str) -> None:
    """Whichever of them comes first, and before the store is made."""
    (tmp_path / "m.stl").write_text(MISSION.replace("param v = 2", "param v = 2 m/s"))
    done = stlc("sweep", "m.stl", "-D", f"v={values}", folder=tmp_path)
    assert done.returncode == 1
    assert "error[E" in done.stderr
    assert not done.stdout
    assert not (tmp_path / "out").exists()


def test_a_point_with_mistakes_says_which(tmp_path: Path) -> None:
    """Each value is good beside the first of the other; together they leave no room."""
    text = MISSION.replace("box [0, 6] x [0, 4]", "box [0, 6 - v - near] x [0, 4]")
    text = text.replace("param near = 1 m", "param near = 1").replace("3 m + near", "0.5 m")
    (tmp_path / "m.stl").write_text(text)
    words = ("-D", "v=1,4", "-D", "near=0,4", "--no-store")
    done = stlc("sweep", "m.stl", *words, folder=tmp_path)
    assert done.returncode == 1
    assert "error: v=4, near=4: " in done.stderr
    assert "the box is empty along x" in done.stderr
    assert "mistakes" in done.stdout


def test_mistakes_in_costs_are_located_in_the_option(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(MISSION)
    done = stlc("sweep", "m.stl", "--pareto", "effort,link_cost(nochan)", folder=tmp_path)
    assert done.returncode == 1
    assert "--> --pareto:1:11" in done.stderr
    assert "1 | link_cost(nochan)" in done.stderr


def test_a_store_in_no_folder(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(MISSION)
    done = stlc("sweep", "m.stl", "--store", "nodir/z.sqlite", folder=tmp_path)
    assert done.returncode == 74
    assert "no folder nodir" in done.stderr
    assert not (tmp_path / "nodir").exists()


@pytest.mark.parametrize("values", ["0,9", "9,0"])
def test_what_can_never_hold_is_no_mistake(tmp_path: Path, values: str) -> None:
    """12 m is beyond the workspace, which the mission's check says already."""
    (tmp_path / "m.stl").write_text(MISSION)
    words = ("-D", f"near={values}", "--no-store")
    done = stlc("sweep", "m.stl", *words, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "infeasible" in done.stdout
    assert "optimal" in done.stdout
