"""A second Ctrl-C, and a disk that fills up while a solver works: no traceback, nothing harmed."""

from __future__ import annotations

import errno
import json
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from support.command import LIMIT, MISSION, long_mission, start
from support.command import inside as stlc
from support.events import wait_for

from stlc import files
from stlc.plan import read_plan

OLD = '{"this": "was here before"}'


@contextmanager
def _small_disk(folder: Path, kilobytes: int) -> Iterator[bool]:
    """A file system of that size at `folder`, where we may mount one."""
    words = ["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", str(folder)]
    mounted = subprocess.run(words, capture_output=True, check=False).returncode == 0
    try:
        yield mounted
    finally:
        if mounted:
            subprocess.run(["umount", "-l", str(folder)], check=True)


def _interrupted_twice(folder: Path, first: signal.Signals, *words: str) -> str:
    """Standard error of a solve that gets a second signal right after the first."""
    (folder / "p.json").write_text(OLD)
    words = (*words, "-o", "p.json", "--progress", "ndjson")
    process = start(words[0], long_mission(folder), *words[1:], folder=folder)
    wait_for(process, "statistics" if words[0] == "solve" else "status")
    process.send_signal(first)
    time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=LIMIT)
    assert process.returncode in (0, 130), err
    assert "Traceback" not in err
    return err


@pytest.mark.parametrize("first", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(
    "words",
    [("solve", "--strategy", "milp"), ("solve", "--backend", "pulp"), ("race", "--with", "scip")],
    ids=["highs", "pulp", "race"],
)
def test_a_second_signal(words: tuple[str, ...], first: signal.Signals, tmp_path: Path) -> None:
    _interrupted_twice(tmp_path, first, *words)
    left = (tmp_path / "p.json").read_text()
    assert left == OLD or read_plan(tmp_path / "p.json").solve.objective is not None
    assert not list(tmp_path.glob(".stlc-*"))


def test_a_disk_that_is_full(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A real one of 16 kB where root may mount it; else the write that would fail fails."""
    (tmp_path / "m.stl").write_text(MISSION)
    disk = tmp_path / "disk"
    disk.mkdir()
    with _small_disk(disk, 16) as mounted:
        (disk / "p.json").write_text(OLD)
        if mounted:
            (disk / "ballast").write_bytes(bytes(3 * 4096))
        else:
            monkeypatch.setattr(files.os, "fsync", _full)
        for words in (("solve",), ("race", "--with", "highs:auto")):
            output = ("-o", disk / "p.json", "--progress", "ndjson")
            done = stlc(words[0], "m.stl", *words[1:], *output, folder=tmp_path)
            assert done.returncode == 74, done.stderr
            assert "the disk is full" in done.stderr
            assert "Traceback" not in done.stderr
            assert (disk / "p.json").read_text() == OLD
            assert not list(disk.glob(".stlc-*"))


def _full(descriptor: int) -> None:
    raise OSError(errno.ENOSPC, "No space left on device")


def test_a_disk_that_fills_up_on_the_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The solver works on, it is said once, and the outcome is told on standard output."""
    (tmp_path / "m.stl").write_text(MISSION)
    (tmp_path / "p.json").write_text(OLD)
    monkeypatch.setattr(files.os, "fsync", _full)
    words = ("--strategy", "milp", "-o", "p.json", "--progress", "ndjson")
    done = stlc("solve", "m.stl", *words, folder=tmp_path)
    assert done.returncode == 74
    events = [json.loads(line) for line in done.stderr.splitlines() if line.startswith("{")]
    told = [e["message"] for e in events if e["event"] == "diagnostic"]
    assert sum("the plan is not saved" in text for text in told) == 1
    assert {e["path"] for e in events if e["event"] == "solution"} == {None}
    assert (tmp_path / "p.json").read_text() == OLD
