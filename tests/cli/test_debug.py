"""STLC_DEBUG=1: where an internal error came from, and every event of a search."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from support.command import MISSION
from support.command import inside as stlc


@pytest.mark.parametrize("asked", ["", "1"])
def test_an_internal_error_is_owned_up_to(
    asked: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("by design")

    monkeypatch.setenv("STLC_DEBUG", asked)
    monkeypatch.setattr("stlc.sema.load_mission", broken)
    (tmp_path / "m.stl").write_text(MISSION)
    done = stlc("check", "m.stl", folder=tmp_path)
    assert done.returncode == 70
    assert "internal error (ZeroDivisionError: by design)" in done.stderr
    assert ("Traceback" in done.stderr) == bool(asked)


def test_events_are_logged_though_no_progress_is_wanted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("STLC_DEBUG", "1")
    (tmp_path / "m.stl").write_text(MISSION)
    done = stlc("solve", "m.stl", "--progress", "none", folder=tmp_path)
    assert done.returncode == 0
    events = [json.loads(line) for line in done.stderr.splitlines() if line.startswith("{")]
    assert [e["stage"] for e in events if e["event"] == "status"][-1] == "done"
