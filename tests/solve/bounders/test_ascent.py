"""Potentials of two agents: lists of abstract steps, the smoothed least value, the ascent."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stlc.api import load
from stlc.backends import get
from stlc.backends.base import SolveOptions
from stlc.milp.compile import compile_mission
from stlc.milp.encodings import compile_options
from stlc.solve.bounders.arcs import Arcs
from stlc.solve.bounders.ascent import ascend, shares, smoothed
from stlc.solve.bounders.cuts import best_cut
from stlc.solve.bounders.joint import Joint
from stlc.solve.bounders.pair import Search
from stlc.solve.bounders.pair_node import Node, with_cut
from stlc.solve.relaxation.recognise import recognise
from stlc.solve.restricted.frame import Frame
from stlc.solve.restricted.session import Session
from stlc.solve.strategy import Work

MISSION = Path(__file__).parents[3] / "benchmarks" / "missions" / "two_agents_t4.stl"


def _searched() -> tuple[Search, Node]:
    """A search and its root after the joint programme and the LP relaxation."""
    compiled = compile_mission(load(MISSION), compile_options("auto"))
    problem = recognise(compiled)
    assert problem is not None
    session = Session(
        Frame(compiled, problem), Work.of(compiled, get("highs"), SolveOptions(gap=1e-4))
    )
    search = Search(session)
    root = search.root()
    assert root is not None
    assert search.tools.programme(root)
    assert search.tools.relax(root)
    return search, root


def _arcs(search: Search, node: Node) -> Arcs:
    assert node.masks is not None
    return Arcs(search.bodies, node.layers, search.tools.cost, node.masks)


@pytest.fixture(scope="module")
def optimum() -> float:
    """By the plain model."""
    compiled = compile_mission(load(MISSION), compile_options("auto"))
    value = get("highs").solve(compiled.model, SolveOptions(gap=1e-6)).objective
    assert value is not None
    return value


def test_lists_and_tables_have_one_least_value() -> None:
    search, root = _searched()
    arcs = _arcs(search, root)
    joint = Joint(search.bodies, root.layers, search.tools.cost, root.masks)
    least, through = arcs.through()
    assert least == pytest.approx(joint.forward(), abs=1e-4)
    joint.backward()
    for t, (stop, values) in enumerate(zip(arcs.stops, through, strict=True)):
        np.testing.assert_allclose(values, joint.through(t)[stop.i, stop.j], atol=1e-4)
        known = np.zeros(joint.through(t).shape, bool)
        known[stop.i, stop.j] = True
        assert not np.isfinite(joint.through(t)[~known]).any()


def test_derivative_is_that_of_the_soft_minimum() -> None:
    search, root = _searched()
    arcs = _arcs(search, root)
    rng = np.random.default_rng(3)
    slopes = arcs.slopes + 0.05 * arcs.loose[:, None] * rng.normal(size=arcs.slopes.shape)
    value, slips = smoothed(arcs, slopes, 0.3)
    for _ in range(5):
        way = arcs.loose[:, None] * rng.normal(size=slopes.shape)
        ahead, back = (smoothed(arcs, slopes + h * way, 0.3)[0] for h in (1e-5, -1e-5))
        assert (ahead - back) / 2e-5 == pytest.approx(
            float((slips * way).sum()), rel=1e-3, abs=1e-4
        )
        assert min(ahead, back) <= value + 1e-9


def test_shares_add_up_to_one() -> None:
    search, root = _searched()
    arcs = _arcs(search, root)
    for stop, share in zip(arcs.stops, shares(arcs, 0.2), strict=True):
        assert len(share) == len(stop.i)
        assert share.sum() == pytest.approx(1.0)
        assert (share >= 0).all()


def test_ascent_raises_the_bound_but_not_above_the_optimum(optimum: float) -> None:
    search, root = _searched()
    arcs = _arcs(search, root)
    before = arcs.through()[0]
    for heat in (0.2, 0.02, 0.01):
        least = arcs.through()[0]
        ascend(arcs, heat, 15)
        assert arcs.through()[0] >= least
    after = arcs.through()[0]
    assert after > before + 1e-3
    assert after + search.problem.rest <= optimum + 1e-6


@pytest.mark.parametrize("seed", range(5))
def test_any_slopes_give_a_lower_bound(seed: int, optimum: float) -> None:
    search, root = _searched()
    arcs = _arcs(search, root)
    rng = np.random.default_rng(seed)
    arcs.slopes = arcs.slopes + arcs.loose[:, None] * rng.normal(size=arcs.slopes.shape)
    assert arcs.through()[0] + search.problem.rest <= optimum + 1e-6
    node = Node(-np.inf, arcs.priced(), root.taken, root.masks)
    joint = Joint(search.bodies, node.layers, search.tools.cost, node.masks)
    assert joint.forward() == pytest.approx(arcs.through()[0], abs=1e-3)


def test_a_cut_divides_the_states_of_one_step() -> None:
    search, root = _searched()
    arcs = _arcs(search, root)
    root.cut = best_cut(search.problem, arcs, 0.2, 1.0)
    assert root.cut is not None
    n, t, _, _ = root.cut
    parts = [with_cut(search.problem, root, first) for first in (True, False)]
    sizes = [len(part.layers[n][t]) for part in parts]
    assert min(sizes) > 0
    assert sum(sizes) == len(root.layers[n][t])
    bounds = []
    for part in parts:
        own = _arcs(search, part)
        bounds.append(np.inf if own.empty else own.through()[0])
    assert min(bounds) >= arcs.through()[0] - 1e-9
