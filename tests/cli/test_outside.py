"""Our files through other solvers, and their solutions back to one verified plan."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest
from support.command import MISSION
from support.command import inside as stlc
from support.outside import glpk_problem, solvers

from stlc.backends.highs_session import SCHEDULER
from stlc.plan import read_plan


@pytest.mark.parametrize("kind", ["mps", "lp"])
@pytest.mark.parametrize("solver", solvers())
def test_there_and_back(solver: str, kind: str, tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(MISSION)
    model, solution = tmp_path / f"m.{kind}", tmp_path / "m.sol"
    assert stlc("compile", "m.stl", "-o", model, folder=tmp_path).returncode == 0
    solvers()[solver](model, solution)
    done = stlc("read-solution", "m.stl", solution, "-o", "p.json", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    plan = read_plan(tmp_path / "p.json")
    assert plan.solve.objective == pytest.approx(2 / 7, abs=1e-5)
    assert stlc("verify", "m.stl", "p.json", folder=tmp_path).returncode == 0


def test_a_solution_is_read_with_the_options_of_the_model_beside_it(tmp_path: Path) -> None:
    text = "param far = 2 m\n" + MISSION.replace("box [2, 3]", "box [far, far + 1 m]")
    (tmp_path / "m.stl").write_text(text)
    model, solution = tmp_path / "m.mps", tmp_path / "m.sol"
    done = stlc("compile", "m.stl", "-D", "far=2.5", "-o", model, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    next(iter(solvers().values()))(model, solution)
    done = stlc("read-solution", "m.stl", solution, "-o", "p.json", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    plan = read_plan(tmp_path / "p.json")
    assert plan.params == {"far": "2.5"}
    assert plan.runs["a"].states[:, 0].max() >= 2.5 - 1e-6
    (tmp_path / "m.stl").write_text(text + "# another mission\n")
    done = stlc("read-solution", "m.stl", solution, "-o", "p.json", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert read_plan(tmp_path / "p.json").params == {}


def test_backends_need_no_solver_on_the_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without a `cbc` of the system, CBC still works, and what is missing is said."""
    monkeypatch.setenv("PATH", str(tmp_path))
    assert shutil.which("cbc") is None
    (tmp_path / "m.stl").write_text(MISSION)
    for backend in ("mip", "pulp"):
        done = stlc("solve", "m.stl", "--backend", backend, "--json", folder=tmp_path)
        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)["objective"] == pytest.approx(2 / 7, abs=1e-6)
    gone = stlc("solve", "m.stl", "--backend", "external-cbc", folder=tmp_path)
    assert gone.returncode == 5
    assert "'cbc' is not on PATH" in gone.stderr
    assert os.environ["PATH"] == str(tmp_path)


@pytest.mark.parametrize("kind", ["mps", "lp"])
def test_every_style_of_solution(kind: str, tmp_path: Path) -> None:
    """Also those that have numbers for names: readers of LP number columns as they meet them."""
    import highspy
    import swiglpk as glpk

    (tmp_path / "m.stl").write_text(MISSION)
    model = tmp_path / f"m.{kind}"
    assert stlc("compile", "m.stl", "-o", model, folder=tmp_path).returncode == 0
    h = highspy.Highs()
    h.setOptionValue("output_flag", False)
    h.readModel(str(model))
    with SCHEDULER.claim(1) as threads:  # the pool is the whole process's
        h.setOptionValue("threads", threads)
        h.run()
    for style in range(5):
        h.writeSolution(str(tmp_path / f"highs{style}.sol"), style)
    problem, how = glpk_problem(model), glpk.glp_iocp()
    glpk.glp_init_iocp(how)
    how.presolve = glpk.GLP_ON
    assert glpk.glp_intopt(problem, how) == 0
    glpk.glp_print_mip(problem, str(tmp_path / "printed.sol"))
    glpk.glp_write_mip(problem, str(tmp_path / "raw.sol"))
    glpk.glp_delete_prob(problem)
    found = sorted(tmp_path.glob("*.sol"))
    assert len(found) == 7
    for solution in found:
        done = stlc("read-solution", "m.stl", solution, "-o", "p.json", folder=tmp_path)
        assert done.returncode == 0, (solution, done.stderr)
        assert read_plan(tmp_path / "p.json").solve.objective == pytest.approx(2 / 7, abs=1e-5)
