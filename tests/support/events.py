"""NDJSON events of a command at work."""

from __future__ import annotations

import json
import subprocess


def wait_for(process: subprocess.Popen[str], kind: str) -> dict[str, object]:
    """The first event of a kind on standard error."""
    assert process.stderr is not None
    for line in process.stderr:
        if line.startswith("{") and json.loads(line)["event"] == kind:
            return dict(json.loads(line))
    raise AssertionError(f"the process ended without an event '{kind}'")
