"""Bounds of a few agents without the others, links as polygons."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.carts import CARTS, EXACT, HIGHS

from stlc.api import loads
from stlc.ir.nodes import Linear, Link, walk
from stlc.milp.compile import compile_mission
from stlc.record import changed
from stlc.solve import tuning
from stlc.solve.alone.loosened import loosened
from stlc.solve.alone.parts import Part, Parts, bound_of
from stlc.solve.deadline import Deadline
from stlc.solve.strategies import LONE, PARTS, run_strategy
from stlc.solve.strategy import Work

TALK = (
    CARTS
    + """
station base at (0, 3)
require reach1: eventually r1 in low
require reach3: eventually r3 in high
minimize effort
require talk: """
)
TALKS = (
    "always[1, 4] (rssi(r2, r1) >= -53 dBm and rssi(r2, r3) >= -53 dBm)",
    "always[0, 2] eventually[0, 2] (rssi(r1, r2) >= -52 dBm and rssi(r2, r3) >= -52 dBm)",
    "eventually[2, 4] (rssi(r1, r3) >= -50 dBm) and always[3, 4] not (rssi(r2, base) <= -52 dBm)",
)


ABREAST = """
horizon 2
workspace box [0, 6] x [0, 6]
agent r[1..4] : single_integrator { start (1, 3); control |u| <= 2 }
require go: forall r in agents: eventually r.x >= 5 m
require apart: forall (a, b) in pairs: always[1, 2] separation(a, b) >= 0.6 m
minimize effort
"""
"""Four carts from one place: each costs 4 m/s alone, a pair 0.6 more, three 1.2 and all 2.4."""


def looked_at(talk: str) -> tuple[Work, Work]:
    """A solve that knows its agents alone, and then groups of them."""
    lone = LONE.run(Work.of(compile_mission(loads(TALK + talk)), HIGHS, EXACT))
    assert isinstance(lone, Work)
    assert PARTS.applies(lone)
    parts = PARTS.run(lone)
    assert isinstance(parts, Work)
    return lone, parts


@pytest.mark.parametrize("talk", TALKS)
def test_no_plan_costs_less_than_the_bound_and_the_rows_cut_off_none(talk: str) -> None:
    lone, parts = looked_at(talk)
    optimum = run_strategy("milp", compile_mission(loads(TALK + talk)), HIGHS, EXACT)
    assert optimum.objective is not None
    assert lone.bound <= parts.bound <= optimum.objective * (1 + 1e-6)
    again = HIGHS.solve(parts.compiled.model, EXACT)
    assert again.objective == pytest.approx(optimum.objective, rel=1e-5)


def test_agents_that_must_hear_each_other_cost_more_than_alone() -> None:
    lone, parts = looked_at(TALKS[0])
    assert parts.bound > 1.05 * lone.bound
    assert parts.compiled.model.rows > lone.compiled.model.rows


def test_a_bound_near_the_plan_is_left_to_the_solver() -> None:
    lone = LONE.run(Work.of(compile_mission(loads(TALK + TALKS[0])), HIGHS, EXACT))
    assert isinstance(lone, Work)
    best = HIGHS.solve(lone.compiled.model, EXACT)
    known = lone.with_point(best.x, "milp")
    assert PARTS.applies(known)
    assert not PARTS.applies(known.with_bound(0.995 * known.value))


@pytest.mark.parametrize(("gain", "sizes"), [(0.4, {2, 3}), (0.6, {2})])
def test_larger_groups_are_tried_where_smaller_ones_close_much_of_the_gap(
    gain: float, sizes: set[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tuning, "PARTS", changed(tuning.PARTS, gain=gain))
    compiled = compile_mission(loads(ABREAST))
    best = HIGHS.solve(compiled.model, EXACT)
    lone = LONE.run(Work.of(compiled, HIGHS, EXACT).with_point(best.x, "milp"))
    assert isinstance(lone, Work)
    assert PARTS.applies(lone)
    parts = Parts.of(lone, Deadline.after(None))
    assert parts.run().bound == pytest.approx(17.6 if 3 in sizes else 17.2, abs=1e-3)
    assert {len(part.agents) for part in parts.found} == {1} | sizes


def test_bounds_are_reported() -> None:
    seen: list[float] = []
    lone, _ = looked_at(TALKS[0])
    told = replace(
        lone.options, on_progress=lambda p: None if p.bound is None else seen.append(p.bound)
    )
    parts = PARTS.run(replace(lone, options=told))
    assert isinstance(parts, Work)
    assert seen[-1] == parts.bound


def test_bounds_of_overlapping_groups_are_put_together_by_the_best_weights() -> None:
    single = [Part((name,), 1.0) for name in "abc"]
    pairs = [Part(("a", "b"), 3.0), Part(("b", "c"), 3.0), Part(("a", "c"), 3.0)]
    assert bound_of(single, "abc") == pytest.approx(3.0)
    assert bound_of(single + pairs[:1], "abc") == pytest.approx(4.0)
    assert bound_of(single + pairs, "abc") == pytest.approx(4.5)


@pytest.mark.parametrize("talk", TALKS)
def test_wherever_a_link_is_good_the_polygon_holds(talk: str) -> None:
    mission = loads(TALK + talk)
    compiled = compile_mission(mission)
    loose = loosened(mission, compiled.channels)
    assert not any(isinstance(n, Link) for r in loose.requirements for n in walk(r.formula))
    link = next(n for r in mission.requirements for n in walk(r.formula) if isinstance(n, Link))
    sides = [
        n
        for r in loose.requirements
        for n in walk(r.formula)
        if isinstance(n, Linear)
        and {s.owner for s, _ in n.terms} == {link.sender, link.receiver}
        and r.name == "talk"
    ]
    assert sides
    partition, rng = mission.channels["radio"].partition, np.random.default_rng(0)
    good = np.argwhere(compiled.channels.thresholds(link).low >= 0)
    low, high = partition.low, partition.high
    for i, j in good[rng.permutation(len(good))[:200]]:
        places = {
            link.sender: rng.uniform(low[i], high[i]),
            link.receiver: rng.uniform(low[j], high[j]),
        }
        for side in sides:
            value = sum(v * places[s.owner][s.index] for s, v in side.terms)
            assert value + side.constant >= 0


SPACE = """horizon 6
workspace box [0, 20] x [0, 20]
dynamics drone = double_integrator { dimensions 3; pz in [0, 30]; control |u| <= 2; speed <= 4 }
agent a : drone { start (2, 10, 12) }
agent b : drone { start (2, 6, 12) }
agent cart : single_integrator { start (10, 2); control |u| <= 3; antenna 1 m }
station mast at (10, 10) { height 4 m }
channel radio { path_loss L0 = -40 dBm, n = 3; partition 5 x 5 x 3 }
minimize effort
require talk: eventually[2, 4] """


BOTH_FLY = pytest.param("a, b", marks=pytest.mark.slow)


@pytest.mark.parametrize("ends", [BOTH_FLY, "a, cart", "cart, b", "a, mast", "cart, mast"])
def test_the_polygon_of_a_link_in_space(ends: str) -> None:
    """Around in the plane; up and down too where all that move fly."""
    mission = loads(f"{SPACE}rssi({ends}) >= -72 dBm\n")
    compiled = compile_mission(mission)
    loose = loosened(mission, compiled.channels)
    link = next(n for r in mission.requirements for n in walk(r.formula) if isinstance(n, Link))
    moving = [n for n in (link.sender, link.receiver) if n in mission.agents]
    sides = [n for r in loose.requirements for n in walk(r.formula) if isinstance(n, Linear)]
    assert {s.owner for side in sides for s, _ in side.terms} == set(moving)
    flying = {s.owner for side in sides for s, _ in side.terms if s.index == 2}
    assert flying == (set() if "cart" in moving else set(moving))
    partition, rng = mission.channels["radio"].partition, np.random.default_rng(0)
    good = np.argwhere(compiled.channels.thresholds(link).low >= 0)
    for cells in good[rng.permutation(len(good))[:100]]:
        drawn = [rng.uniform(partition.low[k], partition.high[k]) for k in cells]
        places = dict(zip(moving, drawn, strict=True))
        for side in sides:
            value = sum(v * places[s.owner][s.index] for s, v in side.terms)
            assert value + side.constant >= 0
