"""Plans whose parameters aren't the mission's, and numbers that no solver takes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from support.command import inside as stlc

SPEC = """param v = 2 m/s
horizon 2
workspace box [0, 10] x [0, 10]
agent a : single_integrator { start (1, 1); speed <= v }
require visit: eventually[0, 2] a.x >= 1 m
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A mission `m.stl` and a plan of it, `p.json`, made with another speed."""
    path = tmp_path_factory.mktemp("planned")
    (path / "m.stl").write_text(SPEC)
    words = ("solve", "m.stl", "-D", "v=1", "-o", "p.json", "--progress", "none")
    done = stlc(*words, folder=path)
    assert done.returncode == 0, done.stderr
    return path


@pytest.mark.parametrize(
    ("params", "said"),
    [
        ({"v": "a"}, "bad.json: not a valid plan at params.v: expected a number"),
        ({"v": "1 cubit"}, "bad.json: not a valid plan at params.v: expected a number"),
        ({"w": "1"}, "bad.json: not a valid plan at params.w: expected a `param` of the mission"),
    ],
)
@pytest.mark.parametrize("command", ["verify", "explain", "simulate"])
def test_parameters_of_a_plan_are_the_plans_fault(
    command: str, params: dict[str, str], said: str, folder: Path
) -> None:
    plan = json.loads((folder / "p.json").read_text()) | {"params": params}
    (folder / "bad.json").write_text(json.dumps(plan))
    done = stlc(command, "m.stl", "bad.json", folder=folder)
    assert done.returncode == 2
    assert said in done.stderr
    assert "-D" not in done.stderr


def test_what_is_set_here_is_no_fault_of_the_plan(folder: Path) -> None:
    plan = json.loads((folder / "p.json").read_text()) | {"params": {"v": "a"}}
    (folder / "bad.json").write_text(json.dumps(plan))
    assert stlc("verify", "m.stl", "bad.json", "-D", "v=1", folder=folder).returncode == 0
    wrong = stlc("verify", "m.stl", "p.json", "-D", "v=a", folder=folder)
    assert wrong.returncode == 1
    assert "E0222" in wrong.stderr


@pytest.mark.parametrize("option", ["--seed", "--threads"])
def test_numbers_beyond_every_solver(option: str, folder: Path) -> None:
    for value in (-1, 2**31, 10**20):
        done = stlc("solve", "m.stl", option, value, folder=folder)
        assert done.returncode == 2
        assert "is not in the range" in done.stderr
