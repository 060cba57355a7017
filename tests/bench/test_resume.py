"""A command that is killed again and again ends with the runs of one that was not."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import time
from pathlib import Path

from support.tiny import registry

from stlc.bench.store import Store

_KILLS = 5


def _start(folder: Path, store: Path) -> subprocess.Popen[bytes]:
    words = ["bench", "tiny", "--registry", str(folder), "--store", str(store), "--time-limit", "9",
             "--repeat", "2", "--quick"]  # fmt: skip
    return subprocess.Popen(
        [sys.executable, "-c", "import stlc.cli; stlc.cli.main()", *words],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip


def _outcomes(store: Path) -> list[tuple[object, ...]]:
    runs = Store(store).records()
    return sorted((r.problem, r.label, r.repeat, r.status, r.objective, r.rows) for r in runs)


def _kill(process: subprocess.Popen[bytes], store: Store, wanted: int, delay: float) -> None:
    """Kill it at some moment after it has finished `wanted` runs."""
    while not store.path.is_file() or len(store.keys()) < wanted:
        assert process.poll() is None
        time.sleep(0.02)
    time.sleep(delay)
    process.kill()
    assert process.wait() == -signal.SIGKILL


def test_killed_five_times_and_resumed(tmp_path: Path) -> None:
    folder, whole, torn = registry(tmp_path), tmp_path / "whole.sqlite", tmp_path / "torn.sqlite"
    assert _start(folder, whole).wait(120) == 0
    Store(torn).create()
    moments = random.Random(7)
    for count in range(_KILLS):
        _kill(_start(folder, torn), Store(torn), count, moments.uniform(0.1, 1.0))
    assert _start(folder, torn).wait(120) == 0
    assert len(_outcomes(whole)) == 8
    assert _outcomes(torn) == _outcomes(whole)
