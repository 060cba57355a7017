"""Cheapest runs over boxes: never above the optimum, near it, and a guide to plans."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.route_missions import boxes, optimum

from stlc.api import load
from stlc.backends import get
from stlc.backends.base import SolveOptions
from stlc.milp.compile import Compiled, compile_mission
from stlc.mission import TermKind
from stlc.record import changed
from stlc.solve import tuning
from stlc.solve.relaxation.bodies import body_of
from stlc.solve.relaxation.problem import Axis
from stlc.solve.routes import axis_boxes as axis_boxes_room
from stlc.solve.routes import box_runs
from stlc.solve.routes.axis_boxes import axis_boxes
from stlc.solve.routes.box_runs import BoxRuns
from stlc.solve.routes.box_view import View, faces_of
from stlc.solve.routes.finder import Routes
from stlc.solve.routes.progress import Progress
from stlc.solve.routes.tube import within
from stlc.solve.strategies import run_strategy

MISSION = """step 1 s
horizon {steps}
workspace box [0, 6] x [0, 6]
agent r : {agent}
station s at (0.5, 0.5)
region a = {a}
region b = {b}
obstacle rock = {rock}
channel cost {{ partition [0, 2, 3, 6] x [0, 1.5, 4, 6]; table "cost.csv"; pairs (r, s) }}
require visit: {visit}
require order: (r outside a) until r in b
require clear: always r outside rock swept
minimize 2 * link_cost(cost) + {effort} * effort
"""
CART = "double_integrator { start (2.5, 5); control |u| <= 1; speed <= 1.5 }"
PLAIN = "single_integrator { start (2.5, 5); control |u| <= 1.2 }"
PLACES = {"a": "box [4.6, 5.4] x [0.3, 1.1]", "b": "box [0.4, 1.2] x [2, 2.8]",
          "rock": "box [2.2, 3.4] x [1.5, 3]"}  # fmt: skip
STAY = "eventually[0, {last}] always[0, 1] r in a"


def mission(folder: Path, seed: int, **parts: object) -> Compiled:
    """A mission over a table of random costs, which may be negative."""
    costs = np.random.default_rng(seed).uniform(-1, 4, 9)
    text = "\n".join(",".join([f"{cost:.4f}"] * 9) for cost in costs)
    (folder / "cost.csv").write_text(text)
    (folder / "mission.stl").write_text(MISSION.format(**{"effort": 0.02, **PLACES, **parts}))
    return compile_mission(load(folder / "mission.stl"))


def runs(one: Compiled, parts: int, most: float = np.inf, coarse: BoxRuns | None = None) -> BoxRuns:
    """Over boxes of so many parts, with the progress of coarser ones."""
    agent, routes = one.mission.agents["r"], Routes.of(one, lambda: False)
    efforts = [t for t in one.mission.objective if t.kind is TermKind.EFFORT]
    body = body_of(one, agent, efforts)
    assert body is not None
    faces = faces_of(one, "r", body, routes.levels)
    formulas = ((each.formula, k) for k, each in enumerate(one.layout.encoded))
    progress = Progress.of(formulas, apart=True) if coarse is None else coarse.view.progress
    x, y = (axis_boxes(axis, f, parts) for axis, f in zip(body.axes, faces, strict=True))
    assert x is not None
    assert y is not None
    return BoxRuns(View(one, agent, body, progress, routes.levels, x, y), most, coarse)


def axes_of(one: Compiled) -> tuple[tuple[Axis, Axis], tuple[set[float], set[float]]]:
    """The axes of the agent and their faces."""
    body = body_of(one, one.mission.agents["r"], [])
    assert body is not None
    return body.axes, faces_of(one, "r", body, Routes.of(one, lambda: False).levels)


def bound(found: BoxRuns) -> float:
    value = found.bound(lambda: False)
    assert value is not None
    return value


@pytest.mark.parametrize("agent", [CART, PLAIN])
def test_bounds_rise_with_finer_boxes_up_to_the_optimum(tmp_path: Path, agent: str) -> None:
    one = mission(tmp_path, 1, steps=10, agent=agent, visit=STAY.format(last=9))
    best = optimum(one)
    found, coarse = [], None
    for parts in (1, 2, 4):
        coarse = runs(one, parts, best + 0.1, coarse)
        found.append(bound(coarse))
        coarse.look_back(best + 0.1)
        backward = min(float(p.values.min()) for p in coarse.to_go[0].values())
        assert coarse.base + backward == pytest.approx(found[-1], abs=1e-3)
    assert found == sorted(found)
    assert 0.75 * best <= found[-1] <= best + 1e-5
    assert bound(runs(one, 1, found[0] - 0.5)) == found[0] - 0.5  # none that cheap


def test_what_is_pruned_by_coarse_boxes_is_no_part_of_cheap_runs(tmp_path: Path) -> None:
    one = mission(tmp_path, 3, steps=10, agent=CART, visit=STAY.format(last=9))
    coarse = runs(one, 1, optimum(one) + 0.5)
    bound(coarse)
    coarse.look_back(coarse.most)
    alone, pruned = runs(one, 2, coarse.most), runs(one, 2, coarse.most, coarse)
    assert bound(alone) == pytest.approx(bound(pruned), abs=1e-4)
    sizes = [sum(np.isfinite(p.values).sum() for layer in r.so_far for p in layer.values())
             for r in (alone, pruned)]  # fmt: skip
    assert sizes[1] < 0.7 * sizes[0]


def test_too_many_boxes_are_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    one = mission(tmp_path, 3, steps=5, agent=CART, visit=STAY.format(last=4))
    monkeypatch.setattr(box_runs, "_MOST", 1000)
    assert runs(one, 1).bound(lambda: False) is None
    monkeypatch.setattr(axis_boxes_room, "_MOST", 20)
    (axis, _), (faces, _) = axes_of(one)
    assert axis_boxes(axis, faces, 1) is None


def test_a_plan_lies_near_the_cheapest_run(tmp_path: Path) -> None:
    one = mission(tmp_path, 2, steps=10, agent=CART, visit=STAY.format(last=9))
    found = runs(one, 2)
    bound(found)
    run = found.cheapest()
    assert run is not None
    assert (run[0, 0] <= [2.5, 5]).all()
    assert (run[1, 0] >= [2.5, 5]).all()
    near = get("highs").solve(within(one, {"r": run}, 1.0, 1), SolveOptions(gap=1e-6))
    assert near.objective is not None
    assert near.objective <= optimum(one) + 0.1 * abs(optimum(one))


@pytest.mark.slow
def test_the_strategy_answers_with_the_optimum(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tuning, "BOXES", changed(tuning.BOXES, glance=0.0))
    one = mission(tmp_path, 4, steps=10, agent=CART, visit=STAY.format(last=9))
    options = SolveOptions(time_limit=60, gap=1e-6)
    answer = run_strategy("boxes", one, get("highs"), options)
    assert answer.objective == pytest.approx(optimum(one), abs=1e-4)


VISITS = [
    "eventually[2, 4] always[0, 1] r in a", "always[0, 2] eventually[0, 3] r.y <= 4 m",
    "(eventually r in a) or always[3, 5] r.x + r.y >= 7 m",
]  # fmt: skip


@pytest.mark.parametrize("visit", VISITS)
@pytest.mark.parametrize("agent", [CART, PLAIN])
def test_no_optimum_is_below_its_bound(tmp_path: Path, visit: str, agent: str) -> None:
    for seed in (6, 7):
        draw = np.random.default_rng(seed)
        corners, sizes = draw.uniform(0.2, 3.6, 6), draw.uniform(0.4, 1.2, 6)
        places = dict(zip(("a", "b", "rock"), boxes(tuple(corners), tuple(sizes)), strict=True))
        one = mission(tmp_path, seed, steps=5, agent=agent, visit=visit, **places)
        found = get("highs").solve(one.model, SolveOptions(gap=1e-6))
        least = [bound(runs(one, parts)) for parts in (1, 3)]
        if found.objective is not None:
            assert max(least) <= found.objective + 1e-5
