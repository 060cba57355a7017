"""What is least over abstract runs is no more than what any run costs, whatever the prices."""

from __future__ import annotations

import numpy as np
import pytest
from support.bodies import Walk, cells, cost, effort, holding, layers_of, problem_of, walks

from stlc.arrays import Floats
from stlc.solve.bounders.agreement import Prices
from stlc.solve.bounders.arcs import Arcs
from stlc.solve.bounders.chain import Chain
from stlc.solve.bounders.cuts import along, best_cut
from stlc.solve.bounders.joint import Joint
from stlc.solve.bounders.prices import blocks, masked, prices_of_finer_cells, sliced
from stlc.solve.bounders.shares import coarsened, pair_share, stage_cost
from stlc.solve.relaxation.problem import Problem

SEEDS = range(4)


def _potentials(rng: np.random.Generator, steps: int) -> Floats:
    pi = rng.normal(size=(steps + 1, 2, 2))
    pi[[0, -1]] = 0.0
    return pi


def _stages(problem: Problem) -> list[Floats]:
    return [stage_cost(problem, t) for t in range(1, problem.steps + 1)]


def _runs(rng: np.random.Generator, problem: Problem, count: int) -> list[list[Walk]]:
    each = [walks(rng, body, problem.steps, count) for body in problem.bodies]
    return [list(runs) for runs in zip(*each, strict=True)]


def _joint(problem: Problem) -> Joint:
    first, second = layers_of(problem)
    bodies = (problem.bodies[0], problem.bodies[1])
    return Joint(bodies, (first, second), _stages(problem), None)


def _arcs(problem: Problem) -> Arcs:
    first, second = layers_of(problem)
    masks = [np.ones((len(a), len(b)), bool) for a, b in zip(first, second, strict=True)]
    bodies = (problem.bodies[0], problem.bodies[1])
    return Arcs(bodies, (first, second), _stages(problem), masks)


@pytest.mark.parametrize("seed", SEEDS)
def test_chain_is_below_every_run_under_any_potentials(seed: int) -> None:
    rng = np.random.default_rng(seed)
    problem = problem_of(rng, agents=1)
    body, row = problem.bodies[0], layers_of(problem)[0]
    chain = Chain(body, row)
    for pi in (None, _potentials(rng, problem.steps)):
        weights = chain.weights(pi)
        value = np.zeros((1, 1))
        for t in range(problem.steps):
            value = chain.onward(t, value, weights)
        for walk in walks(rng, body, problem.steps, 20):
            ends = holding(row[-1], walk, problem.steps)
            assert value[ends].min() <= effort(body, walk) + 1e-9


@pytest.mark.parametrize("seed", SEEDS)
def test_chain_is_the_same_forward_and_backward(seed: int) -> None:
    rng = np.random.default_rng(seed)
    problem = problem_of(rng, agents=1)
    chain = Chain(problem.bodies[0], layers_of(problem)[0])
    weights = chain.weights(_potentials(rng, problem.steps))
    ahead, behind = np.zeros((1, 1)), np.zeros((len(chain.layers[-1]), 1))
    for t in range(problem.steps):
        ahead = chain.onward(t, ahead, weights)
    for t in reversed(range(problem.steps)):
        behind = chain.back(t, behind, weights)
    assert ahead.min() == pytest.approx(behind.min())


@pytest.mark.parametrize("seed", SEEDS)
def test_joint_and_arcs_are_below_every_pair_of_runs(seed: int) -> None:
    rng = np.random.default_rng(seed)
    problem = problem_of(rng)
    joint, arcs = _joint(problem), _arcs(problem)
    least = joint.forward()
    assert arcs.through()[0] == pytest.approx(least, abs=1e-6)
    arcs.slopes = arcs.slopes + arcs.loose[:, None] * rng.normal(size=arcs.slopes.shape)
    priced = arcs.through()[0]
    costs = [cost(problem, runs) for runs in _runs(rng, problem, 100)]
    assert least <= min(costs) + 1e-9
    assert priced <= min(costs) + 1e-9


@pytest.mark.parametrize("seed", SEEDS)
def test_a_run_is_never_cheaper_than_its_pairs_of_states(seed: int) -> None:
    """`through` may close a pair of states: no run through it costs less than it says."""
    rng = np.random.default_rng(seed)
    problem = problem_of(rng)
    joint = _joint(problem)
    joint.forward()
    joint.backward()
    for runs in _runs(rng, problem, 30):
        value = cost(problem, runs)
        for t in range(1, problem.steps + 1):
            i, j = (holding(row[t], run, t) for row, run in zip(joint.layers, runs, strict=True))
            assert joint.through(t)[np.ix_(i, j)].min() <= value + 1e-9


def test_path_has_the_least_value_and_a_mask_closes_it() -> None:
    problem = problem_of(np.random.default_rng(0))
    joint = _joint(problem)
    least = joint.forward()
    joint.backward()
    path = joint.path()
    for t, at in enumerate(path):
        assert joint.through(t)[at] == pytest.approx(least)
    masks = [np.ones((len(a), len(b)), bool) for a, b in zip(*joint.layers, strict=True)]
    masks[2][path[2]] = False
    bodies = (problem.bodies[0], problem.bodies[1])
    closed = Joint(bodies, joint.layers, _stages(problem), masks)
    assert closed.forward() >= least - 1e-12
    closed.backward()
    assert np.isinf(closed.through(2)[path[2]])


@pytest.mark.parametrize("seed", SEEDS)
def test_shares_of_all_pairs_add_up_to_the_cost(seed: int) -> None:
    rng = np.random.default_rng(seed)
    problem = problem_of(rng, agents=3)
    shares = {pair: pair_share(problem, pair) for pair in problem.pairs}
    for runs in _runs(rng, problem, 5):
        parts = [cost(share, [runs[i], runs[j]]) for (i, j), share in shares.items()]
        assert sum(parts) == pytest.approx(cost(problem, runs))


@pytest.mark.parametrize("seed", SEEDS)
def test_merged_cells_cost_no_more(seed: int) -> None:
    rng = np.random.default_rng(seed)
    problem = problem_of(rng, cells=5)
    merged = coarsened(problem, 9)
    assert merged.cells < problem.cells
    assert coarsened(problem, problem.cells) is problem
    for runs in _runs(rng, problem, 30):
        assert cost(merged, runs) <= cost(problem, runs) + 1e-12
        for run in runs:
            np.testing.assert_array_equal(
                blocks(problem, merged)[cells(problem, run)], cells(merged, run)
            )


def test_prices_and_masks_follow_their_states() -> None:
    rng = np.random.default_rng(2)
    rows = layers_of(problem_of(rng))
    index = [[np.sort(rng.permutation(len(x))[: len(x) // 2 + 1]) for x in row] for row in rows]
    ends = tuple([rng.normal(size=len(layer)) for layer in row] for row in rows)
    made = sliced(Prices({}, {(0, 1): (ends[0], ends[1])}), index).states[0, 1]
    mask = [rng.random((len(a), len(b))) < 0.5 for a, b in zip(*rows, strict=True)]
    kept = masked({(0, 1): mask}, index)
    assert kept is not None
    assert masked(None, index) is None
    for t, (i, j) in enumerate(zip(*index, strict=True)):
        for a, k in enumerate(i):
            assert made[0][t][a] == ends[0][t][k]
            assert kept[0, 1][t][a].tolist() == [mask[t][k, m] for m in j]


def test_finer_cells_take_the_price_of_the_cell_that_holds_them() -> None:
    """All states of a merged cell have one price here, so any of them may be taken."""
    rng = np.random.default_rng(3)
    fine = problem_of(rng, cells=4)
    coarse = coarsened(fine, 4)
    rows, finer = layers_of(coarse), layers_of(fine)
    price = rng.normal(size=coarse.cells)
    ends = [[price[layer.cell] for layer in row] for row in rows]
    prices = Prices({}, {(0, 1): (ends[0], ends[1])})
    block = blocks(fine, coarse)
    made = prices_of_finer_cells(prices, rows, finer, block).states[0, 1]
    for n in (0, 1):
        for t, layer in enumerate(finer[n]):
            np.testing.assert_array_equal(made[n][t], price[block[layer.cell]])


@pytest.mark.parametrize("seed", SEEDS)
def test_a_cut_has_runs_on_both_sides_and_leaves_the_arcs_alone(seed: int) -> None:
    problem = problem_of(np.random.default_rng(seed))
    arcs = _arcs(problem)
    before, slopes = arcs.through()[0], arcs.slopes.copy()
    cut = best_cut(problem, arcs, 0.2, 1.0)
    assert cut is not None
    n, t, d, last = cut
    place = along(problem, arcs.layers[n][t].cell, d)[(arcs.stops[t].i, arcs.stops[t].j)[n]]
    assert (place <= last).any()
    assert (place > last).any()
    np.testing.assert_array_equal(arcs.slopes, slopes)
    assert arcs.through()[0] == before
