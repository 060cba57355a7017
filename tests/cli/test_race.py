"""`stlc race`: proofs, points, interrupts, liars; here and on a cluster of real processes."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from support.cluster import cluster
from support.command import CONFLICT, LIMIT, MISSION, long_mission, start
from support.command import inside as stlc
from support.command import stlc as stlc_process
from support.events import wait_for, wait_for_file

from stlc.api import load
from stlc.plan import read_plan
from stlc.verify import verify

LONG = ("--progress", "ndjson", "-o", "p.json", "--json")


def _verified(folder: Path) -> float:
    """Objective of the plan on disk, which satisfies its mission."""
    plan = read_plan(folder / "p.json")
    assert verify(load(folder / "long.stl"), plan).ok
    assert plan.solve.objective is not None
    return plan.solve.objective


def test_the_first_proof_is_a_verified_plan(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(MISSION)
    words = ("--with", "highs:auto,scip:bigm", "-o", "p.json")
    done = stlc("race", "m.stl", *words, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "proven optimal; verified" in done.stdout
    assert stlc("verify", "m.stl", "p.json", folder=tmp_path).returncode == 0


def test_two_agree_that_there_is_no_plan(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(CONFLICT)
    done = stlc("race", "m.stl", "--with", "highs:auto", folder=tmp_path)
    assert done.returncode == 3
    assert "proven by HiGHS" in done.stderr
    assert "confirmed by SCIP" in done.stderr


def test_a_false_denial_is_refuted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    liar = tmp_path / "cbc"
    liar.write_text("#!/bin/sh\necho Version: 9.9\necho Integer infeasible\n")
    liar.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    (tmp_path / "m.stl").write_text(MISSION)
    words = ("--with", "external-cbc:auto", "-o", "p.json", "--json")
    done = stlc("race", "m.stl", *words, folder=tmp_path)
    assert done.returncode == 5, done.stderr
    assert "external-cbc (CBC 9.9) is refused: it claims infeasible, but SCIP" in done.stderr
    assert json.loads(done.stdout)["proven"] is False
    assert stlc("verify", "m.stl", "p.json", folder=tmp_path).returncode == 0


def _keeps_the_best_point(process: subprocess.Popen[str], seen: float, folder: Path) -> None:
    """One at least as good as the one that was seen when it was asked to end."""
    out, err = process.communicate(timeout=LIMIT)
    assert process.returncode == 0, err
    said = json.loads(out)
    assert said["proven"] is False
    assert said["objective"] == pytest.approx(_verified(folder))
    assert said["objective"] <= seen + 1e-9


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_keeps_the_best_point(number: signal.Signals, tmp_path: Path) -> None:
    words = ("race", long_mission(tmp_path), "--with", "highs:auto,scip:auto", *LONG)
    process = start(*words, folder=tmp_path)
    seen = float(str(wait_for(process, "solution")["objective"]))
    process.send_signal(number)
    _keeps_the_best_point(process, seen, tmp_path)


def test_a_time_limit_keeps_the_best_point(tmp_path: Path) -> None:
    long_mission(tmp_path)
    words = ("--with", "highs:auto", "--time-limit", "3", "-o", "p.json", "--json")
    done = stlc("race", "long.stl", *words, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["objective"] == pytest.approx(_verified(tmp_path))


def test_a_killed_race_leaves_what_it_saved(tmp_path: Path) -> None:
    words = ("race", long_mission(tmp_path), "--with", "highs:auto", *LONG)
    process = start(*words, folder=tmp_path)
    seen = float(str(wait_for(process, "solution")["objective"]))
    process.kill()
    process.communicate(timeout=LIMIT)
    assert _verified(tmp_path) <= seen + 1e-9


def test_an_interrupt_with_nothing_in_hand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the midst of a solver that never ends; no strategy has anything to say before it."""
    sleeper = tmp_path / "cplex"
    sleeper.write_text(f"#!/bin/sh\n: > {tmp_path}/asleep\nexec sleep {LIMIT:.0f}\n")
    sleeper.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    (tmp_path / "m.stl").write_text(MISSION)
    process = start("race", "m.stl", "--with", "external-cplex:auto", *LONG, folder=tmp_path)
    wait_for_file(process, tmp_path / "asleep")
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=LIMIT)
    assert process.returncode == 130, err
    assert "interrupted before a plan was found" in err
    assert "Traceback" not in err
    assert not (tmp_path / "p.json").exists()


def test_on_a_cluster(tmp_path: Path) -> None:
    """A proof by one of two workers; then an interrupt, whose points come back."""
    (tmp_path / "m.stl").write_text(MISSION)
    with cluster(tmp_path, workers=2) as (address, _):
        words = ("--with", "highs:auto,scip:auto", "--cluster", address, *LONG)
        done = stlc("race", "m.stl", *words, folder=tmp_path)
        assert done.returncode == 0, done.stderr
        said = json.loads(done.stdout)
        assert said["proven"] is True
        assert said["objective"] == pytest.approx(2 / 7, abs=1e-5)
        process = start("race", long_mission(tmp_path), *words, folder=tmp_path)
        seen = float(str(wait_for(process, "solution")["objective"]))
        process.send_signal(signal.SIGINT)
        _keeps_the_best_point(process, seen, tmp_path)


def test_an_unreachable_cluster(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stlc.solve.racing.cluster._TIMEOUT", 0.5)
    (tmp_path / "m.stl").write_text(MISSION)
    done = stlc("race", "m.stl", "--cluster", "tcp://127.0.0.1:9", folder=tmp_path)
    assert done.returncode == 5
    assert "cannot reach the cluster at tcp://127.0.0.1:9" in done.stderr


def test_racers_that_all_fail_are_no_limit_that_was_reached(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(MISSION)
    (tmp_path / "sitecustomize.py").write_text("import sys\nsys.modules['pyscipopt'] = None\n")
    env = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    done = stlc_process("race", "m.stl", "--with", "scip:auto", folder=tmp_path, env=env)
    assert done.returncode == 5, done.stderr
    assert "no racer found a plan" in done.stderr
