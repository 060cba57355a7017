"""Other people's solvers, given a model file, leaving a solution file.

HiGHS, SCIP, GLPK and two versions of CBC come in wheels, so that nothing has to be installed by
hand; a `cbc` or `glpsol` on PATH is asked too.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

_LIMIT = 120.0  # s

Outside = Callable[[Path, Path], None]


def _highs(model: Path, solution: Path) -> None:
    import highspy

    h = highspy.Highs()
    h.setOptionValue("output_flag", False)
    h.setOptionValue("mip_rel_gap", 1e-7)
    assert h.readModel(str(model)) == highspy.HighsStatus.kOk
    h.run()
    h.writeSolution(str(solution), 0)


def _cbc(binary: str, model: Path, solution: Path) -> None:
    words = [binary, str(model), "-ratio", "1e-7", "-solve", "-solution", str(solution)]
    subprocess.run(words, check=True, capture_output=True, timeout=_LIMIT, env={"PATH": ""})


def glpk_problem(model: Path) -> Any:
    """The file as GLPK reads it."""
    import swiglpk as glpk

    glpk.glp_term_out(glpk.GLP_OFF)
    problem = glpk.glp_create_prob()
    if model.suffix == ".lp":
        assert glpk.glp_read_lp(problem, None, str(model)) == 0
    else:
        assert glpk.glp_read_mps(problem, glpk.GLP_MPS_FILE, None, str(model)) == 0
    return problem


def _glpk(model: Path, solution: Path) -> None:
    import swiglpk as glpk

    problem, how = glpk_problem(model), glpk.glp_iocp()
    glpk.glp_init_iocp(how)
    how.presolve = glpk.GLP_ON
    assert glpk.glp_intopt(problem, how) == 0
    assert glpk.glp_print_mip(problem, str(solution)) == 0
    glpk.glp_delete_prob(problem)


def _glpsol(model: Path, solution: Path) -> None:
    kind = "--lp" if model.suffix == ".lp" else "--freemps"
    words = ["glpsol", kind, str(model), "--output", str(solution)]
    subprocess.run(words, check=True, capture_output=True, timeout=_LIMIT)


def scip_problem(model: Path) -> Any:
    """The file as SCIP reads it, without the presolve step that loses integrality (`scip.py`)."""
    import pyscipopt

    scip = pyscipopt.Model()
    scip.hideOutput()
    scip.readProblem(str(model))
    scip.setParam("presolving/donotmultaggr", True)
    return scip


def _scip(model: Path, solution: Path) -> None:
    scip = scip_problem(model)
    scip.setParam("limits/gap", 1e-7)
    scip.optimize()
    scip.writeBestSol(str(solution), write_zeros=True)


def cbc_devel() -> str:
    """CBC's development version, from python-mip's wheel."""
    import cbcbox

    return str(Path(cbcbox.cbc_dist_dir()) / "bin" / "cbc")


def solvers() -> dict[str, Outside]:
    """By name."""
    from stlc.backends.pulp_cbc import bundled_cbc

    found: dict[str, Outside] = {
        "HiGHS": _highs, "CBC 2.10": partial(_cbc, bundled_cbc()),
        "CBC devel": partial(_cbc, cbc_devel()), "GLPK": _glpk, "SCIP": _scip,
    }  # fmt: skip
    if (path := shutil.which("cbc")) is not None:
        found["CBC on PATH"] = partial(_cbc, path)
    if shutil.which("glpsol") is not None:
        found["glpsol on PATH"] = _glpsol
    return found
