"""Other people's solvers, given a model file, leaving a solution file.

HiGHS, SCIP, GLPK and two versions of CBC come in wheels, so that nothing has to be installed by
hand; a `cbc` or `glpsol` on PATH is asked too.
"""

from __future__ import annotations

import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

from stlc.backends.external import External, external
from stlc.backends.highs_session import SCHEDULER

_LIMIT = 120.0  # s

Outside = Callable[[Path, Path], None]


def _highs(model: Path, solution: Path) -> None:
    import highspy

    h = highspy.Highs()
    h.setOptionValue("output_flag", False)
    h.setOptionValue("mip_rel_gap", 1e-7)
    assert h.readModel(str(model)) == highspy.HighsStatus.kOk
    with SCHEDULER.claim(1) as threads:  # the pool is the whole process's
        h.setOptionValue("threads", threads)
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


def _glpsol(binary: str, model: Path, solution: Path) -> None:
    kind = "--lp" if model.suffix == ".lp" else "--freemps"
    words = [binary, kind, str(model), "--output", str(solution)]
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


@cache
def _commands() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="stlc-commands-")  # removed when Python ends


@cache
def glpsol() -> str:
    """GLPK's command, from the library in swiglpk's wheel (`support/glpsol.py`)."""
    command = Path(_commands().name, "glpsol")
    words = shlex.join([sys.executable, str(Path(__file__).with_name("glpsol.py"))])
    command.write_text(f'#!/bin/sh\nexec {words} "$@"\n')
    command.chmod(0o755)
    return str(command)


def bundled_cbc() -> str:
    """CBC 2.10, from PuLP's wheel."""
    from stlc.backends.pulp_cbc import bundled_cbc

    return bundled_cbc()


def _on_path() -> dict[str, str]:
    found = {name: shutil.which(name) for name in ("cbc", "glpsol")}
    return {name: path for name, path in found.items() if path is not None}


def commands() -> dict[str, External]:
    """Backends that run a command: those that wheels bring, then those on PATH."""
    brought = {
        "CBC 2.10": external("cbc", bundled_cbc()), "CBC devel": external("cbc", cbc_devel()),
        "GLPK": external("glpsol", glpsol()),
    }  # fmt: skip
    return brought | {f"{name} on PATH": external(name, path) for name, path in _on_path().items()}


def solvers() -> dict[str, Outside]:
    """By name."""
    brought: dict[str, Outside] = {
        "HiGHS": _highs, "CBC 2.10": partial(_cbc, bundled_cbc()),
        "CBC devel": partial(_cbc, cbc_devel()), "GLPK": _glpk, "SCIP": _scip,
        "GLPK's command": partial(_glpsol, glpsol()),
    }  # fmt: skip
    runs = {"cbc": _cbc, "glpsol": _glpsol}
    found = _on_path().items()
    return brought | {f"{name} on PATH": partial(runs[name], path) for name, path in found}
