"""Small inputs that once went wrong, each with its right value: `tests/cases`."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from support.command import Done, inside

CASES = Path(__file__).resolve().parent.parent / "cases"

INFEASIBLE = {
    "wall_flush_with_workspace": "clear",
    "union_seam": "clear",
    "swept_boat": "safe",
    "cells_too_coarse": "partition",
    "altitude": "`rssi(b, base) >= -70 dBm` is out of reach",
    "prr_average": "`prr(r, base) >= 0.69` is out of reach",
}
"""Case -> what is named as the reason."""

REFUSED = {
    "ring_repeated_corner": "E0401",
    "nan_dynamics": "E0308",
    "quantifier_cube": "E0224",
    "pairs_10000": "E0224",
    "until_5000": "E0802",
    "spec_keyerror": "E0804",
    "signal_in_plan": "E0804",
    "decompose_index": "E0101",
    "compile_crash_1": "E0309",
}
"""Case -> the code of a located error."""

OPTIMAL = {"border_predicates": 1.0, "border_cost": 40.0, "let_doubling": 0.0}
"""Case -> its optimum."""

INLINE = {
    "pieces that meet in a point": (
        "region z = polygon (3, 3) (5, 3) (5, 5) (7, 5) (7, 7) (5, 7) (5, 5) (3, 5)", "E0401",
    ),
    "a workspace where doubles are coarse": (
        "workspace box [1e12, 1000000000010] x [1e12, 1000000000010]", "E0416",
    ),
    "a corner that overflows": ("region z = polygon (0, 0) (1e200, 0) (1e200, 1e200)", "E0416"),
}  # fmt: skip
"""What -> (declaration, the code of a located error)."""


def solved(name: str, folder: Path) -> Done:
    """How `solve` of a case ends."""
    shutil.copy(CASES / f"{name}.stl", folder)
    words = ("--progress", "none", "--threads", "1", "-o", "plan.json")
    return inside("solve", f"{name}.stl", *words, folder=folder)


@pytest.mark.parametrize("name", INFEASIBLE)
def test_infeasible_and_says_why(name: str, tmp_path: Path) -> None:
    done = solved(name, tmp_path)
    assert done.returncode == 3, done.stderr
    assert INFEASIBLE[name] in done.stdout + done.stderr


@pytest.mark.parametrize("name", REFUSED)
def test_refused_at_its_place(name: str, tmp_path: Path) -> None:
    done = solved(name, tmp_path)
    assert done.returncode == 1, done.stderr
    assert f"error[{REFUSED[name]}]" in done.stderr
    assert f"{name}.stl:" in done.stderr


@pytest.mark.parametrize("name", OPTIMAL)
def test_optimum(name: str, tmp_path: Path) -> None:
    done = solved(name, tmp_path)
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "plan.json").read_text())["solve"]["objective"]
    assert found == pytest.approx(OPTIMAL[name], rel=1e-4, abs=1e-6)


def test_says_that_it_leaves_the_workspace_between_samples(tmp_path: Path) -> None:
    done = solved("workspace_between_samples", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "between samples r leaves the workspace by 0.64" in done.stdout


def test_overtakes_beside_the_truck(tmp_path: Path) -> None:
    """Its lane ends at the workspace's border, which is no way past it."""
    done = solved("truck_flush", tmp_path)
    assert done.returncode == 0, done.stderr
    ego = np.array(json.loads((tmp_path / "plan.json").read_text())["agents"]["ego"]["states"])
    now, later = ego[:-1], ego[1:]
    for s in np.linspace(0.0, 1.0, 101):
        mean = (now[:, 2:] + s * (later[:, 2:] - now[:, 2:]) / 2.0) * s * 0.5
        x, y = (now[:, :2] + mean).T
        rear = 24.0 + 7.0 * (np.arange(16) + s)
        assert not ((x > rear + 1e-6) & (x < rear + 12.0 - 1e-6) & (y < 4.2 - 1e-6)).any()


@pytest.mark.parametrize("what", INLINE)
def test_refused_inline(what: str, tmp_path: Path) -> None:
    text, code = INLINE[what]
    (tmp_path / "m.stl").write_text(
        f"{text}\nagent r : single_integrator {{ start (1, 1); control |u| <= 1 }}\n"
        "require a: always r.x >= 0 m\n"
    )
    done = inside("check", "m.stl", folder=tmp_path)
    assert done.returncode == 1
    assert f"error[{code}]" in done.stderr
