"""Local processes and a cluster that loses a worker give the same optima.

    python benchmarks/cluster_check.py [SUITE ...] [--time-limit 60] [--only NAME ...]

Every quick problem of the suites (default: all) is solved twice: by processes of this machine, and
by a dask cluster of a scheduler and two workers on loopback, of which one is killed (SIGKILL) in
the middle of a run. Every problem must be proven both times, with equal optima.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from stlc.bench.cluster import run_on_cluster
from stlc.bench.job import Job, Limits
from stlc.bench.local import run_local
from stlc.bench.record import Record
from stlc.bench.registry import chosen_suites, load_suites
from stlc.bench.schedule import Choice, schedule

FOLDER = Path(__file__).parent
_ALONE = ("--host", "127.0.0.1", "--no-dashboard")


@contextmanager
def dask(*words: str) -> Iterator[subprocess.Popen[str]]:
    """One of dask's own programs, killed at the end."""
    env = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    with subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.{words[0]}", *words[1:]],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=env,
    ) as process:  # fmt: skip
        try:
            yield process
        finally:
            process.kill()


def told(process: subprocess.Popen[str], pattern: str) -> str:
    """The first group of the first line that matches; what comes after it is thrown away."""
    assert process.stderr is not None
    for line in process.stderr:
        if found := re.search(pattern, line):
            threading.Thread(target=process.stderr.read, daemon=True).start()
            return found.group(1)
    raise SystemExit(f"{process.args} ended without saying {pattern}")


def on_cluster(jobs: Sequence[Job], folder: Path) -> list[Record]:
    """Runs of a cluster whose first worker is killed one second after the first run is finished."""
    with dask("dask_scheduler", *_ALONE, "--port", "0") as scheduler:
        address = told(scheduler, r"Scheduler at:\s+(tcp://\S+)")
        worker = ("dask_worker", address, "--nthreads", "1", "--no-nanny", *_ALONE,
                  "--local-directory", str(folder))  # fmt: skip
        with dask(*worker) as first, dask(*worker) as second:
            for one in (first, second):
                told(one, r"(Registered to)")
            runs: list[Record] = []
            for run in run_on_cluster(address, jobs, lambda: False):
                runs.append(run)
                if len(runs) == 1:
                    threading.Timer(1.0, first.kill).start()
            assert first.wait() == -9, "the first worker wasn't killed"
    return runs


def differences(local: Sequence[Record], remote: Sequence[Record]) -> list[str]:
    """Problems that were not proven twice with one optimum (relative tolerance: both gaps)."""
    far = {(run.suite, run.problem): run for run in remote}
    found = []
    for run in local:
        other = far[run.suite, run.problem]
        a, b = run.objective, other.objective
        print(f"{run.suite}/{run.problem:28} {run.status:10} {other.status:10} {a} {b}")
        if run.status != other.status or not run.solved:
            found.append(f"{run.problem}: {run.status}, {other.status}")
        elif a is not None and b is not None:
            allowed = (run.gap_limit + other.gap_limit + 1e-6) * max(1.0, abs(a))
            if abs(a - b) > allowed:
                found.append(f"{run.problem}: {a} and {b}")
    return found


def main() -> int:
    """Compare; 1 when something differs."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("suites", nargs="*")
    parser.add_argument("--time-limit", type=float, default=60.0)
    parser.add_argument("--only", nargs="*", default=[])
    asked = parser.parse_args()
    suites = chosen_suites(load_suites(FOLDER), tuple(asked.suites))
    choice = Choice(encodings=("auto",), quick=True, only=tuple(asked.only))
    jobs = schedule(FOLDER, suites, choice, Limits(asked.time_limit))
    local = list(run_local(jobs, 2, lambda: False))
    with tempfile.TemporaryDirectory() as folder:
        remote = on_cluster(jobs, Path(folder))
    wrong = differences(local, remote)
    if len(local) != len(jobs) or len(remote) != len(jobs):
        wrong.append(f"{len(jobs)} runs asked for: {len(local)} local, {len(remote)} remote")
    print("\n".join(wrong) or f"{len(jobs)} problems: same optima; one worker was killed")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
