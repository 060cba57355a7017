"""Tables of two agents: the same values as the lists of their steps."""

from __future__ import annotations

import numpy as np
import pytest
from support.bodies import layers_of, problem_of

from stlc.solve.bounders.arcs import Arcs
from stlc.solve.bounders.ascent import softened
from stlc.solve.bounders.shares import stage_cost
from stlc.solve.bounders.tables import Moves, Tables


@pytest.mark.parametrize("seed", range(3))
def test_tables_and_lists_have_the_same_values(seed: int) -> None:
    """Least value, soft minimum and its derivative, shares; some pairs of states are dropped."""
    rng = np.random.default_rng(seed)
    problem = problem_of(rng)
    rows, bodies = layers_of(problem, 1), (problem.bodies[0], problem.bodies[1])
    cost = [stage_cost(problem, t) for t in range(1, problem.steps + 1)]
    masks = [rng.random((len(a), len(b))) < 0.7 for a, b in zip(*rows, strict=True)]
    arcs = Arcs(bodies, (rows[0], rows[1]), cost, masks)
    arcs.slopes = arcs.loose[:, None] * rng.normal(size=arcs.slopes.shape)
    moves = [Moves(body, row) for body, row in zip(bodies, rows, strict=True)]
    first = len(moves[0].slopes)
    slopes = (arcs.slopes[:first], arcs.slopes[first:])
    stops = [np.zeros((1, 1))]
    for t, table in enumerate(cost, start=1):
        stops.append(table[rows[0][t].cell][:, rows[1][t].cell])
        stops[t][~masks[t]] = np.inf
    tables = Tables(moves[0], moves[1])
    assert tables.least(slopes, stops) == pytest.approx(arcs.through()[0], abs=1e-9)
    found = tables.softened(slopes, stops, 0.2)
    value, slips, shares = softened(arcs, arcs.slopes, 0.2)
    assert found.value == pytest.approx(value, abs=1e-9)
    own = [m.slips(f, at) for m, f, at in zip(moves, found.flows, found.at, strict=True)]
    np.testing.assert_allclose(np.concatenate(own), slips, atol=1e-9)
    for stop, share, table in zip(arcs.stops, shares, found.shares, strict=True):
        np.testing.assert_allclose(table[stop.i, stop.j], share, atol=1e-9)
        assert table.sum() == pytest.approx(1.0)
