"""Tubes, layers and steps hold every run: random ones, made by simulation, are followed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.bodies import holding, layers_of, problem_of, walks

from stlc.arrays import Floats
from stlc.solve.relaxation.problem import Body, Place
from stlc.solve.states.halved import halved
from stlc.solve.states.layers import Layer, Maker, rate_borders, with_choice
from stlc.solve.states.steps import both_ways, make_step
from stlc.solve.states.tubes import boxes_meet, tubes


@pytest.mark.parametrize("seed", range(4))
def test_tubes_hold_every_run_along_every_direction(seed: int) -> None:
    rng = np.random.default_rng(seed)
    body = problem_of(rng, steps=4).bodies[0]
    sets = tubes(body, 4)
    for walk in walks(rng, body, 4, 30):
        for number, direction in enumerate(sets.directions):
            along = np.stack([walk.p @ direction, walk.w @ direction], 1)
            for t, (p, w) in enumerate(along):
                point = np.array([[p, p, w, w]])
                assert any(boxes_meet(point, sets.sets[number][j][t])[0] for j in sets.possible), (
                    number,
                    t,
                )


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("bins", [1, 3])
def test_layers_and_steps_hold_every_run(seed: int, bins: int) -> None:
    rng = np.random.default_rng(seed)
    problem = problem_of(rng, agents=1, steps=4)
    _assert_held(rng, problem.bodies[0], layers_of(problem, bins)[0])


@pytest.mark.parametrize("seed", range(4))
def test_halved_boxes_hold_every_run(seed: int) -> None:
    """Any boxes, along the position or along the rate, and halves of halves."""
    rng = np.random.default_rng(seed)
    problem = problem_of(rng, agents=1, steps=4)
    body, row = problem.bodies[0], layers_of(problem, 1)[0]
    sets = tubes(body, 4)
    for _ in range(2):
        finer = []
        for t, layer in enumerate(row):
            x, y = (rng.integers(-1, 2, len(layer.grid(d).box)) for d in (0, 1))
            made = halved(layer, (x, y), body, sets, sets.possible, t) if t else layer
            for d, index in enumerate(("ix", "iy")):
                box = made.grid(d).box[getattr(made, index)]
                whole = layer.grid(d).box[getattr(layer, index)[made.parent]]
                assert (box[:, ::2] >= whole[:, ::2]).all()
                assert (box[:, 1::2] <= whole[:, 1::2]).all()
            finer.append(made)
        assert sum(map(len, finer)) > sum(map(len, row))
        row = finer
    _assert_held(rng, body, row)


def _assert_held(rng: np.random.Generator, body: Body, row: list[Layer]) -> None:
    """Every run is in states of all layers, and steps lead from each to the next."""
    steps = [make_step(body, t, row[t], row[t + 1]) for t in range(4)]
    for walk in walks(rng, body, 4, 30):
        at = [holding(layer, walk, t) for t, layer in enumerate(row)]
        assert all(len(states) for states in at)
        for t, step in enumerate(steps):
            reached = np.isin(step.first.source, at[t])
            middle = step.first.target[reached]
            after = step.second.target[np.isin(step.second.source, middle)]
            assert np.isin(at[t + 1], after).any(), t


def test_sweeps_are_the_least_over_all_edges() -> None:
    rng = np.random.default_rng(5)
    problem = problem_of(rng, agents=1)
    row = layers_of(problem)[0]
    half = make_step(problem.bodies[0], 1, row[1], row[2]).first
    weights, values = rng.normal(size=int(half.edge.max()) + 1), rng.normal(size=(half.sources, 2))
    onward, back = both_ways(half)
    there = np.full((half.targets, 2), np.inf)
    np.minimum.at(there, half.target, values[half.source] + weights[half.edge][:, None])
    np.testing.assert_array_equal(onward.apply(values, weights), there)
    values = rng.normal(size=(half.targets, 2))
    here = np.full((half.sources, 2), np.inf)
    np.minimum.at(here, half.source, values[half.target] + weights[half.edge][:, None])
    np.testing.assert_array_equal(back.apply(values, weights), here)


@pytest.mark.parametrize("seed", range(3))
def test_what_takes_an_alternative_stays_where_the_others_go(seed: int) -> None:
    """One of two places has to be visited; runs through the first are kept with it alone."""
    rng = np.random.default_rng(seed)
    problem = problem_of(rng, agents=1, steps=4)
    x, y = (axis.start[0] for axis in problem.bodies[0].axes)
    near = np.array([[x - 0.6, x + 0.6], [y - 0.6, y + 0.6]])
    places = (Place(0, 2, near), Place(1, 4, near + 0.2))
    body = replace(problem.bodies[0], places=places)
    problem = replace(problem, bodies=(body,))
    row = layers_of(problem, 1)[0]
    kept, index = with_choice(body, tubes(body, 4), (0,), row)
    visits = [
        walk
        for walk in walks(rng, body, 4, 60)
        if all(low <= v <= high for v, (low, high) in zip(walk.p[2], near, strict=True))
    ]
    assert visits
    for walk in visits:
        for t, layer in enumerate(kept):
            at = holding(layer, walk, t)
            assert (layer.bit[at] == int(t >= 2)).any(), t
            assert np.isin(index[t][at], np.arange(len(row[t]))).all()
    apart = Maker(problem, body, tubes(body, 4), (0, 1), _one_bin(body)).by_choice(row)
    for walk in visits:
        for t, layer in enumerate(apart[1:], start=1):
            at = holding(layer, walk, t)
            assert ((layer.x.kind[layer.ix[at]] == 0) & (layer.bit[at] == int(t >= 2))).any(), t
    alone, index = with_choice(body, tubes(body, 4), (1,), apart)
    for t, layer in enumerate(alone[1:], start=1):
        assert (apart[t].x.kind[apart[t].ix[index[t]]] == 1).all()
        assert (layer.x.kind == 1).all()


def _one_bin(body: Body) -> tuple[Floats, Floats]:
    return rate_borders(body.axes[0], 1), rate_borders(body.axes[1], 1)
