"""What is seen of a command at work: NDJSON events, files."""

from __future__ import annotations

import json
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

from support.command import LIMIT


def wait_for(process: subprocess.Popen[str], kind: str) -> dict[str, object]:
    """The first event of a kind on standard error."""
    assert process.stderr is not None
    for line in process.stderr:
        if line.startswith("{") and json.loads(line)["event"] == kind:
            return dict(json.loads(line))
    raise AssertionError(f"the process ended without an event '{kind}'")


def comes_true(condition: Callable[[], bool]) -> bool:
    """Whether it does before a command that hangs would be given up."""
    end = time.monotonic() + LIMIT
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


def wait_for_file(process: subprocess.Popen[str], file: Path) -> None:
    """Until the file is there, however long that takes, while the process lives."""
    while not file.exists():
        assert process.poll() is None, f"the process ended without the file {file.name}"
        time.sleep(0.02)
