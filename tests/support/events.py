"""What is seen of a command at work: NDJSON events, files."""

from __future__ import annotations

import json
import subprocess
import time
from pathlib import Path


def wait_for(process: subprocess.Popen[str], kind: str) -> dict[str, object]:
    """The first event of a kind on standard error."""
    assert process.stderr is not None
    for line in process.stderr:
        if line.startswith("{") and json.loads(line)["event"] == kind:
            return dict(json.loads(line))
    raise AssertionError(f"the process ended without an event '{kind}'")


def wait_for_file(process: subprocess.Popen[str], file: Path) -> None:
    """Until the file is there, however long that takes, while the process lives."""
    while not file.exists():
        assert process.poll() is None, f"the process ended without the file {file.name}"
        time.sleep(0.02)
