"""Races: the first certified proof wins; liars, crashes and sleepers lose."""

import os
from pathlib import Path

import pytest
from support.events import comes_true

from stlc.backends.base import Progress, SolveOptions
from stlc.backends.conformance_models import knapsack
from stlc.errors import SolverError, UsageError
from stlc.milp.builder import ModelBuilder
from stlc.solve.racing.race import Finish, Racer, race

HARD = knapsack(200, 30)


def test_the_first_proof_wins_and_the_rest_are_ended() -> None:
    easy = Racer("highs:easy", "highs", knapsack())
    slow = Racer("scip:hard", "scip", HARD, SolveOptions(time_limit=120.0))
    result = race([slow, easy])
    assert result.winner is not None
    assert result.winner.name == "highs:easy"
    assert [lap.finish for lap in result.laps] == [Finish.ENDED, Finish.PROOF]
    assert result.winner.certified is not None
    assert result.winner.certified.objective is not None


def test_without_a_proof_the_best_point_wins() -> None:
    options = SolveOptions(time_limit=1.0)
    seen: list[tuple[str, Progress]] = []
    result = race(
        [Racer("a", "highs", HARD, options), Racer("b", "scipy", HARD, options)],
        on_progress=lambda name, progress: seen.append((name, progress)),
    )
    assert result.winner is not None
    assert result.winner.finish is Finish.POINT
    values = [lap.certified.objective for lap in result.laps if lap.certified is not None]
    assert result.winner.certified is not None
    assert result.winner.certified.objective == min(v for v in values if v is not None)
    assert {name for name, _ in seen} == {"a"}


def test_an_infeasible_claim_is_a_proof_to_be_confirmed() -> None:
    b = ModelBuilder()
    x = b.add_columns("x", (2,), -9, 9, integer=True)
    b.add_dense_rows("r", x[None, :], [2, 4], 1, 1)
    result = race([Racer("highs", "highs", b.build())])
    assert result.winner is not None
    assert result.winner.certified is not None
    assert result.winner.certified.x is None


def test_failures_do_not_end_the_race() -> None:
    broken = SolveOptions(extra={"command": "false {mps} {sol}"})
    silent = SolveOptions(extra={"command": "true {mps} {sol}"})
    result = race(
        [
            Racer("unknown", "nobody", knapsack()),
            Racer("broken", "external", knapsack(), broken),
            Racer("silent", "external", knapsack(), silent),
        ]
    )
    assert result.winner is None
    finishes = {lap.name: lap.finish for lap in result.laps}
    assert finishes == {
        "unknown": Finish.FAILED, "broken": Finish.FAILED, "silent": Finish.NOTHING,
    }  # fmt: skip
    assert "there is no backend 'nobody'" in result.laps[0].message


def test_a_memory_limit_fails_the_racer_alone() -> None:
    result = race([Racer("small", "highs", HARD, memory=20 * 2**20)])
    (lap,) = result.laps
    assert lap.finish is Finish.FAILED
    assert "memory" in lap.message


def test_stopping_ends_children_of_children(tmp_path: Path) -> None:
    script = tmp_path / "sleeper.sh"
    script.write_text(f"#!/bin/sh\necho $$ > {tmp_path}/pid\nexec sleep 100\n")
    script.chmod(0o755)
    options = SolveOptions(extra={"command": f"{script} {{mps}} {{sol}}"})
    pid = tmp_path / "pid"
    result = race(
        [Racer("sleeper", "external", knapsack(), options)],
        should_stop=lambda: pid.exists() and pid.read_text().strip() != "",
    )
    assert result.laps[0].finish is Finish.ENDED
    ended = int(pid.read_text())
    assert comes_true(lambda: _gone(ended))


def _gone(pid: int) -> bool:
    """Ended; a zombie has, too."""
    try:
        os.kill(pid, 0)
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except (ProcessLookupError, FileNotFoundError):
        return True


def test_names_must_differ() -> None:
    with pytest.raises(UsageError, match="one name"):
        race([Racer("a", "highs", HARD), Racer("a", "scip", HARD)])
    with pytest.raises(UsageError, match="at least one"):
        race([])


def test_a_cluster_races_too() -> None:
    from distributed import LocalCluster

    from stlc.solve.racing.cluster import race_on_cluster

    with LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None
    ) as cluster:
        slow = Racer("scip:hard", "scip", HARD, SolveOptions(time_limit=120.0))
        easy = Racer("highs:easy", "highs", knapsack())
        result = race_on_cluster(cluster.scheduler_address, [slow, easy])
    assert result.winner is not None
    assert result.winner.name == "highs:easy"
    assert result.laps[0].finish is Finish.ENDED


def test_an_unreachable_cluster_is_a_clear_error(monkeypatch: pytest.MonkeyPatch) -> None:
    from stlc.solve.racing.cluster import race_on_cluster

    monkeypatch.setattr("stlc.solve.racing.cluster._TIMEOUT", 1.0)
    with pytest.raises(SolverError, match="cannot reach the cluster"):
        race_on_cluster("tcp://127.0.0.1:9", [Racer("a", "highs", HARD)])
