"""An infeasible claim of HiGHS is heard twice, the second time without presolve."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from support.command import MISSION
from support.command import inside as stlc

from stlc.analysis.reach import tidy
from stlc.backends.base import Backend, Solution, SolveOptions, Status
from stlc.milp.builder import ModelBuilder
from stlc.solve.strategies import solve_twice_if_infeasible


@dataclass
class Stub:
    """Says infeasible with presolve, and `second` without."""

    second: Status
    name: str = "highs"
    asked: list[dict[str, Any]] = field(default_factory=list)

    def solve(self, model: object, options: SolveOptions) -> Solution:
        self.asked.append(dict(options.extra))
        plain = options.extra.get("presolve") == "off"
        return Solution(self.second if plain else Status.INFEASIBLE, seconds=1.0)


def outcome(stub: Stub, limit: float | None = None) -> Status:
    model = ModelBuilder().build()
    options = SolveOptions(time_limit=limit)
    return solve_twice_if_infeasible(model, cast(Backend, stub), options).status


@pytest.mark.parametrize(("second", "final"), [
    (Status.OPTIMAL, Status.OPTIMAL), (Status.INFEASIBLE, Status.INFEASIBLE),
    (Status.NO_SOLUTION, Status.INFEASIBLE),
])  # fmt: skip
def test_second_answer_counts(second: Status, final: Status) -> None:
    stub = Stub(second)
    assert outcome(stub) is final
    assert stub.asked == [{}, {"presolve": "off"}]


def test_no_second_question_without_time_or_for_others() -> None:
    for stub, limit in ((Stub(Status.OPTIMAL), 0.5), (Stub(Status.OPTIMAL, "scip"), None)):
        assert outcome(stub, limit) is Status.INFEASIBLE
        assert len(stub.asked) == 1


def test_tidy_clears_dust_only() -> None:
    ends = np.array([1 + 1e-9, -3 - 2e-9, 0.25, 1 / 3, np.inf, 1 - 1e-7])
    assert tidy(ends).tolist() == [1.0, -3.0, 0.25, 1 / 3, np.inf, 1 - 1e-7]


def test_one_strategy_runs_ahead_of_milp_by_its_name(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(MISSION)
    found = stlc("solve", "m.stl", "--strategy", "lone", folder=tmp_path)
    assert found.returncode == 0
    wrong = stlc("solve", "m.stl", "--strategy", "alone", folder=tmp_path)
    assert wrong.returncode == 2
    assert "no strategy is called 'alone'" in wrong.stderr
