"""Files: read back by other programs, they are the same model, bit for bit, with one optimum."""

import gzip
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.file_solvers import (
    cbc_file,
    glpk_file,
    glpk_solved,
    gurobi_file,
    gurobi_solution,
    highs_file,
    highs_read,
    scip_file,
    scip_solution,
)
from support.outside import bundled_cbc, cbc_devel

from stlc.backends import get
from stlc.backends.base import SolveOptions, Status
from stlc.errors import OutputError, UsageError
from stlc.milp.builder import ModelBuilder
from stlc.milp.model import Model, Origin
from stlc.milp.readers import read_solution
from stlc.milp.writers import safe_names, sidecar_path, write_model
from stlc.source import Source

INF = float("inf")


def awkward() -> Model:
    """Every kind of bound and row, awkward digits, a constant, names that formats reserve."""
    source = Source("m.stl", "require a: x\nrequire b: y\n")
    b = ModelBuilder("awkward", offset=-2.75)
    b.origin = Origin("require a", source.span(0, 12))
    x = b.add_columns("e9", (4,), [-INF, -INF, 0.1, -3], [INF, 7.3, INF, -1], cost=[0.1, 0, 1, -1])
    n = b.add_columns("free", (2,), [-4, 2], [9, INF], integer=True, cost=[1 / 3, 2])
    z = b.binary("infinity[1]", (3,), cost=[1e-7, -1.0, 0])
    f = b.add_columns("fixed", (1,), 2.5, 2.5, cost=1)
    dead = b.add_columns("binary_off", (1,), 0, 0, integer=True, cost=-5)
    b.origin = Origin("require b", source.span(13, 25))
    both = np.concatenate([x, n, z, f, dead])[None, :]
    weights = np.array([1, 1 / 3, -0.1, 1e-5, 2, 3, 1e3 / 7, -7, 1, 1, 1])
    b.add_dense_rows("subject", both, weights, -0.1, 0.3)  # 0.3 - -0.1 is not exact
    b.add_dense_rows("range", both[:, :3], [1, 2, 3], -5, 25)
    b.add_dense_rows("eq", both[:, 2:5], [1, 1, 0.5], 3, 3)
    b.add_dense_rows("low", both[:, :2], [1, -1], -8.5, INF)
    b.add_dense_rows("cap", both[:, 4:7], [1, 1, 4], -INF, 11)
    b.add_dense_rows("loose", both[:, :2], [1, 1], -INF, INF)
    b.add_rows("none", [], [], [], -1, 1, count=1)
    return b.build()


@st.composite
def models(draw: st.DrawFn) -> Model:
    """Small bounded MILPs that have a feasible point."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n, m = draw(st.integers(1, 6)), draw(st.integers(1, 5))
    b = ModelBuilder("random", offset=float(draw(st.sampled_from([0.0, 1.5, -1 / 3]))))
    x = []
    point = np.empty(n)
    for j in range(n):
        whole = bool(rng.integers(2))
        low, high = sorted(rng.integers(-5, 6, 2).tolist())
        lower = np.array([float(low)])
        x.append(b.add_columns("v", (1,), lower, high + 1, integer=whole, cost=rng.normal())[0])
        point[j] = rng.integers(low, high + 2) if whole else rng.uniform(low, high + 1)
    A = np.round(rng.normal(size=(m, n)), int(rng.integers(0, 16))) * (rng.random((m, n)) < 0.7)
    centre, slack = A @ point, rng.uniform(0, 2, (2, m))
    low = np.where(rng.random(m) < 0.3, -INF, centre - slack[0])
    high = np.where(rng.random(m) < 0.3, INF, centre + slack[1])
    b.add_dense_rows("r", np.broadcast_to(np.array(x), (m, n)), A, low, high)
    return b.build()


FORMATS = ("mps", "lp", "mps.gz", "lp.gz")


def _optimum(model: Model) -> float:
    objective = get("highs").solve(model, SolveOptions(gap=0.0)).objective
    assert objective is not None
    return objective


def _rows_by_name(model: Model) -> dict[str, tuple[dict[str, float], float, float]]:
    columns, rows = safe_names(model)
    A = model.A
    found = {}
    for i, name in enumerate(rows):
        part = slice(A.indptr[i], A.indptr[i + 1])
        terms = {columns[j]: v for j, v in zip(A.indices[part], A.data[part], strict=True)}
        found[name] = (terms, model.row_lower[i], model.row_upper[i])
    return found


@pytest.mark.parametrize("suffix", FORMATS)
def test_highs_reads_back_the_exact_model(tmp_path: Path, suffix: str) -> None:
    model = awkward()
    path = tmp_path / f"m.{suffix}"
    write_model(model, path)
    _assert_same(model, path)


@given(model=models())
def test_highs_reads_back_random_models_exactly(
    model: Model, tmp_path_factory: pytest.TempPathFactory
) -> None:
    for suffix in ("mps", "lp"):
        path = tmp_path_factory.mktemp("files") / f"m.{suffix}"
        write_model(model, path)
        _assert_same(model, path)


def _assert_same(model: Model, path: Path) -> None:
    lp = highs_read(path).getLp()
    names, rows = list(lp.col_names_), list(lp.row_names_)
    mine = safe_names(model)[0]
    place = [names.index(n) for n in mine]
    extra = set(names) - set(mine)
    assert extra <= {"objective.constant"}
    assert np.array_equal(np.array(lp.col_cost_)[place], model.c)
    assert np.array_equal(np.array(lp.col_lower_)[place], model.col_lower)
    assert np.array_equal(np.array(lp.col_upper_)[place], model.col_upper)
    kinds = list(lp.integrality_) or [0] * len(names)
    assert [int(kinds[j]) for j in place] == model.integrality.tolist()
    if model.offset:
        j = names.index("objective.constant")
        assert (lp.col_cost_[j], lp.col_lower_[j], lp.col_upper_[j]) == (model.offset, 1, 1)
    _assert_same_rows(model, lp, rows, names)


def _assert_same_rows(model: Model, lp, rows: list[str], names: list[str]) -> None:
    from scipy.sparse import csc_matrix, csr_matrix

    matrix = lp.a_matrix_
    form = csc_matrix if int(matrix.format_) == 1 else csr_matrix
    shape = (lp.num_row_, lp.num_col_)
    A = form((matrix.value_, matrix.index_, matrix.start_), shape=shape).tocsr()
    for name, (terms, low, high) in _rows_by_name(model).items():
        if np.isneginf(low) and np.isposinf(high):
            assert name not in rows
            continue
        halves = [i for i, r in enumerate(rows) if r in (name, f"{name}.upper")]
        for i in halves:
            part = slice(A.indptr[i], A.indptr[i + 1])
            read = dict(zip(A.indices[part], A.data[part], strict=True))
            assert {names[j]: v for j, v in read.items() if v} == terms
        assert max(lp.row_lower_[i] for i in halves) == low
        assert min(lp.row_upper_[i] for i in halves) == high


@pytest.mark.parametrize("suffix", ["mps", "lp"])
def test_every_reader_finds_the_same_optimum(tmp_path: Path, suffix: str) -> None:
    model = awkward()
    path = tmp_path / f"m.{suffix}"
    write_model(model, path)
    expected = _optimum(model)
    found = {
        "HiGHS": highs_file(path), "SCIP": scip_file(path), "GLPK": glpk_file(path),
        "CBC 2.10": cbc_file(bundled_cbc(), path), "CBC devel": cbc_file(cbc_devel(), path),
        "Gurobi": gurobi_file(path),
    }  # fmt: skip
    assert found == pytest.approx(dict.fromkeys(found, expected), abs=1e-6)


@given(model=models())
def test_glpk_and_scip_agree_on_random_files(
    model: Model, tmp_path_factory: pytest.TempPathFactory
) -> None:
    expected = _optimum(model)
    for suffix in ("mps", "lp"):
        path = tmp_path_factory.mktemp("files") / f"m.{suffix}"
        write_model(model, path)
        assert glpk_file(path) == pytest.approx(expected, abs=1e-5)
        assert scip_file(path) == pytest.approx(expected, abs=1e-5)


def test_solution_files_read_back(tmp_path: Path) -> None:
    import swiglpk as glpk

    model = awkward()
    path, names = tmp_path / "m.mps", safe_names(model)[0]
    write_model(model, path)
    expected = _optimum(model)
    sols = {k: tmp_path / f"{k}.sol" for k in ("highs", "scip", "cbc", "glpk_w", "glpk_o", "grb")}
    h = highs_read(path)
    h.run()
    h.writeSolution(str(sols["highs"]), 0)
    scip_solution(path, sols["scip"])
    cbc_file(bundled_cbc(), path)
    shutil.move(path.with_suffix(".cbc.sol"), sols["cbc"])
    problem = glpk_solved(path)
    glpk.glp_write_mip(problem, str(sols["glpk_w"]))
    glpk.glp_print_mip(problem, str(sols["glpk_o"]))
    gurobi_solution(path, sols["grb"])
    for kind, sol in sols.items():
        digits = 1e-4 if kind in ("glpk_o", "cbc") else 1e-6  # 6 and 8 digits
        x = read_solution(sol, names)
        assert model.objective(x) == pytest.approx(expected, abs=digits), kind
        assert _broken(model, x) <= digits * 1e6, kind


def _broken(model: Model, x: np.ndarray) -> float:
    activity = model.A @ x
    return float(np.maximum(model.row_lower - activity, activity - model.row_upper).max())


def test_compressed_files_repeat_byte_for_byte(tmp_path: Path) -> None:
    for name in ("a.mps.gz", "b.mps.gz", "c.mps"):
        write_model(awkward(), tmp_path / name)
    first = (tmp_path / "a.mps.gz").read_bytes()
    assert first == (tmp_path / "b.mps.gz").read_bytes()
    assert gzip.decompress(first) == (tmp_path / "c.mps").read_bytes()


def test_sidecar_tells_the_origin_of_each_block(tmp_path: Path) -> None:
    write_model(awkward(), tmp_path / "m.lp")
    content = json.loads(sidecar_path(tmp_path / "m.lp").read_text())
    columns = {block["block"]: block for block in content["columns"]}
    assert columns["infinity[1]"]["prefix"] == "x_infinity_1_"
    assert (columns["e9"]["file"], columns["e9"]["line"]) == ("m.stl", 1)
    assert {b["line"] for b in content["rows"]} == {2}
    assert content["constant"] == {"column": "objective.constant", "fixed_at": 1, "cost": -2.75}
    assert content["rows_left_out"] == [5]


def test_names_are_safe_and_unique() -> None:
    b = ModelBuilder()
    for name, shape in (("a", (12,)), ("a_1", ()), ("x" * 300, (2,)), ("St", ()), ("9", ())):
        b.add_columns(name, shape)
    names = safe_names(b.build())[0]
    assert len(set(names)) == len(names) == 17
    assert max(map(len, names)) <= 100
    assert all(n[0].isalpha() and n.replace("_", "a").isalnum() for n in names)
    assert not {n.lower() for n in names} & {"st", "free", "end", "inf"}


def test_other_suffixes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"\.lp, \.mps"):
        write_model(awkward(), tmp_path / "m.txt")


def test_a_full_disk_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "m.mps"
    path.write_text("old")
    full = OSError(28, "No space left on device")

    def chunks(*_: object):
        yield b"NAME"
        raise full

    monkeypatch.setitem(write_model.__globals__["_WRITERS"], ".mps", chunks)
    with pytest.raises(OutputError, match="disk is full"):
        write_model(awkward(), path, sidecar=False)
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["m.mps"]


def test_coefficients_must_be_finite(tmp_path: Path) -> None:
    b = ModelBuilder()
    b.add_columns("x", (1,), cost=float("nan"))
    with pytest.raises(OutputError, match="not finite"):
        write_model(b.build(), tmp_path / "m.mps")
    assert not (tmp_path / "m.mps").exists()


def test_a_model_without_columns_is_a_valid_file(tmp_path: Path) -> None:
    for suffix in ("mps", "lp"):
        write_model(ModelBuilder("empty", offset=2.0).build(), tmp_path / f"m.{suffix}")
        assert highs_file(tmp_path / f"m.{suffix}") == 2.0


@pytest.mark.parametrize("suffix", ["mps", "lp"])
def test_a_model_without_rows_is_a_valid_file(tmp_path: Path, suffix: str) -> None:
    b = ModelBuilder()
    b.add_columns("x", (2,), [-2, 1], [5, 3], cost=[1, 1], integer=True)
    path = tmp_path / f"m.{suffix}"
    write_model(b.build(), path)
    readers = highs_file, scip_file, glpk_file, gurobi_file
    assert [read(path) for read in readers] == pytest.approx([-1.0] * len(readers))


def test_infeasible_files_stay_infeasible(tmp_path: Path) -> None:
    b = ModelBuilder()
    x = b.add_columns("x", (2,), -9, 9, integer=True)
    b.add_dense_rows("r", x[None, :], [2, 4], 1, 1)
    from stlc.backends.external import external

    claim = external("cbc", bundled_cbc()).solve(b.build(), SolveOptions(time_limit=10))
    assert claim.status is Status.INFEASIBLE
