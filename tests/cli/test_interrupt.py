"""Ctrl-C, SIGTERM and kill -9 while a solver works: what was verified is kept, and said."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from support.command import LIMIT, long_mission, start, stlc
from support.events import wait_for

from stlc.api import load
from stlc.plan import read_plan
from stlc.verify import verify


def _solve(folder: Path, *words: object, steps: int = 8) -> subprocess.Popen[str]:
    return start(
        "solve", long_mission(folder, steps), "--strategy", "milp", "-o", "p.json",
        "--progress", "ndjson", *words, folder=folder,
    )  # fmt: skip


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_reports_the_plan_and_its_gap(number: signal.Signals, tmp_path: Path) -> None:
    process = _solve(tmp_path, "--json")
    seen = wait_for(process, "solution")
    process.send_signal(number)
    out, err = process.communicate(timeout=LIMIT)
    assert process.returncode == 0, err
    said = json.loads(out)
    assert said["status"] == "feasible"
    assert said["verified"] is True
    assert said["objective"] <= seen["objective"] + 1e-6
    plan = read_plan(tmp_path / "p.json")
    assert plan.solve.objective == said["objective"]
    assert plan.solve.gap == said["gap"]
    assert '"interrupted"' in err


@pytest.mark.parametrize("backend", ["mip", "pulp", "cvxpy", "scipy"])
def test_deaf_solvers_are_left_behind(backend: str, tmp_path: Path) -> None:
    process = _solve(tmp_path, "--backend", backend, steps=12)
    note = wait_for(process, "diagnostic")
    assert "hands over no plan before it ends" in str(note["message"])
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=LIMIT)
    assert process.returncode == 130, err
    assert "interrupted before a plan was found" in err


def test_kill_loses_no_saved_plan(tmp_path: Path) -> None:
    """Whatever was announced as saved is there, whole, and satisfies the mission."""
    for wanted in (1, 2):
        process = _solve(tmp_path)
        best = min(float(str(wait_for(process, "solution")["objective"])) for _ in range(wanted))
        os.kill(process.pid, signal.SIGKILL)
        process.communicate(timeout=LIMIT)
        plan = read_plan(tmp_path / "p.json")
        assert plan.solve.objective is not None
        assert plan.solve.objective <= best + 1e-9
        assert verify(load(tmp_path / "long.stl"), plan).ok


def test_events_follow_their_schema(tmp_path: Path) -> None:
    from importlib.resources import files

    from jsonschema import Draft202012Validator

    schema = json.loads((files("stlc.solve") / "events.schema.json").read_text())
    Draft202012Validator.check_schema(schema)
    judge = Draft202012Validator(schema)
    words = ("solve", long_mission(tmp_path, 5), "--strategy", "milp", "-o", "p.json")
    done = stlc(*words, "--threads", 1, "--progress", "ndjson", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    events = [json.loads(line) for line in done.stderr.splitlines() if line.startswith("{")]
    for event in events:
        judge.validate(event)
    assert {e["event"] for e in events} == {"status", "statistics", "progress", "solution"}
    assert not judge.is_valid({"event": "solution", "seconds": 1.0})


def test_one_live_line_at_a_terminal(tmp_path: Path) -> None:
    import pty

    own, theirs = pty.openpty()
    words = ("solve", long_mission(tmp_path, 5), "--strategy", "milp")
    process = start(*words, folder=tmp_path, stderr=theirs)
    os.close(theirs)
    text = b""
    while True:
        try:
            chunk = os.read(own, 4096)
        except OSError:  # the other end is closed
            break
        if not chunk:
            break
        text += chunk
    process.communicate(timeout=LIMIT)
    os.close(own)
    assert process.returncode == 0, text
    live = [part for part in text.decode().split("\r\x1b[K") if "incumbent" in part]
    assert len(live) > 1
    assert not any("\n" in part for part in live)
    assert b'{"event"' not in text


def test_interrupted_while_it_starts(tmp_path: Path) -> None:
    """Before anything of stlc's heeds signals: an import is cut short, as by Ctrl-C."""
    code = (
        "import sys\n"
        "class Cut:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name == 'stlc.errors': raise KeyboardInterrupt\n"
        "from stlc.cli import main\n"
        "sys.meta_path.insert(0, Cut())\n"
        "main()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (130, "")
