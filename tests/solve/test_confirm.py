"""A solver that denies a plan which exists: the plan is handed over, the solver named."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from support.command import CONFLICT, MISSION
from support.command import inside as stlc
from support.liars import plug

from stlc.backends import scip
from stlc.plan import read_plan


@pytest.mark.parametrize("liar", ["denier", "forgetter"])
def test_the_plan_is_handed_over_and_the_liar_named(
    liar: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plug(monkeypatch)
    (tmp_path / "m.stl").write_text(MISSION)
    words = ("--backend", liar, "--strategy", "milp", "-o", "p.json", "--json")
    done = stlc("solve", "m.stl", *words, folder=tmp_path)
    assert done.returncode == 5
    assert f"the answer of {liar} (Denier 1.0) is refused: it claims infeasible" in done.stderr
    said = json.loads(done.stdout)
    assert said["verified"] is True
    assert said["refused"] in done.stderr
    assert said["objective"] == pytest.approx(2 / 7, abs=1e-5)  # bettered, or HiGHS's own
    assert read_plan(tmp_path / "p.json").solve.objective == said["objective"]
    assert stlc("verify", "m.stl", "p.json", folder=tmp_path).returncode == 0


def test_the_second_solver_is_named_as_the_finder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plug(monkeypatch)
    (tmp_path / "m.stl").write_text(MISSION)
    words = ("--backend", "denier", "--strategy", "milp", "--json")
    said = json.loads(stlc("solve", "m.stl", *words, folder=tmp_path).stdout)
    assert said["status"] == "optimal"
    assert said["backend"] == "scip"


def test_a_true_denial_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plug(monkeypatch)
    (tmp_path / "m.stl").write_text(CONFLICT)
    words = ("--backend", "denier", "--strategy", "milp", "--no-explain")
    done = stlc("solve", "m.stl", *words, folder=tmp_path)
    assert done.returncode == 3
    assert "proven by Denier 1.0, confirmed by SCIP" in done.stderr


class _Breaks:
    """A SCIP model whose solve ends as PySCIPOpt tells of SCIP's own errors."""

    def __init__(self, model: Any) -> None:
        self._model = model

    def __getattr__(self, name: str) -> Any:
        return getattr(self._model, name)

    def optimizeNogil(self) -> None:
        raise Exception("SCIP: unspecified error!")


@pytest.fixture
def broken_scip(monkeypatch: pytest.MonkeyPatch) -> None:
    loaded = scip._loaded
    monkeypatch.setattr(scip, "_loaded", lambda model: _Breaks(loaded(model)))


@pytest.mark.usefixtures("broken_scip")
def test_a_second_solver_that_fails_confirms_nothing(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(CONFLICT)
    done = stlc("solve", "m.stl", "--strategy", "milp", "--no-explain", folder=tmp_path)
    assert done.returncode == 3
    assert "says so; SCIP failed (unspecified error!)" in done.stderr


@pytest.mark.usefixtures("broken_scip")
def test_a_solver_that_fails_is_named(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(MISSION)
    words = ("--backend", "scip", "--strategy", "milp")
    done = stlc("solve", "m.stl", *words, folder=tmp_path)
    assert done.returncode == 5
    assert "SCIP failed (unspecified error!)" in done.stderr
