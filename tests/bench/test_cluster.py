"""A real scheduler and two real workers on loopback; one of them is killed on the way."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from support.cluster import cluster
from support.tiny import registry

from stlc.bench.cluster import run_on_cluster
from stlc.bench.job import Job, Limits
from stlc.bench.local import run_local
from stlc.bench.record import Record
from stlc.bench.registry import load_suites
from stlc.bench.schedule import Choice, schedule

pytest.importorskip("distributed")


def _never() -> bool:
    return False


def _outcomes(runs: list[Record]) -> list[tuple[object, ...]]:
    return sorted((r.problem, r.label, r.status, r.objective) for r in runs)


def _jobs(tmp_path: Path) -> tuple[Job, ...]:
    folder = registry(tmp_path)
    return schedule(folder, load_suites(folder).values(), Choice(quick=True), Limits(9.0))


def test_cluster_and_local_agree_though_a_worker_dies(tmp_path: Path) -> None:
    jobs = _jobs(tmp_path)
    local = list(run_local(jobs, 1, _never))
    with cluster(tmp_path, 2) as (address, (first, _)):
        runs: list[Record] = []
        for run in run_on_cluster(address, jobs, _never):
            runs.append(run)
            if len(runs) == 1:
                time.sleep(0.5)  # both workers are in the middle of a run
                first.kill()
        first.wait()
    assert first.returncode == -9
    assert len(runs) == len(jobs)
    assert _outcomes(runs) == _outcomes(local)
