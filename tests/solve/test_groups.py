"""Agents that have nothing to do with each other are planned apart."""

from collections.abc import Sequence

import numpy as np
import pytest

from stlc import backends
from stlc.api import loads
from stlc.backends.base import SolveOptions, Status
from stlc.milp.compile import Compiled, compile_mission
from stlc.solve.judge import Judge
from stlc.solve.strategies import GROUPS, run_strategies, run_strategy
from stlc.solve.strategy import Work
from stlc.solve.teams.couplings import groups_of

HIGHS = backends.get("highs")
EXACT = SolveOptions(gap=1e-6)

HEAD = """
horizon 4
workspace box [0, 6] x [0, 6]
dynamics cart = single_integrator
region east = box [4, 6] x [0, 6]
channel radio { path_loss L0 = -40 dBm, n = 2; fading 0 dB^2; shadowing 0 dB^2, length 1 m
  noise_floor -90 dBm; partition 3 x 3 }
station base at (1, 5)
"""
OBJECTIVES = (
    "minimize effort",
    "minimize effort + normalised(link_cost(radio, (r1, r2))) + link_cost(radio, (r3, base))",
    "minimize 2 * effort(r1) + normalised(effort)",
    "",
)


def team(seed: int, requirements: Sequence[str] = (), objective: str = OBJECTIVES[0]) -> str:
    rng = np.random.default_rng(seed)
    text = HEAD
    for k in (1, 2, 3, 4):
        x, y = rng.uniform(0.2, 1.5), rng.uniform(0.2, 5.8)
        text += f"agent r{k} : cart {{ start ({x:g}, {y:g}); control |u| <= 1.6 }}\n"
        text += f"require reach{k}: eventually r{k} in east\n"
    return text + "\n".join([*requirements, objective]) + "\n"


PAIRS = (
    "require apart12: always[1, 4] separation(r1, r2) >= 1 m",
    "require talk34: always[2, 4] rssi(r3, r4) >= -50 dBm",
)


def compiled_of(text: str) -> Compiled:
    return compile_mission(loads(text))


@pytest.mark.parametrize(
    ("requirements", "objective", "groups"),
    [
        (PAIRS, OBJECTIVES[0], [("r1", "r2"), ("r3", "r4")]),
        ((), OBJECTIVES[0], [("r1",), ("r2",), ("r3",), ("r4",)]),
        ((), OBJECTIVES[1], [("r1", "r2"), ("r3",), ("r4",)]),
        (PAIRS[:1], OBJECTIVES[3], [("r1", "r2"), ("r3",), ("r4",)]),
        (
            ("require one: (eventually r1 in east) and (eventually (r2 in east or r4 in east))",),
            OBJECTIVES[0],
            [("r1",), ("r2", "r4"), ("r3",)],
        ),
        ((), "maximize robustness", [("r1", "r2", "r3", "r4")]),
    ],
)
def test_groups_share_no_conjunct_and_no_cost(
    requirements: Sequence[str], objective: str, groups: list[tuple[str, ...]]
) -> None:
    text = team(0, requirements, objective)
    if "one" in "".join(requirements):
        text = text.replace("require reach2: eventually r2 in east\n", "")
        text = text.replace("require reach4: eventually r4 in east\n", "")
    assert groups_of(compiled_of(text)) == groups


@pytest.mark.parametrize("objective", OBJECTIVES)
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_solved_apart_the_optimum_is_that_of_the_whole(seed: int, objective: str) -> None:
    task = loads(team(seed, PAIRS, objective))
    compiled = compile_mission(task)
    plain = run_strategy("milp", compiled, HIGHS, EXACT)
    work = Work.of(compiled, HIGHS, EXACT)
    assert GROUPS.applies(work)
    found = run_strategies([GROUPS], work)
    assert found.status in (Status.OPTIMAL, Status.FEASIBLE)
    assert plain.objective is not None
    assert found.objective == pytest.approx(plain.objective, rel=1e-5, abs=1e-6)
    assert found.bound is not None
    assert plain.objective - 1e-4 <= found.bound <= plain.objective + 1e-6
    _, report = Judge(task, compiled).judge(found, EXACT)
    assert report.ok, report.text()


def test_a_group_without_a_plan_leaves_the_team_without_one() -> None:
    """Three agents are to stand apart where there is room for two."""
    hemmed = ["region nook = box [4, 5] x [2, 2.4]"]
    hemmed += [f"require in{k}: always[4, 4] r{k} in nook" for k in (1, 2, 3)]
    hemmed += [
        f"require apart{a}{b}: always[4, 4] separation(r{a}, r{b}) >= 0.6 m"
        for a, b in ((1, 2), (1, 3), (2, 3))
    ]
    compiled = compiled_of(team(1, hemmed))
    found = run_strategies([GROUPS], Work.of(compiled, HIGHS, EXACT))
    assert found.status is run_strategy("milp", compiled, HIGHS, EXACT).status
    assert found.status is Status.INFEASIBLE


def test_one_group_is_left_to_the_others() -> None:
    link = "require link: always[1, 4] separation(r2, r3) >= 0.1 m"
    work = Work.of(compiled_of(team(0, [*PAIRS, link])), HIGHS, EXACT)
    assert not GROUPS.applies(work)
