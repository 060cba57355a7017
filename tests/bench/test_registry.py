"""The registry that ships: its missions are what the generators give, and are missions."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from stlc.api import loads
from stlc.bench.registry import default_folder, load_suites, read_files

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "benchmarks"
PROBLEMS = [(s, p) for s in load_suites(FOLDER).values() for p in s.problems]


def test_suites_and_no_name_twice() -> None:
    assert default_folder() == FOLDER
    suites = "paper headline stlpy radio teams scaling long published networks ablation"
    assert list(load_suites(FOLDER)) == suites.split()
    names = [(suite.name, problem.name) for suite, problem in PROBLEMS]
    assert len(set(names)) == len(names)
    assert all(any(p.quick for p in suite.problems) for suite in load_suites(FOLDER).values())


@pytest.mark.parametrize("problem", [p for _, p in PROBLEMS], ids=lambda p: p.file)
def test_every_mission_passes_its_check(problem: object) -> None:
    files = read_files(FOLDER, problem)  # type: ignore[arg-type]
    name = problem.file  # type: ignore[attr-defined]
    folder = (FOLDER / "missions" / name).parent
    mission = loads(files[Path(name).name].decode(), name=name, folder=folder)
    expected = {"W1003", "W1008"}  # regions beyond the workspace, an outer speed polygon
    assert {d.code for d in mission.warnings} <= expected


def test_missions_are_what_the_generators_give() -> None:
    script = (
        "import numpy as np\nfrom generate import MISSIONS, generated, tables\n"
        "from registry import SUITES\n"
        "for suite in SUITES:\n for p in suite.problems:\n"
        "  assert not p.generator or (MISSIONS / p.file).read_text() == generated(p), p.name\n"
        "  for name, values in tables(p).items():\n"
        "   (found,) = np.load(MISSIONS / name).values()\n"
        "   assert np.abs(found - values).max() < 2e-4, name\n"
    )
    env = os.environ | {"PYTHONPATH": os.pathsep.join([str(FOLDER), *sys.path])}
    done = subprocess.run([sys.executable, "-c", script], env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
