"""With `--json` there is one JSON object on standard output, however the command ends."""

from __future__ import annotations

import json
import signal
from pathlib import Path
from typing import Any

import pytest
from support.command import CONFLICT, LIMIT, MISSION, long_mission, start
from support.command import inside as stlc
from support.events import wait_for

WRONG = "require a: always r1.x <= 3 m\n"
SPEC = "signal v\nrequire low: always[0, 1] v <= 5\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    texts = {"m.stl": MISSION, "conflict.stl": CONFLICT, "wrong.stl": WRONG, "spec.stl": SPEC,
             "short.csv": "time,v\n0,1\n", "high.csv": "time,v\n0,9\n1,9\n", "s.csv": "a,b\n1,2\n",
             "p.json": "{}", "bad.db": "SQLite format 3 is not all"}  # fmt: skip
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def _object(text: str) -> dict[str, Any]:
    def refuse(word: str) -> float:
        raise ValueError(word)

    found = json.loads(text, parse_constant=refuse)
    assert isinstance(found, dict)
    return found


ENDS = [
    (("solve", "conflict.stl"), 3, "infeasible"),
    (("solve", "conflict.stl", "--no-explain"), 3, "infeasible"),
    (("solve", "wrong.stl"), 1, "mistakes"),
    (("solve", "gone.stl"), 2, "usage"),
    (("solve", "m.stl", "--gap", "much"), 2, "usage"),
    (("solve", "m.stl", "-o", "m.stl"), 2, "usage"),
    (("solve", "m.stl", "-o", "gone/p.json"), 74, "not_written"),
    (("solve", "m.stl", "--backend", "external", "--option", "command=/bin/false {mps} {sol}"), 5,
     "solver_failed"),
    (("race", "conflict.stl", "--with", "highs:auto"), 3, "infeasible"),
    (("verify", "m.stl", "p.json"), 2, "usage"),
    (("compile", "wrong.stl"), 1, "mistakes"),
    (("fit", "s.csv"), 1, "mistakes"),
    (("monitor", "spec.stl", "gone.csv"), 2, "usage"),
]  # fmt: skip


@pytest.mark.parametrize(("words", "status", "word"), ENDS, ids=lambda v: str(v)[:40])
def test_ends_without_a_result(
    words: tuple[str, ...], status: int, word: str, folder: Path
) -> None:
    more = ("--progress", "none") if words[0] in ("solve", "race") else ()
    done = stlc(*words, "--json", *more, folder=folder)
    assert done.returncode == status, done.stderr
    said = _object(done.stdout)
    assert said["status"] == word
    assert said["exit_status"] == status
    assert said["message"]
    assert done.stderr


def test_what_an_end_knows(folder: Path) -> None:
    quiet = ("--json", "--progress", "none")
    said = _object(stlc("solve", "conflict.stl", *quiet, folder=folder).stdout)
    assert said["conflict"] == ["visit", "other"]
    said = _object(stlc("solve", "wrong.stl", *quiet, folder=folder).stdout)
    assert said["diagnostics"][0]["code"] == "E0201"
    assert said["diagnostics"][0]["span"]["start"]["line"] == 1


def test_a_limit_without_a_plan(tmp_path: Path) -> None:
    words = ("--strategy", "milp", "--time-limit", "0", "--json", "--progress", "none")
    done = stlc("solve", long_mission(tmp_path, 12), *words, folder=tmp_path)
    assert done.returncode == 4, done.stderr
    said = _object(done.stdout)
    assert (said["status"], said["exit_status"]) == ("no_plan", 4)
    assert "bound" in said


def test_a_result(folder: Path) -> None:
    quiet = ("--json", "--progress", "none")
    said = _object(stlc("solve", "m.stl", "-o", "plan.json", *quiet, folder=folder).stdout)
    assert said["certified"] is True
    assert said["verified"] is True
    assert said["seconds"].keys() == {"compile", "solve", "verify"}
    words = ("compile", "m.stl", "--print-after", "all", "--json")
    _object(stlc(*words, folder=folder).stdout)
    for trace, status in (("short.csv", 1), ("high.csv", 6)):
        done = stlc("monitor", "spec.stl", trace, "--json", folder=folder)
        assert done.returncode == status
        _object(done.stdout)


def test_a_plan_kept_at_a_limit_was_verified(tmp_path: Path) -> None:
    words = ("--strategy", "milp", "-o", "p.json", "--json", "--progress", "ndjson")
    process = start("solve", long_mission(tmp_path, 12), *words, folder=tmp_path)
    wait_for(process, "solution")
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=LIMIT)
    assert process.returncode == 0, err
    said = _object(out)
    assert said["verified"] is True
    assert said["certified"] is True
    assert said["seconds"]["verify"] > 0


def test_interrupted_without_a_plan(tmp_path: Path) -> None:
    words = ("--backend", "scipy", "--json", "--progress", "ndjson")
    process = start("solve", long_mission(tmp_path, 12), *words, folder=tmp_path)
    wait_for(process, "statistics")
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=LIMIT)
    assert process.returncode == 130, err
    assert _object(out)["status"] == "interrupted"


def test_a_plan_keeps_its_parameters(tmp_path: Path) -> None:
    """`verify` and `plot` judge it by them, and say where `-D` differs."""
    text = MISSION.replace("[2, 3] x [1, 2]", "[goal, goal + 1] x [1, 2]")
    (tmp_path / "m.stl").write_text("param goal = 2 m\n" + text)
    words = ("solve", "m.stl", "-D", "goal=2.5 m", "-o", "p.json", "--progress", "none")
    assert stlc(*words, folder=tmp_path).returncode == 0
    done = stlc("verify", "m.stl", "p.json", folder=tmp_path)
    assert done.returncode == 0, done.stdout
    assert "note" not in done.stderr
    done = stlc("verify", "m.stl", "p.json", "-D", "goal=4", folder=tmp_path)
    assert done.returncode == 6
    assert "the plan was made with -D goal=2.5 m; here it is 4" in done.stderr
    assert stlc("plot", "m.stl", "p.json", "-o", "p.svg", folder=tmp_path).returncode == 0
