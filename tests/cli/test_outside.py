"""Our files through other solvers, and their solutions back to one verified plan."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from support.command import MISSION
from support.command import inside as stlc

from stlc.plan import read_plan


def _highs(model: Path, solution: Path) -> None:
    import highspy

    h = highspy.Highs()
    h.setOptionValue("output_flag", False)
    h.setOptionValue("mip_rel_gap", 1e-7)
    assert h.readModel(str(model)) == highspy.HighsStatus.kOk
    h.run()
    h.writeSolution(str(solution), 0)


def _cbc(model: Path, solution: Path) -> None:
    """The binary in PuLP's wheel: nothing has to be installed by hand."""
    from stlc.backends.pulp_cbc import bundled_cbc

    words = [bundled_cbc(), str(model), "-ratio", "1e-7", "-solve", "-solution", str(solution)]
    subprocess.run(words, check=True, capture_output=True, timeout=120, env={"PATH": ""})


def _glpk(model: Path, solution: Path) -> None:
    import swiglpk as glpk

    glpk.glp_term_out(glpk.GLP_OFF)
    problem = glpk.glp_create_prob()
    if model.suffix == ".lp":
        assert glpk.glp_read_lp(problem, None, str(model)) == 0
    else:
        assert glpk.glp_read_mps(problem, glpk.GLP_MPS_FILE, None, str(model)) == 0
    how = glpk.glp_iocp()
    glpk.glp_init_iocp(how)
    how.presolve = glpk.GLP_ON
    assert glpk.glp_intopt(problem, how) == 0
    assert glpk.glp_print_mip(problem, str(solution)) == 0
    glpk.glp_delete_prob(problem)


def _scip(model: Path, solution: Path) -> None:
    import pyscipopt

    scip = pyscipopt.Model()
    scip.hideOutput()
    scip.readProblem(str(model))
    scip.setParam("limits/gap", 1e-7)
    scip.optimize()
    scip.writeBestSol(str(solution), write_zeros=True)


SOLVERS = {"HiGHS": _highs, "CBC": _cbc, "GLPK": _glpk, "SCIP": _scip}


@pytest.mark.parametrize("kind", ["mps", "lp"])
@pytest.mark.parametrize("solver", SOLVERS)
def test_there_and_back(solver: str, kind: str, tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(MISSION)
    model, solution = tmp_path / f"m.{kind}", tmp_path / "m.sol"
    assert stlc("compile", "m.stl", "-o", model, folder=tmp_path).returncode == 0
    SOLVERS[solver](model, solution)
    done = stlc("read-solution", "m.stl", solution, "-o", "p.json", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    plan = read_plan(tmp_path / "p.json")
    assert plan.solve.objective == pytest.approx(2 / 7, abs=1e-5)
    assert stlc("verify", "m.stl", "p.json", folder=tmp_path).returncode == 0


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
