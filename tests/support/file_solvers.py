"""Other programs that read, solve and answer a model file."""

import subprocess
from pathlib import Path


def highs_read(path: Path):
    """HiGHS with the file in it."""
    import highspy

    h = highspy.Highs()
    h.setOptionValue("output_flag", False)
    assert h.readModel(str(path)) == highspy.HighsStatus.kOk
    return h


def highs_file(path: Path) -> float:
    """The optimum that HiGHS finds."""
    h = highs_read(path)
    h.setOptionValue("mip_rel_gap", 0.0)
    h.run()
    return float(h.getInfo().objective_function_value)


def scip_file(path: Path) -> float:
    """The optimum that SCIP finds."""
    import pyscipopt

    scip = pyscipopt.Model()
    scip.hideOutput()
    scip.readProblem(str(path))
    scip.optimize()
    return float(scip.getObjVal())


def gurobi_file(path: Path) -> float:
    """The optimum that Gurobi finds."""
    import gurobipy

    with gurobipy.Env(params={"OutputFlag": 0}) as env, gurobipy.read(str(path), env) as grb:
        grb.optimize()
        return float(grb.ObjVal)


def glpk_problem(path: Path):
    """The file as GLPK reads it."""
    import swiglpk as glpk

    glpk.glp_term_out(glpk.GLP_OFF)
    problem = glpk.glp_create_prob()
    if path.suffix == ".mps":
        failed = glpk.glp_read_mps(problem, glpk.GLP_MPS_FILE, None, str(path))
    else:
        failed = glpk.glp_read_lp(problem, None, str(path))
    assert failed == 0
    return problem


def glpk_solved(path: Path):
    """The file as GLPK has solved it."""
    import swiglpk as glpk

    problem = glpk_problem(path)
    settings = glpk.glp_iocp()
    glpk.glp_init_iocp(settings)
    settings.presolve = glpk.GLP_ON
    assert glpk.glp_intopt(problem, settings) == 0
    return problem


def glpk_file(path: Path) -> float:
    """The optimum that GLPK finds."""
    import swiglpk as glpk

    return float(glpk.glp_mip_obj_val(glpk_solved(path)))


def cbc_file(binary: str, path: Path) -> float:
    """The optimum that CBC finds; its solution is in `PATH.cbc.sol`."""
    out = path.with_suffix(".cbc.sol")
    command = [binary, str(path), "-ratio", "0", "-solve", "-solution", str(out)]
    subprocess.run(command, check=True, capture_output=True, timeout=60)
    return float(out.read_text().split("\n")[0].split()[-1])


def scip_solution(path: Path, sol: Path) -> None:
    """Writes SCIP's best point to `sol`."""
    import pyscipopt

    scip = pyscipopt.Model()
    scip.hideOutput()
    scip.readProblem(str(path))
    scip.optimize()
    scip.writeBestSol(str(sol))


def gurobi_solution(path: Path, sol: Path) -> None:
    """Writes Gurobi's best point to `sol`."""
    import gurobipy

    with gurobipy.Env(params={"OutputFlag": 0}) as env, gurobipy.read(str(path), env) as grb:
        grb.optimize()
        grb.write(str(sol))
