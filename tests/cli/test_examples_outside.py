"""The examples through other people's solvers, as MPS and as LP, and back to verified plans.

`two_agents_t4` is solved by all. The two examples are too much for GLPK, CBC and (in a test's
time) SCIP: they get small siblings (the flat with 5 steps and the hall alone, the paper's case
with 7 steps on 2 x 2 cells), solved by all; and the examples' own files are read back by HiGHS,
GLPK and SCIP and compared number by number; CBC, which tells nobody what it has read, finds the
optimum of the paper's LP relaxation. HiGHS solves the flat itself; SCIP proves the paper's own
case from its MPS file and the best plan as a start, in a minute. All plans come by the commands
that a person would type: `compile`, the solver, `read-solution`, `verify`.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from support.command import inside as stlc
from support.outside import Outside, glpk_problem, scip_problem, solvers

from stlc.api import load, loads
from stlc.backends import get
from stlc.backends.base import SolveOptions
from stlc.milp.compile import compile_mission
from stlc.milp.model import Model
from stlc.milp.readers import read_solution
from stlc.milp.violations import violations
from stlc.milp.writers import safe_names, write_model
from stlc.plan import read_plan

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
FLAT, PAPER = EXAMPLES / "ble_apartment.stl", EXAMPLES / "paper_two_agents.stl"
T4 = ROOT / "benchmarks" / "missions" / "two_agents_t4.stl"


def _hall_alone() -> str:
    text = FLAT.read_text().replace("horizon 14", "horizon 5")
    return text.replace("  and eventually exists room in [bedroom, study]: robot in room)", ")")


def _four_cells() -> str:
    text = PAPER.read_text().replace("partition 10 x 10", "partition 2 x 2")
    return text.replace("horizon 8", "horizon 7").replace("eventually[0, 8]", "eventually[0, 7]")


MISSIONS: dict[str, Callable[[], str]] = {
    "two_agents_t4": T4.read_text, "hall_alone": _hall_alone, "four_cells": _four_cells,
}  # fmt: skip


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with each mission and its model, as MPS and as LP."""
    folder = tmp_path_factory.mktemp("outside")
    shutil.copytree(EXAMPLES / "data", folder / "data")
    for name, text in MISSIONS.items():
        (folder / f"{name}.stl").write_text(text())
        for kind in ("mps", "lp"):
            done = stlc("compile", f"{name}.stl", "-o", f"{name}.{kind}", folder=folder)
            assert done.returncode == 0, done.stderr
    return folder


def _brought_back(mission: Path, model: Path, solver: Outside, folder: Path) -> float:
    """The objective of the verified plan that a solver's answer becomes."""
    solution, plan = folder / "m.sol", folder / "p.json"
    solver(model, solution)
    done = stlc("read-solution", mission, solution, "-o", plan, folder=folder)
    assert done.returncode == 0, done.stderr
    done = stlc("verify", mission, plan, folder=folder)
    assert done.returncode == 0, done.stdout
    objective = read_plan(plan).solve.objective
    assert objective is not None
    return objective


@cache
def _optimum(name: str) -> float:
    """By HiGHS from arrays: no file in between."""
    model = compile_mission(loads(MISSIONS[name](), folder=EXAMPLES)).model
    value = get("highs").solve(model, SolveOptions(gap=1e-7)).objective
    assert value is not None
    return value


# The examples' own files are compared number by number below, in both formats.
FULL = os.environ.get("HYPOTHESIS_PROFILE") == "full"
FILES = [(name, kind) for name in MISSIONS for kind in ("mps", "lp")
         if FULL or kind == "mps" or name != "hall_alone"]  # fmt: skip


@pytest.mark.parametrize("solver", solvers())
@pytest.mark.parametrize(("name", "kind"), FILES)
def test_one_optimum(name: str, solver: str, kind: str, written: Path, tmp_path: Path) -> None:
    mission, model = written / f"{name}.stl", written / f"{name}.{kind}"
    found = _brought_back(mission, model, solvers()[solver], tmp_path)
    assert found == pytest.approx(_optimum(name), rel=1e-5, abs=1e-6)


@pytest.mark.parametrize(
    ("path", "expected"), [(FLAT, 0.490237), (T4, 3.920805)], ids=lambda value: str(value)[-12:]
)
def test_the_commands_bring_a_solution_back(path: Path, expected: float, tmp_path: Path) -> None:
    """The flat by HiGHS; SCIP finds the same, from MPS, in half a minute."""
    file = tmp_path / "m.lp"
    done = stlc("compile", path, "-o", file, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    found = _brought_back(path, file, solvers()["HiGHS"], tmp_path)
    assert found == pytest.approx(expected, abs=1e-6)


Columns = dict[str, tuple[float, float, float, bool]]  # cost, bounds, integer
Rows = dict[str, tuple[dict[str, float], float, float]]


def _ours(model: Model) -> tuple[Columns, Rows]:
    columns, rows = safe_names(model)
    ends = zip(
        model.c.tolist(), model.col_lower.tolist(), model.col_upper.tolist(),
        (model.integrality == 1).tolist(), strict=True,
    )  # fmt: skip
    lower, upper = model.row_lower.tolist(), model.row_upper.tolist()
    found: Rows = {}
    for i, name in enumerate(rows):
        if np.isfinite(lower[i]) or np.isfinite(upper[i]):
            part = slice(model.A.indptr[i], model.A.indptr[i + 1])
            names = (columns[j] for j in model.A.indices[part])
            terms = dict(zip(names, model.A.data[part].tolist(), strict=True))
            found[name] = (terms, lower[i], upper[i])
    return dict(zip(columns, ends, strict=True)), found


def _highs_reads(path: Path) -> tuple[Columns, Rows]:
    import highspy

    h = highspy.Highs()
    h.setOptionValue("output_flag", False)
    assert h.readModel(str(path)) == highspy.HighsStatus.kOk
    lp = h.getLp()
    m, names = lp.a_matrix_, list(lp.col_names_)
    wide = (m.value_, m.index_, m.start_)
    shape = (lp.num_row_, lp.num_col_)
    by_column = csr_matrix(wide, shape=shape[::-1]).T
    A = (by_column if int(m.format_) == 1 else csr_matrix(wide, shape=shape)).tocsr()
    whole = [int(kind) == 1 for kind in lp.integrality_]
    ends = zip(lp.col_cost_, lp.col_lower_, lp.col_upper_, whole, strict=True)
    rows: Rows = {}
    for i, name in enumerate(lp.row_names_):
        part = slice(A.indptr[i], A.indptr[i + 1])
        terms = {names[j]: v for j, v in zip(A.indices[part], A.data[part].tolist(), strict=True)}
        rows[name] = (terms, lp.row_lower_[i], lp.row_upper_[i])
    return dict(zip(names, ends, strict=True)), rows


def _glpk_reads(path: Path) -> tuple[Columns, Rows]:
    import swiglpk as g

    p = glpk_problem(path)
    n = g.glp_get_num_cols(p)
    names = [g.glp_get_col_name(p, j) for j in range(1, n + 1)]
    columns: Columns = {}
    for j, name in enumerate(names, 1):
        low, high = _ends(g.glp_get_col_type(p, j), g.glp_get_col_lb(p, j), g.glp_get_col_ub(p, j))
        whole = g.glp_get_col_kind(p, j) != g.GLP_CV
        columns[name] = (g.glp_get_obj_coef(p, j), low, high, whole)
    index, value = g.intArray(n + 1), g.doubleArray(n + 1)
    rows: Rows = {}
    for i in range(1, g.glp_get_num_rows(p) + 1):
        count = g.glp_get_mat_row(p, i, index, value)
        low, high = _ends(g.glp_get_row_type(p, i), g.glp_get_row_lb(p, i), g.glp_get_row_ub(p, i))
        terms = {names[index[k] - 1]: value[k] for k in range(1, count + 1)}
        rows[g.glp_get_row_name(p, i)] = (terms, low, high)
    g.glp_delete_prob(p)
    return columns, rows


def _ends(kind: int, low: float, high: float) -> tuple[float, float]:
    """GLPK's bound types 1 free, 2 lower, 3 upper, 4 both, 5 fixed."""
    free = float("inf")
    return (low if kind in (2, 4, 5) else -free), (low if kind == 5 else high if kind > 2 else free)


def _scip_reads(path: Path) -> tuple[Columns, Rows]:
    scip = scip_problem(path)

    def end(value: float) -> float:
        return value if abs(value) < 1e20 else float(np.copysign(np.inf, value))

    columns: Columns = {}
    for v in scip.getVars():
        whole = v.vtype() != "CONTINUOUS"
        low, high = end(v.getLbOriginal()), end(v.getUbOriginal())
        columns[v.name] = (v.getObj(), low, high, whole)
    rows: Rows = {}
    for row in scip.getConss():
        low, high = end(scip.getLhs(row)), end(scip.getRhs(row))
        rows[row.name] = (scip.getValsLinear(row), low, high)
    return columns, rows


READERS = {"HiGHS": _highs_reads, "GLPK": _glpk_reads, "SCIP": _scip_reads}


@pytest.fixture(scope="module", params=[FLAT, PAPER], ids=lambda path: path.stem)
def example(request: pytest.FixtureRequest) -> tuple[Model, Columns, Rows]:
    model = compile_mission(load(request.param)).model
    return model, *_ours(model)


@pytest.mark.parametrize("kind", ["mps", "lp"])
@pytest.mark.parametrize("reader", READERS)
def test_the_examples_are_read_number_by_number(
    example: tuple[Model, Columns, Rows], reader: str, kind: str, tmp_path: Path
) -> None:
    model, columns, rows = example
    write_model(model, tmp_path / f"m.{kind}")
    read_columns, read_rows = READERS[reader](tmp_path / f"m.{kind}")
    constant = read_columns.pop("objective.constant", (0.0, 1.0, 1.0, False))
    assert constant[:3] == (model.offset, 1.0, 1.0)
    assert read_columns == columns
    assert _joined(read_rows) == rows


def _joined(rows: Rows) -> Rows:
    """LP files hold a row with two sides as two rows."""
    found = {n: r for n, r in rows.items() if not n.endswith(".upper")}
    for name, (terms, _, high) in rows.items():
        if name.endswith(".upper"):
            own, low, _ = found[name.removesuffix(".upper")]
            assert own == terms
            found[name.removesuffix(".upper")] = (own, low, high)
    return found


@pytest.mark.parametrize("kind", ["mps", "lp"])
@pytest.mark.parametrize("solver", [name for name in solvers() if "CBC" in name])
@pytest.mark.parametrize("example", [PAPER], ids=lambda path: path.stem, indirect=True)
def test_cbc_finds_the_optimum_of_the_relaxation(
    example: tuple[Model, Columns, Rows], solver: str, kind: str, tmp_path: Path
) -> None:
    """Of the paper's case: the flat's is 0, which says little."""
    relaxed = replace(example[0], integrality=np.zeros_like(example[0].integrality))
    file, solution = tmp_path / f"m.{kind}", tmp_path / "m.sol"
    write_model(relaxed, file)
    solvers()[solver](file, solution)
    x = read_solution(solution, safe_names(relaxed)[0])
    expected = get("highs").solve(relaxed, SolveOptions()).objective
    assert relaxed.objective(x) == pytest.approx(expected, rel=1e-6, abs=1e-6)
    assert violations(relaxed, x).rows_relative < 1e-6
