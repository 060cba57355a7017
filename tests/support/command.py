"""The command line in a process of its own."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

import numpy as np

LIMIT = 120.0  # s: a command that hangs fails its test

MISSION = """step 1 s
horizon 4
workspace box [0, 10] x [0, 10]
agent a : double_integrator {
  start (1, 1)
  control |u| <= 1
  speed <= 2
}
region near = box [2, 3] x [1, 2]
obstacle pillar = box [5, 6] x [5, 6]
require visit: eventually[1, 4] a in near
require clear: always a outside pillar
minimize effort
"""

CONFLICT = """step 1 s
horizon 6
workspace box [0, 10] x [0, 10]
agent a : double_integrator {
  start (5, 5)
  control |u| <= 1
  speed <= 2
}
region left = box [2, 3] x [4, 6]
region right = box [7, 8] x [4, 6]
require visit: eventually[1, 3] a in left
require other: eventually[1, 3] a in right
minimize effort
"""

_CODE = (
    "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    "from stlc.cli import main; main()"
)

_LONG = """step 1 s
horizon 8
workspace box [0, 8] x [0, 8]
agent a0 : single_integrator { start (1, 1); control |u| <= 2 }
agent a1 : single_integrator { start (7, 1); control |u| <= 2 }
agent a2 : single_integrator { start (1, 7); control |u| <= 2 }
channel radio { partition 4 x 4; table "table.csv" }
require apart: always separation(a0, a1) >= 0
minimize 0.1 * effort + link_cost(radio)
"""


def long_mission(folder: Path, steps: int = 8) -> Path:
    """A mission with a first plan within a second or two and many better ones; its proof takes
    several seconds (three with 5 steps), a minute and more with 12 steps."""
    rng = np.random.default_rng(1)
    half = np.round(rng.uniform(0.1, 9, (16, 16)), 2)
    costs = np.triu(half) + np.triu(half, 1).T
    np.savetxt(folder / "table.csv", costs, fmt="%.2f", delimiter=",")
    path = folder / "long.stl"
    path.write_text(_LONG.replace("horizon 8", f"horizon {steps}"))
    return path


def command(*words: object) -> list[str]:
    """`stlc WORDS`, which hears Ctrl-C though the tests may run in a shell's background."""
    return [sys.executable, "-c", _CODE, *map(str, words)]


def stlc(
    *words: object, folder: Path, env: dict[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run `stlc WORDS` in a folder."""
    return subprocess.run(
        command(*words), cwd=folder, env=os.environ | (env or {}), capture_output=True, text=True,
        timeout=LIMIT, check=False,
    )  # fmt: skip


@dataclass(frozen=True)
class Done:
    """How a command ended."""

    returncode: int
    stdout: str
    stderr: str


def inside(*words: object, folder: Path) -> Done:
    """Run `stlc WORDS` in a folder and in this process, which is ten times faster."""
    from stlc.cli import cli
    from stlc.cli.common import run_guarded

    out, err = io.StringIO(), io.StringIO()
    before, argv = Path.cwd(), sys.argv
    sys.argv = ["stlc", *map(str, words)]
    os.chdir(folder)
    try:
        with redirect_stdout(out), redirect_stderr(err):
            status = run_guarded(cli)
    finally:
        os.chdir(before)
        sys.argv = argv
    return Done(status, out.getvalue(), err.getvalue())


def start(*words: object, folder: Path, stderr: int = subprocess.PIPE) -> subprocess.Popen[str]:
    """`stlc WORDS` at work."""
    return subprocess.Popen(
        command(*words), cwd=folder, stdout=subprocess.PIPE, stderr=stderr, text=True
    )
