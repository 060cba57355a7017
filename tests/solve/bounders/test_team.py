"""More than two agents: bounds against the plain MILP, and a known plan followed through them."""

from __future__ import annotations

import itertools
import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from support.link_missions import Variant, assert_same_optimum, compiled_mission

from stlc import backends
from stlc.arrays import Bools, Floats
from stlc.backends.base import SolveOptions, Status
from stlc.record import changed
from stlc.solve import tuning
from stlc.solve.bounders.agreement import Agreement, no_prices
from stlc.solve.bounders.prices import sliced
from stlc.solve.bounders.shares import coarsened
from stlc.solve.bounders.team_ascent import TeamAscent
from stlc.solve.relaxation.problem import Problem
from stlc.solve.relaxation.recognise import recognise
from stlc.solve.restricted.frame import Frame
from stlc.solve.restricted.session import Session
from stlc.solve.states.layers import Layer, Maker, rate_borders, restrict
from stlc.solve.states.tubes import tubes
from stlc.solve.strategies import run_strategy
from stlc.solve.strategy import Work

FULL = os.environ.get("HYPOTHESIS_PROFILE") == "full"
VARIANTS = {
    "three": Variant(agents=3, steps=4, cells=3),
    "fine": Variant(agents=3, steps=3, cells=5),
    "four": Variant(agents=4, steps=3, cells=3),
    "single": Variant(agents=3, steps=3, cells=4, single=True),
    "station": Variant(agents=3, steps=3, cells=4, station=True),
    "until": Variant(agents=3, steps=3, cells=3, extra="a0 in west until[1, 3] a1 in east"),
}
SEEDS = range(8 if FULL else 1)


def _layers(problem: Problem, bins: int) -> list[list[Layer]]:
    out = []
    for body in problem.bodies:
        sets = tubes(body, problem.steps)
        borders = (rate_borders(body.axes[0], bins), rate_borders(body.axes[1], bins))
        out.append(Maker(problem, body, sets, sets.possible, borders).layers())
    return out


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", VARIANTS)
def test_same_optimum_as_the_plain_milp(name: str, seed: int, tmp_path: Path) -> None:
    assert_same_optimum(compiled_mission(tmp_path, seed, VARIANTS[name]))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("borders", [0, 30, 30_000])
def test_same_optimum_by_branching_alone(
    seed: int, borders: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Prices from merged cells; next to nothing goes to the solver before it is small. Borders
    are cells never, from nodes of few states on, or always."""
    small = changed(
        tuning.TEAM, coarse_cells=4 if borders < 1000 else 100, leaf_pairs=60, open_leaf_pairs=20,
        dive_pairs=60, border_states=borders, stage_rounds=3, pairs=20_000, worth_halves=0.2,
    )  # fmt: skip
    monkeypatch.setattr(tuning, "TEAM", small)
    compiled = compiled_mission(tmp_path, seed, Variant(agents=3, steps=3, cells=4))
    backend = backends.get("highs")
    plain = backend.solve(compiled.model, SolveOptions(gap=1e-6))
    found = run_strategy("links", compiled, backend, SolveOptions(gap=1e-4))
    assert found.status is plain.status is Status.OPTIMAL
    assert plain.objective is not None
    assert found.objective == pytest.approx(plain.objective, rel=2e-4)


def _agreement(problem: Problem, pool: ThreadPoolExecutor, bins: int = 1) -> Agreement:
    rows = _layers(problem, bins)
    return Agreement(problem, rows, no_prices(list(problem.pairs), rows), None, pool)


def test_sweeps_never_lower_the_bound_and_prices_add_up_to_nothing(tmp_path: Path) -> None:
    problem = recognise(compiled_mission(tmp_path, 0, VARIANTS["four"]), borders=True)
    assert problem is not None
    with ThreadPoolExecutor(2) as pool:
        agreement = _agreement(problem, pool)
        bounds = [agreement.prepare()]
        for _ in range(4):
            bounds += [agreement.forward(), agreement.backward()]
    assert all(b >= a - 1e-4 for a, b in itertools.pairwise(bounds))
    assert bounds[-1] > bounds[0] + 0.01
    for n, own in enumerate(agreement.own):
        for t in range(problem.steps + 1):
            prices = [agreement.prices.states[p][p.index(n)][t] for p in own]
            total = np.sum([p[np.isfinite(prices[0])] for p in prices], axis=0)
            assert np.abs(total).max(initial=0.0) < 1e-9


def test_bounds_by_where_an_agent_ends_are_those_without_its_other_ends(tmp_path: Path) -> None:
    problem = recognise(compiled_mission(tmp_path, 0, VARIANTS["four"]), borders=True)
    assert problem is not None
    with ThreadPoolExecutor(1) as pool:
        agreement = _agreement(problem, pool)
        agreement.prepare()
        bound, last = agreement.forward(), agreement.rows[1][-1]
        groups = np.arange(len(last)) * 3 // len(last)
        found = agreement.least_by(1, groups)
        assert found.min() == pytest.approx(bound, abs=1e-4)
        for group in range(3):
            index = [[np.arange(len(layer)) for layer in row] for row in agreement.rows]
            index[1][-1] = np.flatnonzero(groups == group)
            rows = [list(row) for row in agreement.rows]
            rows[1][-1] = restrict(last, groups == group)
            part = Agreement(problem, rows, sliced(agreement.prices, index), None, pool)
            assert found[group] == pytest.approx(part.prepare(), abs=1e-4)


def test_one_worker_or_two_find_the_same(tmp_path: Path) -> None:
    problem = recognise(compiled_mission(tmp_path, 1, VARIANTS["three"]))
    assert problem is not None
    found = []
    for workers in (1, 2):
        with ThreadPoolExecutor(workers) as pool:
            agreement = _agreement(problem, pool)
            agreement.prepare()
            agreement.forward()
            found.append(agreement.backward())
    assert found[0] == found[1]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("cells", [None, 100, 4])
def test_any_prices_and_potentials_bound_the_optimum(
    seed: int, cells: int | None, tmp_path: Path
) -> None:
    """Random ones, on the mission's cells with and without their borders, and on merged ones."""
    compiled = compiled_mission(tmp_path, seed, VARIANTS["three"])
    problem = recognise(compiled, borders=cells is None)
    optimum = backends.get("highs").solve(compiled.model, SolveOptions(gap=1e-6)).objective
    assert problem is not None
    assert optimum is not None
    rng = np.random.default_rng(seed)
    with ThreadPoolExecutor(1) as pool:
        agreement = _agreement(coarsened(problem, cells) if cells else problem, pool)
        agreement.prepare()
        for _ in range(3):
            agreement.forward()
            shape = (2, problem.steps + 1, 2, 2)
            moves = {p: 0.3 * rng.normal(size=shape) for p in agreement.pairs}
            for move in moves.values():
                move[:, [0, -1]] = 0.0
            agreement.move(moves)
            agreement.backward()
    assert agreement.bound <= optimum + 1e-6


@pytest.mark.parametrize("name", ["three", "single"])
def test_an_ascent_raises_the_bound_beyond_sweeps_and_never_above_the_optimum(
    name: str, tmp_path: Path
) -> None:
    """Prices of states add up to nothing over an agent's pairs after it, too."""
    compiled = compiled_mission(tmp_path, 0, VARIANTS[name])
    problem = recognise(compiled, borders=True)
    optimum = backends.get("highs").solve(compiled.model, SolveOptions(gap=1e-6)).objective
    assert problem is not None
    assert optimum is not None
    with ThreadPoolExecutor(1) as pool:
        agreement = _agreement(problem, pool)
        agreement.prepare()
        for _ in range(6):
            agreement.forward()
            agreement.backward()
        before = agreement.bound
        ascent = TeamAscent(agreement)
        rows, prices = ascent.taken(ascent.climb(lambda: False, optimum - before)[0])
        after = Agreement(problem, rows, prices, None, pool)
        found = after.prepare()
    assert before + 1e-3 < found <= optimum + 1e-6
    for n, own in enumerate(after.own):
        for t in range(1, problem.steps + 1):
            total = np.sum([prices.states[p][p.index(n)][t] for p in own], axis=0)
            assert np.abs(total).max(initial=0.0) < 1e-6


@pytest.mark.parametrize("seed", SEEDS)
def test_what_is_dropped_holds_no_better_plan(seed: int, tmp_path: Path) -> None:
    """With a cutoff just above the optimum, the optimal plan's states stay alive."""
    compiled = compiled_mission(tmp_path, seed, VARIANTS["three"])
    problem, backend = recognise(compiled, borders=True), backends.get("highs")
    plain = recognise(compiled)
    assert problem is not None
    assert plain is not None
    session = Session(Frame(compiled, plain), Work.of(compiled, backend, SolveOptions(gap=1e-6)))
    best = backend.solve(compiled.model, SolveOptions(gap=1e-6))
    assert best.x is not None
    session.offer(best.x)
    with ThreadPoolExecutor(1) as pool:
        agreement = _agreement(problem, pool, 2)
        before = sum(int(a.sum()) for row in agreement.alive() for a in row)
        agreement.prepare()
        for _ in range(5):
            agreement.forward(session.value + 1e-4)
            agreement.move({p: 0.05 * agreement.slopes(p) for p in agreement.pairs})
            agreement.backward()
        agreement.forward(session.value + 1e-4)
    alive = agreement.alive()
    assert sum(int(a.sum()) for row in alive for a in row) < before
    for n, row in enumerate(agreement.rows):
        for t in range(1, problem.steps + 1):
            assert (_holding(session, n, t, row[t]) & alive[n][t]).any()


def _holding(session: Session, n: int, t: int, layer: Layer) -> Bools:
    """States whose boxes hold the incumbent's position and rate."""
    assert session.x is not None
    body = session.problem.bodies[n]
    state = session.x[session.frame.compiled.states[body.name]][t]
    fine = np.ones(len(layer), bool)
    for axis, grid, index in zip(body.axes, (layer.x, layer.y), (layer.ix, layer.iy), strict=True):
        box: Floats = grid.box[index]
        fine &= (box[:, 0] <= state[axis.state] + 1e-6) & (box[:, 1] >= state[axis.state] - 1e-6)
        if axis.speed is not None:
            rate = axis.gain * state[axis.speed]
            fine &= (box[:, 2] <= rate + 1e-6) & (box[:, 3] >= rate - 1e-6)
    return fine
