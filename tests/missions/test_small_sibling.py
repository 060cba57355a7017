"""The small sibling of the paper's case has one optimum across encodings and backends."""

from __future__ import annotations

from pathlib import Path

import pytest

from stlc.api import load
from stlc.milp.encodings import compile_options
from stlc.solve.driver import solve_mission
from stlc.solve.outcome import Outcome, SolveSettings

FILE = Path(__file__).parents[2] / "benchmarks" / "missions" / "two_agents_t4.stl"
OPTIMUM = 3.920807  # by all of them, gap 1e-4


def _solve(**words: str) -> Outcome:
    settings = SolveSettings(
        backend=words.get("backend", "highs"),
        compile=compile_options(words.get("encoding", "auto")),
        time_limit=300.0,
    )
    return solve_mission(load(FILE), settings)


@pytest.mark.parametrize(
    "encoding", ["auto", "literal", "literal-tight", "hull", "lifted", "logarithmic", "unary"]
)
def test_encodings_agree(encoding: str) -> None:
    outcome = _solve(encoding=encoding)
    assert outcome.report.ok
    assert outcome.plan.solve.status == "optimal"
    assert outcome.plan.solve.objective == pytest.approx(OPTIMUM, rel=2e-4)


@pytest.mark.parametrize("backend", ["highs", "mip", "pulp", "cvxpy", "scipy", "scip", "gurobi"])
def test_backends_agree(backend: str) -> None:
    outcome = _solve(backend=backend)
    assert outcome.report.ok
    assert outcome.plan.solve.objective == pytest.approx(OPTIMUM, rel=2e-4)
