"""Local processes and a cluster that loses a worker give the same optima.

    python benchmarks/cluster_check.py [SUITE ...] [--time-limit 60] [--only NAME ...]
                                       [--all] [--recorded]

Every quick problem of the suites (default: all suites; `--all`: every problem) is solved twice: by
processes of this machine, and by a dask cluster of a scheduler and two workers on loopback, of
which one is killed (SIGKILL) in the middle of a run, and replaced by another later. Every quick
problem must be proven both times, with equal optima. Where a problem of `--all` was not proven in
time, no plan of one side may be better than the bound of the other. `--recorded` takes the local
runs from `results/` where they are of the same mission.
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
from contextlib import ExitStack, contextmanager
from pathlib import Path

from stlc.bench.cluster import run_on_cluster
from stlc.bench.job import Job, Limits
from stlc.bench.local import run_local
from stlc.bench.record import Record
from stlc.bench.registry import chosen_suites, load_suites
from stlc.bench.schedule import Choice, schedule
from stlc.bench.table import read_csv

FOLDER = Path(__file__).parent
_ALONE = ("--host", "127.0.0.1", "--no-dashboard")
_FAILED = ("failed", "refused", "out_of_memory")


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
    raise SystemExit(f"{process.args!r} ended without saying {pattern}")


def on_cluster(jobs: Sequence[Job], folder: Path) -> list[Record]:
    """Runs of a cluster whose first worker is killed one second after the first run is finished."""
    with ExitStack() as stack:
        scheduler = stack.enter_context(dask("dask_scheduler", *_ALONE, "--port", "0"))
        address = told(scheduler, r"Scheduler at:\s+(tcp://\S+)")

        def worker() -> subprocess.Popen[str]:
            words = ("--nthreads", "1", "--no-nanny", *_ALONE, "--local-directory", str(folder))
            process = stack.enter_context(dask("dask_worker", address, *words))
            told(process, r"(Registered to)")
            return process

        first, _second = worker(), worker()
        runs: list[Record] = []
        for run in run_on_cluster(address, jobs, lambda: False):
            runs.append(run)
            if len(runs) == 1:
                threading.Timer(1.0, first.kill).start()
            if len(runs) == 4:
                assert first.wait() == -9, "the first worker wasn't killed"
                worker()
        assert first.wait() == -9, "the first worker wasn't killed"
    return runs


def recorded(jobs: Sequence[Job]) -> dict[tuple[str, str], Record]:
    """Runs of `results/` that are the first of a job's problem and configuration."""
    asked = {(job.suite, job.problem, job.config.label, job.repeat, job.digest) for job in jobs}
    runs = (run for table in sorted(FOLDER.glob("results/*.csv")) for run in read_csv(table))
    return {
        (run.suite, run.problem): run
        for run in runs
        if (run.suite, run.problem, run.label, run.repeat, run.digest) in asked
    }


def differences(local: Sequence[Record], remote: Sequence[Record]) -> dict[str, str]:
    """What is wrong with the two runs of each problem: "" nothing, "open" not proven twice."""
    far = {(run.suite, run.problem): run for run in remote}
    found = {}
    for run in local:
        other = far[run.suite, run.problem]
        name = f"{run.suite}/{run.problem}"
        found[name] = contradiction(run, other) or ("" if run.solved and other.solved else "open")
        results = f"{run.objective} {other.objective}"
        print(f"{name:36} {run.status:10} {other.status:10} {results} {found[name]}")
    return found


def contradiction(run: Record, other: Record) -> str:
    """How two runs of one (minimisation) problem can't both be right, beyond their gaps."""
    for one, two in ((run, other), (other, run)):
        if one.status in _FAILED:
            return f"{one.status}: {one.message}"
        if one.objective is None:
            continue
        if two.status == "infeasible":
            return f"infeasible, and a plan of {one.objective}"
        allowed = (one.gap_limit + 1e-6) * max(1.0, abs(one.objective))
        if two.bound is not None and one.objective < two.bound - allowed:
            return f"{one.objective} is better than the bound {two.bound}"
    return ""


def main() -> int:
    """Compare; 1 when something differs."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("suites", nargs="*")
    parser.add_argument("--time-limit", type=float, default=60.0)
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--all", action="store_true", help="every problem, not the quick ones only")
    parser.add_argument("--recorded", action="store_true", help="local runs are those of results/")
    asked = parser.parse_args()
    suites = chosen_suites(load_suites(FOLDER), tuple(asked.suites))
    choice = Choice(encodings=("auto",), quick=not asked.all, only=tuple(asked.only))
    jobs = schedule(FOLDER, suites, choice, Limits(asked.time_limit))
    known = recorded(jobs) if asked.recorded else {}
    missing = [job for job in jobs if (job.suite, job.problem) not in known]
    local = [*known.values(), *run_local(missing, 2, lambda: False)]
    with tempfile.TemporaryDirectory() as folder:
        remote = on_cluster(jobs, Path(folder))
    found = differences(local, remote)
    allowed = {"", "open"} if asked.all else {""}
    wrong = [f"{name}: {what}" for name, what in found.items() if what not in allowed]
    if len(local) != len(jobs) or len(remote) != len(jobs):
        wrong.append(f"{len(jobs)} runs asked for: {len(local)} local, {len(remote)} remote")
    proven, left = (sum(what == kind for what in found.values()) for kind in ("", "open"))
    summary = f"{proven} problems proven twice, same optima; {left} open, plans and bounds agree"
    print("\n".join(wrong) or f"{summary}; one worker was killed")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
