"""Standard streams that are full, closed or left early: a documented status, never a traceback."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from support.command import LIMIT, MISSION, command, stlc

READERS = (("check", "m.stl"), ("fmt", "--stdout", "m.stl"), ("backends",), ("encodings", "--json"),
           ("solve", "m.stl", "--json", "--progress", "none"), ("compile", "m.stl", "--stats"),
           ("--help",), ("--version",))  # fmt: skip


def _run(folder: Path, tail: str, *words: str) -> subprocess.CompletedProcess[str]:
    """`stlc WORDS` with a shell's redirections behind it; its own status, not the reader's."""
    (folder / "m.stl").write_text(MISSION)
    text = f'{{ "$@"; echo $? >status; }} {tail}'
    shell = ["bash", "-c", text, "bash", *command(*words)]
    done = subprocess.run(
        shell, cwd=folder, capture_output=True, text=True, timeout=LIMIT, check=False
    )
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr
    return done


def _status(folder: Path) -> int:
    return int((folder / "status").read_text())


@pytest.mark.parametrize("words", READERS, ids=lambda w: w[0])
def test_a_full_or_closed_output_is_74(words: tuple[str, ...], tmp_path: Path) -> None:
    done = _run(tmp_path, ">/dev/full", *words)
    assert _status(tmp_path) == 74
    assert "cannot write standard output: the disk is full" in done.stderr
    done = _run(tmp_path, ">&-", *words)
    assert _status(tmp_path) == 74
    assert "cannot write standard output: it is closed" in done.stderr


@pytest.mark.parametrize("words", READERS, ids=lambda w: w[0])
def test_a_reader_that_leaves_changes_nothing(words: tuple[str, ...], tmp_path: Path) -> None:
    for tail in ("| true", "| head -1", "2>&1 | true"):
        _run(tmp_path, tail, *words)
        assert _status(tmp_path) == 0


def test_the_verdict_stands_without_a_reader(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(MISSION)
    assert stlc("solve", "m.stl", "-o", "p.json", folder=tmp_path).returncode == 0
    other = MISSION.replace("[2, 3] x [1, 2]", "[7, 8] x [1, 2]")
    (tmp_path / "other.stl").write_text(other)
    for tail in ("| true", "2>/dev/full", "2>&-"):
        _run(tmp_path, tail, "verify", "other.stl", "p.json")
        assert _status(tmp_path) == 6


def test_all_streams_closed(tmp_path: Path) -> None:
    _run(tmp_path, "<&- >&- 2>&-", "check", "m.stl")
    assert _status(tmp_path) == 74


def test_standard_output_by_its_name(tmp_path: Path) -> None:
    """Although descriptor 1 is given away."""
    (tmp_path / "m.stl").write_text(MISSION)
    words = ("--csv", "/dev/stdout", "--progress", "none")
    done = stlc("solve", "m.stl", *words, folder=tmp_path)
    assert done.returncode == 0
    assert "t,time,agent,px" in done.stdout


def test_what_libraries_print_is_not_in_the_output(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(MISSION)
    code = (
        "import ctypes, sys; c = ctypes.CDLL(None)\n"
        "import stlc.solve.driver as d; plan = d.solve_mission\n"
        "def loud(*a):\n    c.puts(b'a banner'); return plan(*a)\n"
        "d.solve_mission = loud\n"
        "from stlc.cli import main; main()\n"
    )
    words = ["solve", "m.stl", "--json", "--progress", "none"]
    done = subprocess.run(
        [sys.executable, "-c", code, *words], cwd=tmp_path, capture_output=True, text=True,
        timeout=LIMIT, check=False, env=dict(os.environ),
    )  # fmt: skip
    assert json.loads(done.stdout)["status"] == "optimal"
