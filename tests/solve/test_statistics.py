"""Sizes and the LP relaxation's bound, which takes its time from a limit."""

from __future__ import annotations

import pytest
from support.command import MISSION

from stlc.api import loads
from stlc.backends import get
from stlc.backends.base import Solution, SolveOptions
from stlc.milp.compile import compile_mission
from stlc.milp.model import Model
from stlc.solve import statistics


def test_the_relaxation_is_given_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that isn't solved by then is said to be none, with the limit; the command ends."""
    compiled = compile_mission(loads(MISSION))
    whole = statistics.Statistics.of(compiled)
    assert whole.lp_bound is not None
    assert f"LP relaxation bound {whole.lp_bound:.6g};" in whole.text()
    given: list[float | None] = []

    class Stopped:
        def solve(self, model: Model, options: SolveOptions) -> Solution:
            given.append(options.time_limit)
            return get("highs").solve(model, SolveOptions(time_limit=1e-9))

    monkeypatch.setattr(statistics, "get", lambda name: Stopped())
    assert statistics.lp_bound(compiled.model, 3.0) is None
    assert statistics.Statistics.of(compiled).lp_bound is None
    assert given == [3.0, statistics.LONGEST]
    assert (
        f"not found within {statistics.LONGEST:g} s" in statistics.Statistics(compiled, None).text()
    )
