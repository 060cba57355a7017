"""Trade-offs of effort and time against solves with deadlines."""

from __future__ import annotations

from pathlib import Path

import pytest

from stlc import api
from stlc.errors import InfeasibleError
from stlc.sweep import Question, frontier
from stlc.sweep.ask import answer

TEXT = """horizon 7
workspace box [0, 9] x [0, 4]
agent a : double_integrator {{ start (1, 1); control |u| <= 1 }}
require go: eventually[0, {end}] a.x >= 5 m
minimize {cost}
"""


@pytest.mark.parametrize("cost", ["effort", "effort + 0.1 * time(go)"])
def test_each_point_is_the_least_effort_by_its_deadline(tmp_path: Path, cost: str) -> None:
    file = tmp_path / "m.stl"
    file.write_text(TEXT.format(end=7, cost=cost))
    asked = Question(str(file), (), "")
    curve = frontier(asked, ("effort", "time(go)"), 6, lambda q, s: answer(q, s))
    assert len(curve.trades) >= 3
    seconds = [round(t.second) for t in curve.trades]
    for trade, end in zip(curve.trades, seconds, strict=True):
        assert trade.second == pytest.approx(end)
        alone = api.solve(api.loads(TEXT.format(end=end, cost="effort")))
        assert trade.first == pytest.approx(alone.plan.solve.objective, rel=2e-4)
    with pytest.raises(InfeasibleError):
        api.solve(api.loads(TEXT.format(end=seconds[0] - 1, cost="effort")))
