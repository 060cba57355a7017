"""`stlc solve` as a person calls it: exit statuses, messages, files, and nothing half-written."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from support.command import CONFLICT, MISSION, long_mission
from support.command import inside as stlc

from stlc.cli.common import plain
from stlc.plan import read_plan


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "m.stl").write_text(MISSION)
    return tmp_path


def test_a_plan_in_every_form(folder: Path) -> None:
    done = stlc("solve", "m.stl", "-o", "p.json", "--csv", "p.csv", "--json", folder=folder)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said["status"] == "optimal"
    assert said["verified"] is True
    assert said["objective"] == pytest.approx(2 / 7)
    assert set(said["robustness"]) == {"visit", "clear"}
    assert set(said["seconds"]) == {"compile", "solve", "verify"}
    assert read_plan(folder / "p.json").solve.objective == said["objective"]
    assert (folder / "p.csv").read_text().startswith("t,time,agent,")
    again = stlc("verify", "m.stl", "p.json", folder=folder)
    assert again.returncode == 0, again.stdout


def test_infeasible_names_the_clauses(tmp_path: Path) -> None:
    (tmp_path / "c.stl").write_text(CONFLICT)
    done = stlc("solve", "c.stl", "-o", "p.json", "--progress", "none", folder=tmp_path)
    assert done.returncode == 3
    assert "confirmed by" in done.stderr
    assert "c.stl:11" in done.stderr
    assert "c.stl:12" in done.stderr
    assert not (tmp_path / "p.json").exists()
    short = stlc("solve", "c.stl", "--no-explain", "--progress", "none", folder=tmp_path)
    assert short.returncode == 3
    assert "c.stl:11" not in short.stderr
    asked = stlc("explain", "c.stl", folder=tmp_path)
    assert asked.returncode == 3
    assert "these 2 clauses cannot be satisfied together" in asked.stderr


def test_interval_proofs_are_explained_too(tmp_path: Path) -> None:
    (tmp_path / "c.stl").write_text(CONFLICT.replace("[7, 8] x", "[9, 10] x"))
    done = stlc("solve", "c.stl", "--progress", "none", folder=tmp_path)
    assert done.returncode == 3
    assert "c.stl:12" in done.stderr
    assert done.stderr.count("no value of vx is left") == 1  # not told again by the explanation


def test_a_mission_that_motion_alone_rules_out(tmp_path: Path) -> None:
    """Too fast to stay within the workspace, whatever is required."""
    (tmp_path / "c.stl").write_text(
        "horizon 3\nworkspace box [0, 6] x [0, 6]\n"
        "agent a : double_integrator { start (5, 1, 2, 0); control |u| <= 1 }\n"
        "require go: eventually a.x >= 1 m\nminimize effort\n"
    )
    done = stlc("solve", "c.stl", "--progress", "none", folder=tmp_path)
    assert done.returncode == 3
    assert "no requirement is to blame" in done.stderr
    assert done.stderr.count("no value of px is left") == 1
    asked = stlc("explain", "c.stl", folder=tmp_path)
    assert asked.returncode == 3
    assert "error[E0808]" in asked.stderr
    assert "--> c.stl:3:51" in asked.stderr  # at the bound of its control
    assert asked.stderr.count("no value of px is left") == 1


def test_an_agent_that_cannot_keep_its_bounds_is_shown_at_them(tmp_path: Path) -> None:
    """Another agent comes before it, which can keep its own."""
    (tmp_path / "c.stl").write_text(
        "horizon 8\nworkspace box [0, 10] x [0, 10]\n"
        "agent a : single_integrator { start (1, 1); speed <= 1 }\n"
        "agent c : double_integrator { start (5, 5, 2, 0); control |u| <= 1; speed <= 2; "
        "vx >= 1.5 }\nrequire q: always c.y >= 1\n"
    )
    done = stlc("explain", "c.stl", folder=tmp_path)
    assert done.returncode == 3
    assert "`c` has no run at all" in done.stderr
    assert "--> c.stl:4:69" in done.stderr
    assert "with this: `vx >= 1.5` of c" in done.stderr
    assert "cause: agent 'c' cannot keep its bounds" in done.stderr


WRONG = {
    "a missing file": (("solve", "none.stl"), 2, "none.stl"),
    "an unknown backend": (("solve", "m.stl", "--backend", "higs"), 2, "did you mean 'highs'"),
    "an unknown encoding": (("solve", "m.stl", "--encoding", "best"), 2, "known: auto"),
    "an unknown pass": (("solve", "m.stl", "--disable", "magic"), 2, "no pass 'magic'"),
    "a solver that is not there": (
        ("solve", "m.stl", "--backend", "external-cplex"), 5, "'cplex' is not on PATH",
    ),
    "a start that is not there": (("solve", "m.stl", "--start", "s.json"), 2, "s.json"),
    "a start that is no plan": (("solve", "m.stl", "--start", "m.stl"), 2, "not a plan"),
    "a shift without a start": (("solve", "m.stl", "--shift", "1"), 2, "needs --start"),
    "an option without a value": (("solve", "m.stl", "--option", "x"), 2, "NAME=VALUE"),
    "an option HiGHS does not know": (("solve", "m.stl", "--option", "x=1"), 5, "option x"),
    "a folder that is not there": (("solve", "m.stl", "-o", "no/p.json"), 74, "does not exist"),
    "a full disk": (("solve", "m.stl", "-o", "/dev/full"), 74, "the disk is full"),
    "a full disk for waypoints": (("solve", "m.stl", "--csv", "/dev/full"), 74, "disk is full"),
    "a full disk for a model": (("compile", "m.stl", "-o", "full.mps"), 74, "the disk is full"),
    "a full disk for a picture": (("plot", "m.stl", "p.json", "-o", "f.png"), 74, "disk is full"),
    "a model of no kind": (("compile", "m.stl", "-o", "m.txt"), 2, ".mps"),
    "a plan that is none": (("verify", "m.stl", "m.stl"), 2, "m.stl:1:1: not a plan"),
    "a solution that is none": (("read-solution", "m.stl", "m.stl"), 2, "solution formats known"),
    "a racer nobody knows": (("race", "m.stl", "--with", "nobody:auto"), 2, "no backend 'nobody'"),
    "no racer": (("race", "m.stl", "--with", ","), 2, "at least one racer"),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_what_goes_wrong_is_said(what: str, folder: Path) -> None:
    words, status, message = WRONG[what]
    if "p.json" in words:
        assert stlc("solve", "m.stl", "-o", "p.json", folder=folder).returncode == 0
    for name in ("full.mps", "f.png"):
        (folder / name).symlink_to("/dev/full")
    before = {p.name for p in folder.iterdir()}
    done = stlc(*words, folder=folder)
    assert done.returncode == status, done.stderr
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    left = {p.name for p in folder.iterdir()} - before
    assert left <= {"full.mps.names.json"}


def test_another_missions_plan_is_refused_with_reasons(folder: Path) -> None:
    (folder / "c.stl").write_text(CONFLICT.replace("horizon 6", "horizon 4"))
    assert stlc("solve", "m.stl", "-o", "p.json", folder=folder).returncode == 0
    done = stlc("verify", "c.stl", "p.json", folder=folder)
    assert done.returncode == 6
    assert "violat" in done.stdout
    start = stlc("solve", "c.stl", "--start", "p.json", "--no-explain", folder=folder)
    assert start.returncode == 3
    assert "the start plan is no plan for this mission" in start.stderr


CORNER = """workspace box [0, 5] x [0, 5]
dynamics cart = single_integrator
agent a : cart { start (0, 0); control |u| <= 5 }
region far = box [4, 5] x [4, 5]
obstacle rock = box [2, 3] x [2, 3]
require go: eventually[0, 1] a in far
require clear: always a outside rock
"""


def test_a_cut_between_samples_is_told(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(CORNER)
    done = stlc("solve", "m.stl", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert re.search(r"note: a cuts 0\.\d+ m into the body of rock at 0\.\d+ s", done.stdout)


def test_a_limit_with_a_plan_in_hand_is_good(tmp_path: Path) -> None:
    """It was given: on a busy machine no limit is long enough for a plan, short enough for none."""
    words = ("solve", long_mission(tmp_path, 12), "--strategy", "milp", "--json")
    assert stlc(*words, "--gap", 1e6, "-o", "s.json", folder=tmp_path).returncode == 0
    done = stlc(*words, "--start", "s.json", "-o", "p.json", "--time-limit", 1, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said["status"] == "feasible"
    assert said["gap"] is None or said["gap"] > 0
    assert said["verified"] is True
    assert read_plan(tmp_path / "p.json").solve.status == "feasible"


def test_a_limit_with_nothing_in_hand(tmp_path: Path) -> None:
    done = stlc("solve", long_mission(tmp_path), "--time-limit", 0.01, folder=tmp_path)
    assert done.returncode == 4
    assert "the model was not made within the time limit" in done.stderr


@pytest.mark.parametrize("backend", ["highs", "mip", "pulp", "scip", "gurobi"])
def test_starts(backend: str, folder: Path) -> None:
    """A start is in hand, verified and saved before the solver says anything."""
    assert stlc("solve", "m.stl", "-o", "p.json", folder=folder).returncode == 0
    words = ("solve", "m.stl", "--start", "p.json", "--backend", backend, "--strategy", "milp")
    done = stlc(*words, "-o", "q.json", "--json", "--progress", "ndjson", folder=folder)
    assert done.returncode == 0, done.stderr
    events = [json.loads(line) for line in done.stderr.splitlines()]
    first = next(e for e in events if e["event"] in ("solution", "progress"))
    assert first["event"] == "solution"
    assert first["objective"] == pytest.approx(2 / 7, abs=1e-6)
    assert "start" not in json.loads(done.stdout)["ignored"]


def test_a_shifted_start(folder: Path) -> None:
    """One step later the plan stands where it ended; in a mission that begins there, it is kept."""
    assert stlc("solve", "m.stl", "-o", "p.json", folder=folder).returncode == 0
    later = read_plan(folder / "p.json").runs["a"].states[1].tolist()
    text = MISSION.replace("start (1, 1)", "start ({}, {}, {}, {})".format(*later))
    (folder / "later.stl").write_text(text)
    words = ("solve", "later.stl", "--start", "p.json", "--shift", "1", "-o", "q.json")
    words += ("--progress", "ndjson")
    done = stlc(*words, folder=folder)
    assert done.returncode == 0, done.stderr
    assert "no plan for this mission" not in done.stderr
    assert '"solution"' in done.stderr


def test_confirmation_is_told(folder: Path) -> None:
    done = stlc("solve", "m.stl", "--confirm", "--progress", "none", folder=folder)
    assert done.returncode == 0, done.stderr
    assert "second solver: SCIP" in done.stdout
    assert "agrees" in done.stdout


def test_the_solvers_own_options_arrive(folder: Path) -> None:
    none = ("--option", "mip_max_leaves=0", "--option", "presolve=off")
    done = stlc("solve", "m.stl", "--strategy", "milp", *none, folder=folder)
    assert done.returncode in (0, 4)
    wrong = stlc("solve", "m.stl", "--option", "presolve=maybe", folder=folder)
    assert wrong.returncode == 5
    assert "presolve" in wrong.stderr


def test_rounding_is_not_shown() -> None:
    assert plain(-1.7e-16) == "0"
    assert plain(-1.7e-8) == "-1.7e-08"
    assert plain(None) == "-"
