"""Tables at touching cells: the least that a later table can take, and whose costs they are."""

from __future__ import annotations

import numpy as np

from stlc.radio.partition import uniform_grid
from stlc.solve.relaxation.link_costs import Costs, Touching

GRID = uniform_grid((0, 3), (0, 1), 3, 1)  # cells 0, 1, 2 in a row


def test_only_neighbours_touch() -> None:
    table = np.array([5.0, 3.0, 1.0])
    touching = Touching.of(GRID.boxes)
    assert touching.least(table, [True]).tolist() == [3.0, 1.0, 1.0]
    assert touching.least(table, [False]).tolist() == table.tolist()
    alive = np.array([True, False, False])
    assert touching.around(alive, [True]).tolist() == [True, True, False]


def test_the_first_table_is_taken_at_the_cell_and_later_ones_at_the_best_beside_it() -> None:
    table = np.arange(9.0).reshape(3, 3)
    costs = Costs(["a", "b", "c"], GRID, 1)
    assert costs.add(("a", "b"), table, range(1, 2))
    assert costs.add(("b", "c"), table, range(1, 2))
    first, later = costs.pairs[0, 1][1], costs.pairs[1, 2][1]
    assert first is not None
    assert later is not None
    assert first.tolist() == table.tolist()
    assert later.tolist() == [[0, 1, 2], [0, 1, 2], [3, 4, 5]]  # b may be in a cell beside


def test_a_pair_the_other_way_round_is_turned() -> None:
    table = np.arange(9.0).reshape(3, 3)
    costs = Costs(["a", "b"], GRID, 1)
    assert costs.add(("b", "a"), table, range(1, 2))
    turned = costs.pairs[0, 1][1]
    assert turned is not None
    assert turned.tolist() == table.T.tolist()


def test_a_station_leaves_an_agent_alone_and_strangers_nothing() -> None:
    costs = Costs(["a", "b"], GRID, 1)
    assert costs.add(("base", "b"), np.array([2.0, 0.0, 1.0]), range(1, 2))
    assert not costs.add(("base", "mast"), np.zeros(3), range(1, 2))
    alone = costs.alone[1][1]
    assert alone is not None
    assert alone.tolist() == [2.0, 0.0, 1.0]
    assert costs.alone[0][1] is None
