"""A command that is killed again and again ends with the runs of one that was not."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
from pathlib import Path

from stlc.bench.store import Store

from .tiny import registry

_KILLS = 5


def _start(folder: Path, store: Path) -> subprocess.Popen[bytes]:
    words = ["bench", "tiny", "--registry", str(folder), "--store", str(store), "--time-limit", "9"]
    return subprocess.Popen(
        [sys.executable, "-c", "import stlc.cli; stlc.cli.main()", *words],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip


def _outcomes(store: Path) -> list[tuple[object, ...]]:
    runs = Store(store).records()
    return sorted((r.problem, r.label, r.repeat, r.status, r.objective, r.rows) for r in runs)


def test_killed_five_times_and_resumed(tmp_path: Path) -> None:
    folder, whole, torn = registry(tmp_path), tmp_path / "whole.sqlite", tmp_path / "torn.sqlite"
    assert _start(folder, whole).wait(120) == 0
    moments = random.Random(7)
    for _ in range(_KILLS):
        process = _start(folder, torn)
        try:
            process.wait(moments.uniform(0.8, 3.5))
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.wait()
    assert _start(folder, torn).wait(120) == 0
    assert len(_outcomes(whole)) == 6
    assert _outcomes(torn) == _outcomes(whole)
