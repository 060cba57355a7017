"""Start-up of the command line against a bare interpreter, in alternating order.

    python benchmarks/startup.py [ROUNDS]

Each round runs the three commands once, the order turning from round to round. Printed are the
medians of wall-clock and processor time, and how much each command takes beyond `python -c pass`.
Byte code is kept in a folder of its own, whatever the environment says, as in an installation.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import Final

MISSION: Final = Path(__file__).parent.parent / "examples" / "paper_two_agents.stl"
ENTRY: Final = "import sys; from stlc.cli import main; sys.argv[0] = 'stlc'; main()"
AIMS: Final = {"stlc --version": 150.0, "stlc check": 350.0}  # ms beyond the interpreter


def commands() -> dict[str, list[str]]:
    """What is timed; the entry point is called as the installed script does."""
    python = sys.executable
    return {
        "python -c pass": [python, "-c", "pass"],
        "stlc --version": [python, "-c", ENTRY, "--version"],
        "stlc check": [python, "-c", ENTRY, "check", str(MISSION)],
    }


def once(command: list[str], cache: str) -> tuple[float, float]:
    """Wall-clock and processor time of one run [ms]; `cache` is the folder of byte code."""
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": cache, "PYTHONDONTWRITEBYTECODE": ""}
    before, begin = os.times(), time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=environment)
    wall, after = time.perf_counter() - begin, os.times()
    used = after.children_user + after.children_system
    used -= before.children_user + before.children_system
    return 1e3 * wall, 1e3 * used


def measured(rounds: int) -> dict[str, list[tuple[float, float]]]:
    """All runs of each command."""
    todo = commands()
    names = list(todo)
    seen: dict[str, list[tuple[float, float]]] = {name: [] for name in todo}
    with tempfile.TemporaryDirectory() as cache:
        for command in todo.values():
            once(command, cache)  # writes the byte code
        for turn in range(rounds):
            for k in range(len(names)):
                name = names[(turn + k) % len(names)]
                seen[name].append(once(todo[name], cache))
    return seen


def main(rounds: int) -> None:
    """Time the commands and print the table."""
    seen = measured(rounds)
    bare = [median(run[k] for run in seen["python -c pass"]) for k in range(2)]
    print(f"median of {rounds} [ms]    wall    cpu   beyond: wall    cpu    aim")
    for name, runs in seen.items():
        wall, cpu = (median(run[k] for run in runs) for k in range(2))
        aim = f"{AIMS[name]:7.0f}" if name in AIMS else ""
        print(f"{name:18} {wall:8.0f} {cpu:6.0f} {wall - bare[0]:14.0f} {cpu - bare[1]:6.0f}{aim}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 15)
