"""Teams bounded and started from what each agent does alone."""

import numpy as np
import pytest

from stlc import backends
from stlc.api import loads
from stlc.backends.base import SolveOptions, Status
from stlc.ir.nodes import Link, walk
from stlc.milp.compile import Compiled, compile_mission
from stlc.mission import Mission
from stlc.record import changed
from stlc.solve import tuning
from stlc.solve.alone.effort_rows import bounded, least, lone_runs
from stlc.solve.alone.project import project
from stlc.solve.judge import Judge
from stlc.solve.strategies import LONE, NEIGHBOURHOODS, TURNS, run_strategies, run_strategy
from stlc.solve.strategy import Work

HIGHS = backends.get("highs")
EXACT = SolveOptions(gap=1e-6)

HEAD = """
horizon {steps}
workspace box [0, 6] x [0, 6]
dynamics cart = single_integrator
"""
AGENT = (
    "agent r{k} : cart {{ start ({x:g}, {y:g}); control |u| <= 1.5; effort_input (1, {w:g}) }}\n"
)
REGIONS = """
region east = box [4, 5] x [{low:g}, {high:g}]
region west = box [0.5, 1.5] x [2, 3.5]
obstacle pillar = box [2.5, 3.2] x [1.5, 3.8]
channel radio {{ path_loss L0 = -40 dBm, n = 2; fading 0 dB^2; shadowing 0 dB^2, length 1 m
  noise_floor -90 dBm; partition 3 x 3 }}
"""
COUPLINGS = (
    "require apart: always separation(r1, r2) >= 1 m",
    "require talk: always[1, 4] rssi(r1, r2) >= -50 dBm",
    "require either: (eventually r1 in west) or (eventually r2 in west)",
    "require same: always ((r1 in west) implies not (r2 in west))",
    "require chance: not (eventually[2, 4] P(rssi(r1, r2) >= -44 dBm) >= 0.5)",
    "require meet: eventually (r1 in east and r2 in east)",
    "require until: (separation(r1, r2) >= 0.5 m) until[1, 4] (r1 in east iff r2 in west)",
)
OBJECTIVES = (
    "minimize effort",
    "minimize normalised(effort)",
    "minimize 0.5 * effort(r1) + 2 * effort[1, 3]",
)


def mission(seed: int, agents: int = 2) -> Mission:
    """A random small team that is coupled by two requirements."""
    rng = np.random.default_rng(seed)
    text = HEAD.format(steps=4)
    for k in range(1, agents + 1):
        x, y = rng.uniform(0.3, 1.2), 2 * k - rng.uniform(0.3, 1)
        text += AGENT.format(k=k, x=x, y=y, w=rng.uniform(0.5, 2))
    low = rng.uniform(1, 3)
    text += REGIONS.format(low=low, high=low + rng.uniform(0.8, 2))
    for k in range(1, agents + 1):
        text += f"require reach{k}: eventually r{k} in east\n"
        text += f"require clear{k}: always r{k} outside pillar\n"
    for k in rng.choice(len(COUPLINGS), 2, replace=False):
        text += COUPLINGS[k] + "\n"
    return loads(text + OBJECTIVES[int(rng.integers(len(OBJECTIVES)))] + "\n")


SLOWER = [pytest.param(seed, marks=pytest.mark.slow) for seed in range(4, 14)]


def plain(compiled: Compiled) -> tuple[Status, float | None]:
    found = run_strategy("milp", compiled, HIGHS, EXACT)
    return found.status, found.objective


@pytest.mark.parametrize("seed", [*range(4), *SLOWER])
def test_the_strategy_has_the_optimum_of_the_plain_model(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        tuning, "BRIEF", changed(tuning.BRIEF, columns=0)
    )  # or they would be solved at once
    task = mission(seed, agents=2 + seed % 2)
    compiled = compile_mission(task)
    status, optimum = plain(compiled)
    found = run_strategy("auto", compiled, HIGHS, EXACT)
    assert found.status is status
    if optimum is None:
        return
    assert found.objective == pytest.approx(optimum, rel=1e-5)
    _, report = Judge(task, compiled).judge(found, EXACT)
    assert report.ok, report.text()


@pytest.mark.parametrize("seed", range(7))
def test_lone_runs_bound_the_optimum_and_their_rows_cut_no_plan_off(seed: int) -> None:
    compiled = compile_mission(mission(seed, agents=3))
    _, optimum = plain(compiled)
    lone = lone_runs(Work.of(compiled, HIGHS, EXACT))
    if optimum is None:
        return
    assert [one.agent for one in lone] == ["r1", "r2", "r3"]
    assert least(compiled, lone) <= optimum + 1e-6 * (1 + abs(optimum))
    tight = bounded(compiled, lone)
    assert tight.model.rows == compiled.model.rows + 3
    assert plain(tight)[1] == pytest.approx(optimum, rel=1e-5)
    root = run_strategy("milp", tight, HIGHS, SolveOptions(gap=1e-6)).bound
    assert root is not None
    assert root >= least(compiled, lone) - 1e-5


def test_a_team_that_gets_along_needs_no_solver_for_the_whole() -> None:
    text = HEAD.format(steps=4)
    text += AGENT.format(k=1, x=1, y=1, w=1) + AGENT.format(k=2, x=1, y=5, w=1)
    text += REGIONS.format(low=1, high=5) + "require a: eventually r1 in east\n"
    text += "require b: eventually r2 in east\nrequire c: always separation(r1, r2) >= 0.2 m\n"
    compiled = compile_mission(loads(text + "minimize effort"))
    found = run_strategies([LONE, NEIGHBOURHOODS], Work.of(compiled, HIGHS, SolveOptions()))
    assert found.status is Status.OPTIMAL
    assert found.solver_version.startswith("agents alone")


@pytest.mark.parametrize("agents", [2, 3])
def test_agents_in_each_others_way_are_planned_one_after_the_other(agents: int) -> None:
    ways = ((1, 3, 5), (5, 3, 1))
    text = HEAD.format(steps=4) + REGIONS.format(low=1, high=5).replace("2.5, 3.2", "2.9, 3")
    for k, y in enumerate(ways[0][:agents], start=1):
        text += AGENT.format(k=k, x=1, y=y, w=1)
        goal = f"box [4.5, 5] x [{ways[1][k - 1] - 0.2}, {ways[1][k - 1] + 0.2}]"
        text += f"region goal{k} = {goal}\nrequire reach{k}: eventually r{k} in goal{k}\n"
    text += "require apart: forall (a, b) in pairs: always separation(a, b) >= 1.5 m\n"
    compiled = compile_mission(loads(text + "minimize effort"))
    first = TURNS.run(Work.of(compiled, HIGHS, EXACT))
    assert isinstance(first, Work)
    assert first.x is not None
    work = LONE.run(first)
    assert isinstance(work, Work)
    assert work.bound < work.value
    found = NEIGHBOURHOODS.run(work)
    assert isinstance(found, Work)
    optimum = plain(compiled)[1]
    assert optimum is not None
    assert optimum - 1e-5 <= found.value <= first.value
    assert found.value <= 1.02 * optimum


def test_projection_leaves_out_what_others_are_asked() -> None:
    task = mission(1, agents=3)
    alone = project(task, ("r1",), compile_mission(task).channels)
    assert list(alone.agents) == ["r1"]
    assert {"reach1", "clear1"} <= {r.name for r in alone.requirements}
    assert not {"reach2", "clear3"} & {r.name for r in alone.requirements}
    assert not any(isinstance(n, Link) for r in alone.requirements for n in walk(r.formula))


@pytest.mark.parametrize(
    "objective", ["maximize robustness", "minimize link_cost(radio, (r1, r2))"]
)
def test_other_objectives_have_no_lone_runs(objective: str) -> None:
    task = mission(1)
    text = task.source.text.rpartition("minimize")[0] + objective
    text = text.replace("require talk", "# require talk")
    compiled = compile_mission(loads(text))
    assert not LONE.applies(Work.of(compiled, HIGHS, EXACT))
