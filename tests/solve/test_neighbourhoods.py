"""Better plans for teams: a few agents answer the others anew."""

from dataclasses import replace

import numpy as np
import pytest
from support.carts import CARTS, EXACT, HIGHS

from stlc.api import loads
from stlc.backends.base import SolveOptions, Status
from stlc.milp.compile import Compiled, compile_mission
from stlc.mission import Mission
from stlc.record import changed
from stlc.solve import tuning
from stlc.solve.judge import Judge
from stlc.solve.strategies import NEIGHBOURHOODS, run_strategy
from stlc.solve.strategy import Work

CROSSING = (
    CARTS
    + """
require reach1: eventually r1 in high
require reach3: eventually r3 in low
require talk: always[1, 4] (rssi(r2, r1) >= -54 dBm and rssi(r2, r3) >= -54 dBm)
"""
)
OBJECTIVES = ("minimize effort", "minimize effort + 0.5 * normalised(link_cost(radio))")


def crossing(objective: str) -> tuple[Mission, Compiled]:
    task = loads(CROSSING + objective)
    return task, compile_mission(task)


def poor(compiled: Compiled, seed: int) -> Work:
    """A solve that begins with a poor plan: one at a random corner."""
    rng = np.random.default_rng(seed)
    model = replace(compiled.model, c=np.zeros(compiled.model.columns))
    for columns in compiled.states.values():
        model.c[columns.ravel()] = rng.normal(size=columns.size)
    x = HIGHS.solve(model, SolveOptions()).x
    assert x is not None
    return Work.of(compiled, HIGHS, replace(EXACT, start=x))


@pytest.mark.parametrize("objective", OBJECTIVES)
@pytest.mark.parametrize("seed", range(2))
def test_a_poor_plan_becomes_better_and_stays_one(objective: str, seed: int) -> None:
    task, compiled = crossing(objective)
    work = poor(compiled, seed)
    found = NEIGHBOURHOODS.run(work)
    assert isinstance(found, Work)
    assert found.value < 0.9 * work.value
    optimum = run_strategy("milp", compiled, HIGHS, EXACT).objective
    assert optimum is not None
    assert optimum - 1e-5 * (1 + abs(optimum)) <= found.value
    _, report = Judge(task, compiled).judge(found.answer(), EXACT)
    assert report.ok, report.text()


def test_with_all_agents_free_at_once_the_plan_is_optimal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tuning, "NEAR", changed(tuning.NEAR, gap=0.0))
    _, compiled = crossing(OBJECTIVES[0])
    found = NEIGHBOURHOODS.run(poor(compiled, 5))
    assert isinstance(found, Work)
    optimum = run_strategy("milp", compiled, HIGHS, EXACT).objective
    assert found.value == pytest.approx(optimum, rel=1e-4)


def test_every_better_plan_is_reported() -> None:
    _, compiled = crossing(OBJECTIVES[0])
    values: list[float] = []
    work = poor(compiled, 3)
    options = replace(
        work.options,
        on_progress=lambda p: None if p.objective is None else values.append(p.objective),
    )
    found = NEIGHBOURHOODS.run(replace(work, options=options))
    assert isinstance(found, Work)
    assert values == sorted(values, reverse=True)
    assert values[-1] == pytest.approx(found.value)


def test_without_an_objective_there_is_nothing_to_better() -> None:
    _, compiled = crossing("")
    work = poor(compiled, 0)
    assert not NEIGHBOURHOODS.applies(work)
    assert run_strategy("auto", compiled, HIGHS, EXACT).status is Status.OPTIMAL
