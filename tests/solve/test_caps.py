"""Caps on costs: strategies that heed them find the same optimum as the plain model."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stlc.api import loads, solve
from stlc.backends import get
from stlc.backends.base import Solution, SolveOptions
from stlc.errors import NoPlanError
from stlc.milp.compile import compile_mission
from stlc.mission import Cap, Mission, ObjectiveTerm, TermKind
from stlc.sense import Sense
from stlc.solve.deadline import Deadline
from stlc.solve.events import ignore
from stlc.solve.outcome import Outcome, SolveSettings
from stlc.solve.strategies import STRATEGIES
from stlc.solve.strategy import Strategy, Work
from stlc.solve.tiers import solve_in_tiers

TEAM = """horizon 5
workspace box [0, 10] x [0, 10]
agent a : single_integrator { start (1, 1); control |u| <= 3 }
agent b : single_integrator { start (9, 1); control |u| <= 3 }
agent c : single_integrator { start (5, 9); control |u| <= 3 }
obstacle block = box [4, 6] x [3, 5]
require ab: eventually[0, 3] separation(a, b) <= 0.5 m
require bc: eventually[3, 5] separation(b, c) <= 0.5 m
require clear: always forall r in agents: r outside block
minimize 0.2 * effort(a) + 0.3 * effort(b) + 0.5 * effort(c)
"""
PAIR = """horizon 5
workspace box [0, 10] x [0, 6]
agent a : double_integrator { start (1, 1); control |u| <= 2; speed <= 3 }
agent b : double_integrator { start (9, 1); control |u| <= 2; speed <= 3 }
channel radio { path_loss L0 = -20 dBm, n = 2; fading 4 dB^2; noise_floor -60 dBm; partition 5 x 3
  bound centre; cost inv_snr; pairs (a, b) }
require ga: eventually[0, 5] a.y >= 4 m
require gb: eventually[0, 5] b.y >= 4 m
minimize 100 * link_cost(radio)
"""


LATE = """horizon 4
agent a : single_integrator { start (0, 0); control |u| <= 1 }
prefer soon priority 1 late: eventually[0, 2] a.x >= 2
require go: eventually[0, 4] a.x >= 2
minimize effort
"""


def capped(text: str, agents: tuple[str, ...], limit: float) -> Mission:
    """The mission with the effort of some agents together held at a limit."""
    term = ObjectiveTerm(TermKind.EFFORT, 1.0, agents=agents)
    mission = loads(text)
    return replace(mission, caps=(Cap("effort", (term,), limit),))


CASES = {
    "one agent": capped(TEAM, ("a",), 3.0),
    "two agents": capped(TEAM, ("a", "b"), 12.0),
    "pair": capped(PAIR, ("a", "b"), 6.0),
}


@pytest.fixture(scope="module")
def optima() -> dict[str, float]:
    """By the plain model."""
    found = {}
    for name, mission in CASES.items():
        value = solve(mission, SolveSettings(strategy="milp")).plan.solve.objective
        assert value is not None
        found[name] = value
    return found


@pytest.mark.parametrize("name", CASES)
def test_caps_bind(name: str, optima: dict[str, float]) -> None:
    free = solve(replace(CASES[name], caps=()), SolveSettings(strategy="milp"))
    assert free.plan.solve.objective is not None
    assert free.plan.solve.objective < optima[name] - 1e-3


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("strategy", [s for s in STRATEGIES if s.heeds_caps], ids=lambda s: s.name)
def test_the_same_optimum_with_every_strategy_that_heeds_them(
    name: str, strategy: Strategy, optima: dict[str, float]
) -> None:
    work = Work.of(compile_mission(CASES[name]), get("highs"), SolveOptions())
    if not strategy.applies(work):
        return  # the plain model once more
    outcome = solve(CASES[name], SolveSettings(strategy=strategy.name))
    assert outcome.report.ok  # the cap is judged by the run's own costs
    assert outcome.plan.solve.status == "optimal"
    assert outcome.plan.solve.objective == pytest.approx(optima[name], rel=2e-4)


@pytest.mark.parametrize("name", CASES)
def test_bounds_of_strategies_by_themselves_are_below_the_optimum(
    name: str, optima: dict[str, float]
) -> None:
    backend = get("highs")
    for chosen in (s for s in STRATEGIES if s.heeds_caps and s.name not in ("brief", "milp")):
        work = Work.of(compile_mission(CASES[name]), backend, SolveOptions(time_limit=20.0))
        if not chosen.applies(work):
            continue
        found = chosen.run(work)
        bound = found.bound
        value = found.objective if isinstance(found, Solution) else found.value
        assert bound is None or bound <= optima[name] * (1 + 2e-4) + 1e-6, chosen.name
        assert value is None or value >= optima[name] * (1 - 2e-4) - 1e-6, chosen.name


def test_a_tier_without_a_plan_starts_from_one_by_the_objective() -> None:
    """A stand-in for solvers: the tier finds nothing unless it has a plan to start from."""
    mission, asked = loads(LATE), []

    def stubborn(given: Mission, settings: SolveSettings, deadline: object) -> Outcome:
        kinds = {t.kind for t in given.objective}
        asked.append((kinds == {TermKind.VIOLATION}, settings.start is not None))
        if asked[-1] == (True, False):
            raise NoPlanError("not in time")
        return solve(replace(given, sense=Sense.MINIMIZE), replace(settings, time_limit=30.0))

    outcome = solve_in_tiers(mission, SolveSettings(), ignore, Deadline.after(60.0), stubborn)
    assert [pair[0] for pair in asked] == [True, False, True, False]
    assert asked[2] == (True, True)
    assert all(r.kept for r in outcome.report.preferences)
