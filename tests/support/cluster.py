"""A real dask scheduler and workers on loopback, each a process of its own."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

_QUIET = ("--host", "127.0.0.1", "--no-dashboard")


@contextmanager
def cluster(folder: Path, workers: int) -> Iterator[tuple[str, list[subprocess.Popen[str]]]]:
    """Address of the scheduler, and the workers' processes; all are killed at the end."""
    with ExitStack() as stack:
        scheduler = stack.enter_context(_process("dask_scheduler", *_QUIET, "--port", "0"))
        address = _address(scheduler)
        more = ("--nthreads", "1", "--no-nanny", "--local-directory", str(folder / "dask"))
        words = ("dask_worker", address, *_QUIET, *more)
        yield address, [stack.enter_context(_process(*words)) for _ in range(workers)]


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
