"""Small solves made by several processes, or on a cluster, and what comes of them."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from support.cluster import cluster
from support.command import inside as stlc

from stlc import backends
from stlc.api import loads
from stlc.backends.base import Solution, SolveOptions, Status
from stlc.milp.compile import Compiled, compile_mission
from stlc.plan import read_plan
from stlc.solve.crew.ask import Ask
from stlc.solve.crew.cluster import Remote
from stlc.solve.crew.crew import Crew, Job
from stlc.solve.crew.processes import Processes
from stlc.solve.deadline import Deadline
from stlc.solve.strategies import STRATEGIES, run_strategies
from stlc.solve.strategy import Work

HIGHS = backends.get("highs")
TEAM = """
horizon 5
workspace box [0, 8] x [0, 4]
dynamics cart = single_integrator { control |u| <= 2 }
agent r1 : cart { start (1, 1.2) }
agent r2 : cart { start (7, 1.5) }
agent r3 : cart { start (3.1, 0.4) }
region west = box [0, 1.5] x [0, 2]
region east = box [6.4, 8] x [0, 2]
region north = box [3, 5] x [3, 4]
require one: eventually[4, 5] r1 in east
require two: eventually[4, 5] r2 in west
require three: eventually[2, 5] r3 in north
require apart: always forall (a, b) in pairs: separation(a, b) >= 0.8 m swept
minimize effort
"""
NAMES = ("turns", "lone", "neighbourhoods", "parts")
EASY = SolveOptions(gap=0.02)  # no solve comes near its limit of time


@pytest.fixture(scope="module")
def compiled() -> Compiled:
    return compile_mission(loads(TEAM))


@pytest.fixture
def processes() -> Iterator[Processes]:
    hands = Processes(2)
    yield hands
    hands.close()


def _planned(compiled: Compiled, crew: Crew) -> Solution:
    work = Work.of(compiled, HIGHS, EASY, crew)
    return run_strategies([s for s in STRATEGIES if s.name in NAMES], work)


def _ask(compiled: Compiled) -> Ask:
    return Ask(compiled.model, HIGHS, SolveOptions(), Deadline())


def _value(compiled: Compiled) -> Job[float | None]:
    return (yield _ask(compiled)).objective


def _same(one: Solution, other: Solution) -> None:
    assert one.x is not None
    assert other.x is not None
    assert np.array_equal(one.x, other.x)
    assert one.bound == pytest.approx(other.bound, rel=1e-6)


def test_the_plan_is_the_same_whoever_makes_the_solves(
    compiled: Compiled, processes: Processes
) -> None:
    _same(_planned(compiled, Crew()), _planned(compiled, Crew(processes)))
    assert processes.born == 2


def test_a_process_that_is_killed_costs_no_answer(compiled: Compiled, processes: Processes) -> None:
    """The second job begins when the first one's order is under way, and kills who has it."""

    def killer() -> Job[float | None]:
        (pid,) = processes.pids()
        os.kill(pid, signal.SIGKILL)
        return (yield _ask(compiled)).objective

    found = Crew(processes).drive([_value(compiled), killer()])
    best = HIGHS.solve(compiled.model, SolveOptions()).objective
    assert found == [pytest.approx(best), pytest.approx(best)]
    assert processes.born == 3


def test_an_order_that_nobody_survives_is_carried_out_here(compiled: Compiled) -> None:
    class Deaf:
        """Hands that can do nothing."""

        size = 2

        def __init__(self) -> None:
            self.open: list[int] = []

        def give(self, number: int, ask: Ask) -> None:
            self.open.append(number)

        def take(self) -> list[tuple[int, Solution | None]]:
            done, self.open = self.open, []
            return [(number, None) for number in done]

        def drop(self) -> None:
            self.open = []

        def close(self) -> None:
            self.open = []

    found = Crew(Deaf()).drive([_value(compiled), _value(compiled)])
    assert found[0] is not None
    assert found[0] == found[1]


def test_who_is_asked_to_stop_leaves_what_is_under_way(
    compiled: Compiled, processes: Processes
) -> None:
    ask = Ask(compiled.model, HIGHS, SolveOptions(), Deadline(should_stop=lambda: True))

    def job() -> Job[Status]:
        return (yield ask).status

    assert Crew(processes).drive([job(), job()]) == [Status.NO_SOLUTION] * 2
    assert processes.pids() == []


def test_a_solver_that_fails_is_an_answer(compiled: Compiled, processes: Processes) -> None:
    options = SolveOptions(extra={"no_such_option": 1})

    def job() -> Job[tuple[Status, str]]:
        found = yield Ask(compiled.model, HIGHS, options, Deadline())
        return found.status, found.message

    for status, message in Crew(processes).drive([job(), job()]):
        assert status is Status.FAILED
        assert "no_such_option" in message


def test_a_cluster_that_loses_a_worker_gives_the_same_plan(
    compiled: Compiled, tmp_path: Path
) -> None:
    with cluster(tmp_path, 2) as (address, workers):
        hands = Remote(address)
        try:
            _same(_planned(compiled, Crew()), _planned(compiled, Crew(hands)))

            def killer() -> Job[float | None]:
                workers[0].kill()
                return (yield _ask(compiled)).objective

            jobs = [_value(compiled), killer(), _value(compiled), _value(compiled)]
            first, *others = Crew(hands).drive(jobs)
            assert first is not None
            assert others == [first] * 3
        finally:
            hands.close()


def test_the_command_finds_one_plan_whatever_the_number_of_threads(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(TEAM, encoding="utf-8")
    plans = []
    for words in (("--threads", "1"), ("--threads", "2")):
        done = stlc("solve", "m.stl", "-o", "p.json", *words, folder=tmp_path)
        assert done.returncode == 0, done.stderr
        plans.append(read_plan(tmp_path / "p.json"))
    for one, other in zip(*(plan.runs.values() for plan in plans), strict=True):
        assert np.array_equal(one.states, other.states)


def test_a_cluster_that_is_not_there_is_said(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(TEAM, encoding="utf-8")
    words = ("--cluster", "tcp://127.0.0.1:9")
    done = stlc("solve", "m.stl", *words, folder=tmp_path)
    assert done.returncode == 5
    assert "cannot reach the cluster at tcp://127.0.0.1:9" in done.stderr
