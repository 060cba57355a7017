"""Teams of three against every run that there is, and starts that were kept from elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pytest
from support.command import inside as stlc

from stlc import backends
from stlc.api import load, loads
from stlc.backends.base import SolveOptions, Status
from stlc.milp.compile import compile_mission
from stlc.plan import read_plan
from stlc.solve.strategies import STRATEGIES, run_strategies
from stlc.solve.strategy import Work
from stlc.verify import verify

STEPS = 3
GOALS = {"a": (3.0, 1.0), "b": (0.0, 1.0), "c": (2.0, 3.0)}
STARTS = {"a": (0.0, 1.0), "b": (3.0, 1.0), "c": (2.0, 0.0)}
MISSION = """
horizon 3
workspace box [0, 3] x [0, 3]
dynamics cart = single_integrator {{ ux in [-2, 2]; uy in [-2, 2]; integer }}
{agents}
{goals}
require apart: always forall (a, b) in pairs: separation(a, b) >= {apart} m
{more}
minimize effort
"""
MORE = (
    "",
    "require near: always[1, 2] norm1(a.x - c.x, a.y - c.y) <= 2 m",
    "require order: (b.y <= 0 m or b.x >= 3 m) until[2, 2] c.y >= 2 m",
)

Points = tuple[tuple[float, float], ...]


def text(apart: int, more: str) -> str:
    agents = [f"agent {n} : cart {{ start ({x:g}, {y:g}) }}" for n, (x, y) in STARTS.items()]
    goals = [
        f"require {n}: eventually[3] ({n}.x == {x:g} m and {n}.y == {y:g} m)"
        for n, (x, y) in GOALS.items()
    ]
    return MISSION.format(agents="\n".join(agents), goals="\n".join(goals), apart=apart, more=more)


def runs(name: str) -> Iterator[tuple[float, Points]]:
    """Every run of an agent to its goal, with what it spends."""
    moves = [np.array(move) for move in product(range(-2, 3), repeat=2)]
    for chosen in product(moves, repeat=STEPS):
        points = np.cumsum([STARTS[name], *chosen], axis=0)
        if (points >= 0).all() and (points <= 3).all() and tuple(points[-1]) == GOALS[name]:
            yield float(np.abs(chosen).sum()), tuple(map(tuple, points))


def _apart(one: Points, other: Points, least: float) -> bool:
    return all(
        max(abs(p[0] - q[0]), abs(p[1] - q[1])) >= least for p, q in zip(one, other, strict=True)
    )


def _more(which: int, a: Points, b: Points, c: Points) -> bool:
    """What the further requirement asks, read off its text by hand."""
    if which == 1:
        return all(abs(a[t][0] - c[t][0]) + abs(a[t][1] - c[t][1]) <= 2 for t in (1, 2))
    if which == 2:
        return c[2][1] >= 2 and all(b[t][1] <= 0 or b[t][0] >= 3 for t in range(3))
    return True


def oracle(apart: int, which: int) -> float:
    """The least that any three runs spend; infinite where none get along."""
    known = {name: sorted(runs(name)) for name in STARTS}
    best = np.inf
    for cost_a, a in known["a"]:
        for cost_b, b in known["b"]:
            if cost_a + cost_b >= best or not _apart(a, b, apart):
                continue
            for cost_c, c in known["c"]:
                if cost_a + cost_b + cost_c >= best:
                    break
                if _apart(a, c, apart) and _apart(b, c, apart) and _more(which, a, b, c):
                    best = cost_a + cost_b + cost_c
    return best


@pytest.mark.parametrize(("apart", "which"), [*product((1,), range(3))])
def test_three_agents_spend_what_the_best_of_all_runs_spends(apart: int, which: int) -> None:
    compiled = compile_mission(loads(text(apart, MORE[which])))
    work = Work.of(compiled, backends.get("highs"), SolveOptions(gap=1e-6))
    found = run_strategies([s for s in STRATEGIES if s.name != "brief"], work)
    best = oracle(apart, which)
    assert np.isfinite(best)
    assert found.status is Status.OPTIMAL
    assert found.objective == pytest.approx(best, abs=1e-4)
    made = compiled.decode(found.x).states
    points = {n: tuple(tuple(np.round(p)) for p in made[n]) for n in STARTS}
    assert all(_apart(points[n], points[m], apart) for n, m in combinations(STARTS, 2))


def test_some_of_these_missions_have_plans_and_their_costs_differ() -> None:
    """Else the oracle would say little."""
    costs = {oracle(apart, which) for apart, which in product((1,), range(3))}
    assert len([c for c in costs if np.isfinite(c)]) >= 2


def test_a_start_from_elsewhere_becomes_a_better_plan(tmp_path: Path) -> None:
    """A plan of detours, written by hand, is taken as it is and bettered."""
    (tmp_path / "m.stl").write_text(text(1, ""), encoding="utf-8")
    (tmp_path / "dear.stl").write_text(
        text(1, "require detour: eventually[1, 2] (a.y >= 3 m and c.x <= 0 m)"), encoding="utf-8"
    )
    done = stlc("solve", "dear.stl", "-o", "s.json", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    words = ("--start", "s.json", "--strategy", "neighbourhoods", "-o", "p.json", "--gap", "1e-6")
    done = stlc("solve", "m.stl", *words, "--progress", "ndjson", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "no plan for this mission" not in done.stderr
    start, plan = (read_plan(tmp_path / name) for name in ("s.json", "p.json"))
    assert start.solve.objective is not None
    assert plan.solve.objective == pytest.approx(oracle(1, 0), abs=1e-4)
    assert plan.solve.objective < start.solve.objective - 0.5
    assert verify(load(tmp_path / "m.stl"), plan).ok
