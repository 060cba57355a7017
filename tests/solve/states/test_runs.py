"""Tubes, layers and steps hold every run: random ones, made by simulation, are followed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.bodies import holding, layers_of, problem_of, walks

from stlc.solve.relaxation.problem import Place
from stlc.solve.states.layers import with_choice
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
    body, row = problem.bodies[0], layers_of(problem, bins)[0]
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
    row = layers_of(problem)[0]
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
