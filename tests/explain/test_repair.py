"""Changes that end a conflict: smallest, ready to apply, each with a verified plan."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
from support.command import CONFLICT
from support.command import inside as stlc

from stlc.api import changes as api_changes
from stlc.api import loads, solve
from stlc.errors import InfeasibleError
from stlc.explain.conflict import Conflict, explain
from stlc.explain.edits import Change, patched
from stlc.explain.repair import Repairer
from stlc.solve.deadline import Deadline

LATE = CONFLICT.replace("[7, 8] x", "[9, 10] x").replace("require visit", "# require visit")
LINK = """workspace box [0, 20] x [0, 20]
agent b : single_integrator { start (2, 10); control |u| <= 1 }
station base at (10, 10)
channel radio { path_loss L0 = -40 dBm, n = 3; fading 4 dB^2; partition 4 x 4 }
param level = -62 dBm
require link: always[2, 5] rssi(b, base) >= level
require sure: eventually[0, 8] P(rssi(b, base) >= -55 dBm) >= 0.9
"""


@cache
def changes(text: str) -> tuple[Change, ...]:
    mission = loads(text)
    found = explain(mission)
    assert isinstance(found, Conflict)
    return Repairer(loads, "highs", Deadline.after(60.0)).changes(mission, found)


def is_infeasible(text: str) -> bool:
    try:
        solve(replace(loads(text), objective=()))
    except InfeasibleError:
        return True
    return False


@pytest.mark.parametrize("text", [CONFLICT, LATE, LINK, LINK.replace("-62", "-69")])
def test_every_change_gives_a_verified_plan(text: str) -> None:
    found = changes(text)
    assert found
    for change in found:
        assert patched(text, change.replacements) == change.text
        assert solve(loads(change.text)).report.ok
    assert [c.cost for c in found] == sorted(c.cost for c in found)


def test_a_deadline_moves_to_the_first_step_with_a_plan() -> None:
    moved = [c for c in changes(LATE) if c.kinds == ("deadline",)]
    assert [(r.span.text, r.new) for r in moved[0].replacements] == [("3", "4")]
    assert moved[0].words == ("deadline of other 3 -> 4 (+1 step), line 12",)


def test_a_smaller_change_is_none() -> None:
    for change in changes(LATE):
        (one,) = change.replacements
        old, new = float(one.span.text), float(one.new)
        less = format(old + (new - old) * 0.75, ".3g")
        if "deadline" not in change.kinds and less != one.new:
            assert is_infeasible(patched(LATE, [replace(one, new=less)]))


def test_a_parameter_is_changed_where_it_is_declared() -> None:
    found = changes(LINK)
    levels = [r for c in found for r in c.replacements if r.span.text == "-62"]
    assert levels
    assert levels[0].span.line == 5
    assert "(-2.2 dB)" in str(found[0])


def test_parameters_of_bounds_and_places_are_changed_where_they_are_declared() -> None:
    text = """horizon 6
param fast = 1 m/s
param near = 9
workspace box [0, 12] x [0, 10]
agent a : single_integrator { start (1, 1); speed <= fast }
region goal = box [near, 12] x [0, 3]
require go: eventually[0, 6] a in goal
"""
    said = {words for c in changes(text) for words in c.words}
    assert "deadline of go 6 -> 9 (+3 steps), line 7" in said
    found = {words.partition(" ->")[0] for words in said}
    assert {"parameter fast 1", "parameter near 9"} <= found
    assert "start px of a 1 -> 3.2 (+2.2 m), line 5" in said


NETWORK = """horizon 2
workspace box [0, 10] x [0, 10]
agent a : single_integrator { start (1, 1); control |u| <= 0.01 }
agent b : single_integrator { start (8, 1); control |u| <= 0.01 }
station base at (4, 1)
channel radio { path_loss L0 = -40 dBm, n = 2; partition 10 x 5 }
"""


@pytest.mark.parametrize(
    ("formula", "number"),
    [
        ("route(a, base, hops <= 2, rssi >= -40 dBm)", "threshold of n -40"),
        ("connected([agents, base], rssi >= -40 dBm)", "threshold of n -40"),
        ("route(a, b, [base], hops <= 1, rssi >= -55 dBm)", "count of n 1 -> 2 (+1)"),
        ("always count(r in agents: r.x >= 4 m) >= 2", "count of n 2 -> 1 (-1)"),
        ("always count(r in agents: r.x >= 4 m) >= 2", "threshold of n 4"),
    ],
)
def test_numbers_within_networks_are_changed(formula: str, number: str) -> None:
    said = {words for c in changes(f"{NETWORK}require n: {formula}\n") for words in c.words}
    assert any(words.startswith(number) for words in said), said
    assert not any("dBm)" in words for words in said)  # levels differ by decibels


def test_a_disturbance_is_made_smaller() -> None:
    text = """horizon 6
workspace box [0, 10] x [0, 10]
agent a : single_integrator { start (1, 1); control |u| <= 2; disturbance |w| <= 1.5 }
region goal = box [6, 8] x [0, 2]
require go: eventually[0, 6] a in goal
"""
    said = {words for c in changes(text) for words in c.words}
    assert any(words.startswith("disturbance of a 1.5 -> ") for words in said)


def test_edges_and_ends_of_windows_are_told_apart() -> None:
    said = {words.partition(" ->")[0] for c in changes(THREE) for words in c.words}
    assert not any(words.startswith("deadline of close") for words in said)
    said = {words.partition(" ->")[0] for c in changes(EARLY) for words in c.words}
    assert "begin of up 1" in said
    assert "lower y of region goal 4" in said


EARLY = """horizon 6
workspace box [0, 12] x [0, 10]
agent a : single_integrator { start (1, 1); control |u| <= 1 }
region goal = box [0, 4] x [4, 6]
require up: always[1, 6] a in goal
"""


def test_a_coarse_partition_is_made_finer() -> None:
    kinds = {k for c in changes(LINK.replace("-62", "-69")) for k in c.kinds}
    assert "partition" in kinds


def test_several_conflicts_are_ended_by_one_change_of_several_numbers() -> None:
    several = CONFLICT.replace("[7, 8] x", "[9, 10] x")
    lone, *found = changes(several)
    assert lone.words == ("deadline of other 3 -> 8 (+5 steps), line 12",)  # visits left first
    assert found
    assert all(len(c.words) == 2 for c in found)


THREE = """horizon 8
workspace box [0, 12] x [0, 10]
agent a : single_integrator { start (1, 1); control |u| <= 1 }
agent b : single_integrator { start (1, 8); control |u| <= 1 }
require far: eventually[0, 4] a.x >= 6 m
require low: always b.y <= 7.5
require close: always[6, 6] distance(a, b) <= 3 m
require apart: always[6, 6] separation(a, b) >= 3.5 m
"""


def test_every_conflict_gets_its_step() -> None:
    found = changes(THREE)
    assert len(found) == 5
    lines = [{r.span.line for r in c.replacements} for c in found]
    assert all(6 in at or 4 in at for at in lines)  # low, or where b starts
    assert all(at & {7, 8} for at in lines)
    for change in found:
        assert solve(loads(change.text)).report.ok
        for step in change.steps:  # none is spare
            left = [r for s in change.steps if s is not step for r in s.replacements]
            assert is_infeasible(patched(THREE, left))
    assert len({c.words for c in found}) == 5


def test_one_number_may_end_several_conflicts() -> None:
    """A goal that two deadlines come too early for; the goal, or the speed, will do alone."""
    text = THREE[: THREE.index("require low")] + "require soon: eventually[0, 3] a.x + a.y >= 9 m\n"
    found = changes(text)
    assert min(len(c.steps) for c in found) == 1
    assert any(len(c.steps) > 1 for c in found)


def test_a_change_counts_from_the_number_in_the_file() -> None:
    for change in changes(THREE):
        for step in change.steps:
            own = step.replacements[0]
            moved = abs(float(own.new) - float(own.span.text))
            assert step.cost == pytest.approx(step.knob.cost(0.0, moved))


def test_a_copy_is_written_and_no_input(tmp_path: Path) -> None:
    (tmp_path / "c.stl").write_text(LATE)
    done = stlc("explain", "c.stl", "--apply", "d.stl", folder=tmp_path)
    assert done.returncode == 3
    assert "1. " in done.stdout
    assert stlc("solve", "d.stl", "--progress", "none", folder=tmp_path).returncode == 0
    again = stlc("explain", "c.stl", "--apply", "c.stl", folder=tmp_path)
    assert again.returncode == 2
    assert (tmp_path / "c.stl").read_text() == LATE
    assert "wrote d.stl: change 1, " in done.stdout
    beyond = stlc("explain", "c.stl", "--apply", "e.stl", "--pick", "99", folder=tmp_path)
    assert beyond.returncode == 2
    stdout = stlc("explain", "c.stl", "--apply", "-", folder=tmp_path)
    assert stdout.returncode == 2
    assert not (tmp_path / "-").exists()
    assert not (tmp_path / "e.stl").exists()


def test_from_python(tmp_path: Path) -> None:
    (tmp_path / "c.stl").write_text(LATE)
    assert [c.text for c in api_changes(tmp_path / "c.stl")] == [c.text for c in changes(LATE)]
    (tmp_path / "good.stl").write_text(changes(LATE)[0].text)
    assert api_changes(tmp_path / "good.stl") == ()


def test_a_change_that_is_not_offered_cannot_be_picked(tmp_path: Path) -> None:
    """Fewer were found: a mistake of who asks, told with their number."""
    (tmp_path / "c.stl").write_text(ONE)
    few = stlc("explain", "c.stl", "--apply", "e.stl", "--pick", "5", folder=tmp_path)
    assert few.returncode == 2
    assert not (tmp_path / "e.stl").exists()


ONE = """horizon 2
workspace box [0, 10] x [0, 10]
agent a : single_integrator { start (1, 1); control |u| <= 1 }
require odd: always a.x >= 3 and a.x <= 2
"""


def test_no_time_is_blamed_where_all_was_tried(tmp_path: Path) -> None:
    (tmp_path / "c.stl").write_text(NONE)
    done = stlc("explain", "c.stl", "--fix", folder=tmp_path)
    assert done.returncode == 3
    assert done.stdout.startswith("no single number of those named here gives a plan")


NONE = """horizon 2
workspace box [0, 10] x [0, 10]
agent a : single_integrator { start (1, 1); control |u| <= 1 }
agent b : single_integrator { start (1, 1); control |u| <= 1 }
require odd: always (a.x <= b.x - 1 and b.x <= a.x - 1)
"""


def test_what_was_set_from_outside_is_said_to_be_kept(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(LINK)
    said = stlc("explain", "m.stl", "--fix", "-D", "level=-61", folder=tmp_path).stdout
    assert said.endswith("  `level` is set by -D and kept\n")
    assert "parameter level" not in said
