"""First plans for teams: agents planned in turn, against runs that others are held to."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
import pytest
from support.carts import EXACT, HIGHS

from stlc.api import loads
from stlc.backends.base import SolveOptions, Status
from stlc.milp.compile import Compiled, compile_mission
from stlc.mission import Mission
from stlc.solve.alone.run import Run
from stlc.solve.deadline import Deadline
from stlc.solve.judge import Judge
from stlc.solve.mip_start import hold
from stlc.solve.strategies import TURNS, run_strategy
from stlc.solve.strategy import Work
from stlc.solve.teams.answers import Answers, Effort
from stlc.solve.teams.couplings import Couplings
from stlc.solve.teams.held import against
from stlc.solve.teams.turns import Turns
from stlc.solve.teams.whole import completed

HEAD = """
horizon 5
workspace box [0, 6] x [0, 3]
dynamics cart = single_integrator
"""
RADIO = """
channel radio { path_loss L0 = -40 dBm, n = 2; fading 0 dB^2; shadowing 0 dB^2, length 1 m
  noise_floor -90 dBm; partition 6 x 3 }
"""
COUPLINGS = (
    "require apart: forall (a, b) in pairs: always separation(a, b) >= 0.8 m",
    "require between: forall (a, b) in pairs: always separation(a, b) >= 0.5 m swept",
    "require talk: always[1, 5] (rssi(r1, r2) >= -48 dBm or rssi(r1, r3) >= -48 dBm)",
    "require chance: not (eventually[2, 4] P(rssi(r1, r2) >= -42 dBm) >= 0.5)",
    "require far: eventually[3, 5] not (rssi(r2, r3) >= -50 dBm)",
    "require meet: eventually (r1 in east and r3 in east)",
    "require either: (eventually r1 in south) or (eventually r2 in south)",
    "require lead: always (r1.ux - r2.ux <= 1.5 m/s)",
    "require until: (separation(r1, r2) >= 0.5 m) until[1, 4] (r2 in east or r3 in south)",
)
OBJECTIVES = (
    "minimize effort",
    "minimize 0.5 * effort + 0.5 * link_cost(radio)",
    "minimize normalised(effort) + normalised(link_cost(radio, (r1, r3)))",
    "",
)


def mission(seed: int) -> Mission:
    """Three agents, coupled by two random requirements."""
    rng = np.random.default_rng(seed)
    text = HEAD + RADIO
    for k in (1, 2, 3):
        x = rng.uniform(0.2, 0.8)
        text += f"agent r{k} : cart {{ start ({x:g}, {k - 0.5:g}); control |u| <= 1.6 }}\n"
    text += "region east = box [4, 6] x [0, 3]\nregion south = box [0, 4] x [0, 1]\n"
    for k in (1, 2, 3):
        text += f"require reach{k}: eventually r{k} in east\n"
    for k in rng.choice(len(COUPLINGS), 2, replace=False):
        text += COUPLINGS[int(k)] + "\n"
    return loads(text + OBJECTIVES[seed % len(OBJECTIVES)] + "\n")


def runs_of(compiled: Compiled, x: np.ndarray) -> Mapping[str, Run]:
    made = compiled.decode(x)
    return {name: (made.states[name], made.inputs[name]) for name in made.states}


@pytest.mark.parametrize("seed", range(9))
def test_what_is_found_in_turn_is_a_plan_of_the_mission(seed: int) -> None:
    task = mission(seed)
    compiled = compile_mission(task)
    work = TURNS.run(Work.of(compiled, HIGHS, EXACT))
    assert isinstance(work, Work)
    plain = run_strategy("milp", compiled, HIGHS, EXACT)
    if work.x is None:
        assert plain.status is Status.INFEASIBLE
        return
    assert plain.objective is not None
    assert work.value >= plain.objective - 1e-5 * (1 + abs(plain.objective))
    _, report = Judge(task, compiled).judge(work.answer(), EXACT)
    assert report.ok, report.text()


@pytest.mark.parametrize("seed", range(9))
def test_held_agents_leave_the_free_ones_exactly_what_the_model_does(seed: int) -> None:
    """With all others held to an optimal plan the best of one agent is worth the optimum."""
    task = mission(seed)
    compiled = compile_mission(task)
    plain = run_strategy("milp", compiled, HIGHS, EXACT)
    if plain.x is None or plain.objective is None:
        return
    runs = runs_of(compiled, plain.x)
    for name in runs:
        others = {other: run for other, run in runs.items() if other != name}
        alone = compile_mission(against(task, (name,), others, compiled.channels))
        found = HIGHS.solve(alone.model, EXACT)
        assert found.x is not None, name
        made = runs_of(alone, found.x)
        x = completed(compiled, {**others, **made}, HIGHS, EXACT)
        assert x is not None
        assert compiled.model.objective(x) == pytest.approx(plain.objective, rel=1e-4, abs=1e-4)


def test_runs_that_break_a_coupling_are_refused_by_the_lone_mission() -> None:
    """Exactly the runs that the whole model refuses."""
    task = mission(4)
    compiled = compile_mission(task)
    rng = np.random.default_rng(0)
    fates = set()
    lone = compile_mission(against(task, ("r1",), {}, compiled.channels, costs=False))
    rest = compile_mission(against(task, ("r2", "r3"), {}, compiled.channels, costs=False))
    for made in _samples(rest, rng, 6):
        held = compile_mission(against(task, ("r1",), made, compiled.channels, costs=False))
        for own in _samples(lone, rng, 4):
            model = hold(held, own, 1e-5)
            fine = model is not None and HIGHS.solve(model, EXACT).x is not None
            whole = completed(compiled, {**made, **own}, HIGHS, EXACT)
            assert fine == (whole is not None)
            fates.add(fine)
    assert fates == {True, False}


def _samples(
    compiled: Compiled, rng: np.random.Generator, count: int
) -> Iterator[Mapping[str, Run]]:
    """Runs of a mission at random corners."""
    for _ in range(count):
        model = replace(compiled.model, c=np.zeros(compiled.model.columns))
        for columns in compiled.states.values():
            model.c[columns.ravel()] = rng.normal(size=columns.size)
        x = HIGHS.solve(model, SolveOptions()).x
        assert x is not None
        yield runs_of(compiled, x)


BAY = """
horizon 8
workspace box [0, 8] x [0, 1]
dynamics cart = single_integrator
agent r1 : cart {{ start (3, 0.5); control |u| <= 1 }}
agent r2 : cart {{ start (1, 0.5); control |u| <= 1 }}
region middle = box [2.8, 4.2] x [0, 1]
region end = box [6.8, 8] x [0, 1]
require one: always[8, 8] r1 in {one}
require two: always[8, 8] r2 in {two}
require apart: always separation(r1, r2) >= 1 m swept
minimize effort
"""


def test_an_agent_that_finds_no_way_comes_first_or_is_planned_with_another() -> None:
    """r1 alone stays where it is, and leaves r2 no room behind it in the corridor."""
    task = loads(BAY.format(one="middle", two="middle").replace("[2.8, 4.2]", "[2.9, 4.1]"))
    compiled = compile_mission(task)
    work = Work.of(compiled, HIGHS, EXACT)
    answers = Answers.of(work)
    effort = Effort(Deadline(), 1e-6)
    stayed = answers.find(("r1",), {}, effort).runs
    assert stayed is not None
    blocked = answers.find(("r2",), stayed, effort)
    assert blocked.runs is None
    assert blocked.settled
    assert blocked.met == {"r1"}
    runs = Turns(answers, Deadline()).plan(["r1", "r2"])
    assert runs is not None
    x = completed(compiled, runs, HIGHS, EXACT)
    assert x is not None
    _, report = Judge(task, compiled).judge(work.with_point(x, "turns").answer(), EXACT)
    assert report.ok


def test_couplings_name_who_meets_whom() -> None:
    text = HEAD + RADIO
    for k in (1, 2, 3, 4):
        text += f"agent r{k} : cart {{ start ({k}, 1); control |u| <= 1 }}\n"
    text += "require a: always separation(r1, r2) >= 0.1 m\n"
    text += "require b: always[1, 5] rssi(r2, r3) >= -46 dBm\n"
    found = Couplings.of(compile_mission(loads(text)))
    assert found.bound["r1"] == frozenset()
    assert found.bound["r2"] == {"r3"}
    assert found.partners("r2") == {"r1", "r3"}
    assert found.partners("r4") == frozenset()
