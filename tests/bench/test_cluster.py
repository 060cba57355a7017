"""A real scheduler and two real workers on loopback; one of them is killed on the way."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from support.tiny import registry

from stlc.bench.cluster import run_on_cluster
from stlc.bench.job import Job, Limits
from stlc.bench.local import run_local
from stlc.bench.record import Record
from stlc.bench.registry import load_suites
from stlc.bench.schedule import Choice, schedule

pytest.importorskip("distributed")


@contextmanager
def _process(*words: str) -> Iterator[subprocess.Popen[str]]:
    env = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(
        [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=env,
    ) as process:  # fmt: skip
        try:
            yield process
        finally:
            process.kill()


def _address(scheduler: subprocess.Popen[str]) -> str:
    assert scheduler.stderr is not None
    for line in scheduler.stderr:
        found = re.search(r"Scheduler at:\s+(tcp://\S+)", line)
        if found:
            return found.group(1)
    raise AssertionError("the scheduler didn't start")


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
    options = ("--host", "127.0.0.1", "--no-dashboard")
    with _process("dask_scheduler", *options, "--port", "0") as scheduler:
        address = _address(scheduler)
        worker = ("dask_worker", address, "--nthreads", "1", "--no-nanny", "--host", "127.0.0.1")
        where = ("--local-directory", str(tmp_path / "dask"), "--no-dashboard")
        with _process(*worker, *where) as first, _process(*worker, *where):
            runs: list[Record] = []
            for run in run_on_cluster(address, jobs, _never):
                runs.append(run)
                if len(runs) == 1:
                    time.sleep(0.5)  # both workers are in the middle of a run
                    first.kill()
    assert first.returncode == -9
    assert len(runs) == len(jobs)
    assert _outcomes(runs) == _outcomes(local)
