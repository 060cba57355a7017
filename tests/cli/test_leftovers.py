"""However a command ends, no temporary folder and no process of it stays behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from support.command import LIMIT, command, long_mission
from support.events import comes_true, wait_for

ENDS = {
    "Ctrl-C": (signal.SIGINT,),
    "Ctrl-C twice": (signal.SIGINT, signal.SIGINT),
    "SIGTERM": (signal.SIGTERM,),
    "SIGHUP": (signal.SIGHUP,),
}
COMMANDS = {
    "solve": ("solve", "long.stl", "--backend", "pulp"),
    "race": ("race", "long.stl", "--with", "pulp:auto,scip:auto"),
}


def _ours(folder: Path) -> list[int]:
    """Processes that have the folder as their place for temporary files."""
    mark, found = str(folder).encode(), []
    for place in Path("/proc").glob("[0-9]*/environ"):
        try:
            if mark in place.read_bytes():
                found.append(int(place.parent.name))
        except OSError:  # gone, or another's
            continue
    return [pid for pid in found if pid != os.getpid()]


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("name", COMMANDS)
def test_nothing_stays_behind(name: str, end: str, tmp_path: Path) -> None:
    long_mission(tmp_path, 12)
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    process = subprocess.Popen(
        command(*COMMANDS[name], "--progress", "ndjson"), cwd=tmp_path, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, env={**os.environ, "TMPDIR": str(scratch)},
    )  # fmt: skip
    wait_for(process, "statistics" if name == "solve" else "status")
    assert comes_true(lambda: any(scratch.glob("stlc-*")))  # not Python's own probe
    for number in ENDS[end]:
        process.send_signal(number)
        time.sleep(0.02)
    _, err = process.communicate(timeout=LIMIT)
    assert process.returncode in (0, 130), err
    assert "Traceback" not in err
    assert "release unlocked lock" not in err
    assert list(scratch.iterdir()) == []
    assert comes_true(lambda: not _ours(scratch)), _ours(scratch)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells who works in which folder")
@pytest.mark.parametrize("name", COMMANDS)
def test_nothing_outlives_a_command_that_was_killed(name: str, tmp_path: Path) -> None:
    long_mission(tmp_path, 12)
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    process = subprocess.Popen(
        command(*COMMANDS[name], "--progress", "ndjson"), cwd=tmp_path, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={**os.environ, "TMPDIR": str(scratch)},
    )  # fmt: skip
    wait_for(process, "statistics" if name == "solve" else "status")
    assert comes_true(lambda: any(scratch.glob("stlc-*/*")))
    process.kill()
    process.communicate(timeout=LIMIT)
    assert comes_true(lambda: not _ours(scratch)), _ours(scratch)
    assert list(scratch.glob("stlc-*")) == []
