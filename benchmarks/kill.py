"""kill -9 at random moments of a solve: is every plan that was announced as saved there?

    python benchmarks/kill.py [N] [BACKEND ...]

Four of five kills come at a random time after the first plan was announced, the others after the
start. Backends without incumbent callbacks must say that they have none (a `diagnostic` event).
"""

from __future__ import annotations

import json
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from stlc import backends
from stlc.api import load
from stlc.backends.base import Capability
from stlc.plan import read_plan
from stlc.verify import verify

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
LATEST = 4.0  # s after the start, or the first announcement
PATIENCE = 60.0  # s for the first announcement


def trial(folder: Path, backend: str, after: float, *, early: bool) -> tuple[str, bool]:
    """Kill one solve; a line for people, and whether nothing was lost."""
    from support.command import long_mission, start

    plan, mission = folder / "p.json", long_mission(folder)
    plan.unlink(missing_ok=True)
    words = ("--strategy", "milp", "--backend", backend, "-o", plan, "--progress", "ndjson")
    process = start("solve", mission, *words, "--time-limit", PATIENCE, folder=folder)
    live = Capability.INCUMBENTS & backends.get(backend).capabilities
    heard = "" if early or not live else _until_a_solution(process)
    time.sleep(after)
    process.send_signal(signal.SIGKILL)
    said = heard + process.communicate()[1]
    events = [json.loads(x) for x in said.splitlines() if x.startswith("{") and x.endswith("}")]
    saved = [e["objective"] for e in events if e["event"] == "solution"]
    if not live:
        working = any(e.get("stage") == "solve" for e in events)
        told = not working or any("hands over no plan" in e.get("message", "") for e in events)
        return f"no incumbents, said so: {told}", told and not saved
    if not saved:
        return "nothing announced", True
    found = read_plan(plan)
    value = found.solve.objective
    kept = value is not None and value <= min(saved) + 1e-9
    kept = kept and verify(load(mission), found).ok
    return f"{len(saved)} announced, best {min(saved):.4g}, on disk {value:.4g}", kept


def _until_a_solution(process: subprocess.Popen[str]) -> str:
    assert process.stderr is not None
    heard = ""
    for line in process.stderr:
        heard += line
        if '"solution"' in line:
            break
    return heard


def main() -> int:
    """Run the trials."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    names = sys.argv[2:] or ["highs", "scip"]
    rng, lost = random.Random(0), 0
    with tempfile.TemporaryDirectory() as folder:
        for backend in names:
            for k in range(count):
                after, early = rng.uniform(0.0, LATEST), k % 5 == 0
                text, kept = trial(Path(folder), backend, after, early=early)
                lost += not kept
                since = "the start" if early else "the first plan"
                print(f"{backend} {k}: killed {after:.1f} s after {since}: {text}", flush=True)
    print(f"{lost} of {count * len(names)} lost a saved plan")
    return int(lost > 0)


if __name__ == "__main__":
    sys.exit(main())
