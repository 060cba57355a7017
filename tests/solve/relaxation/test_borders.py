"""Borders as cells of their own: tables there, and cell pairs read back from them."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from stlc.solve.relaxation.borders import taken, with_borders
from stlc.solve.states.boxes import axis_grid

SHAPE = (3, 2)


def _touched(place: int) -> list[int]:
    """Cells that touch a place of the grid with borders."""
    x, y = divmod(place, 2 * SHAPE[1] - 1)
    return [
        i * SHAPE[1] + j
        for i in sorted({x // 2, (x + 1) // 2})
        for j in sorted({y // 2, (y + 1) // 2})
    ]


@pytest.mark.parametrize("agents", [1, 2])
def test_a_table_takes_the_least_of_the_touching_cells(agents: int) -> None:
    table = np.random.default_rng(agents).normal(size=(6,) * agents)
    found = with_borders(table, SHAPE)
    assert found.shape == (15,) * agents
    for places in itertools.product(range(15), repeat=agents):
        cells = itertools.product(*map(_touched, places))
        assert found[places] == min(table[c] for c in cells)


def test_cell_pairs_are_those_that_touch_a_pair_of_places() -> None:
    alive = np.random.default_rng(0).random((15, 15)) < 0.02
    expected = np.zeros((6, 6), bool)
    for i, j in zip(*np.nonzero(alive), strict=True):
        expected[np.ix_(_touched(i), _touched(j))] = True
    assert expected.any()
    assert not expected.all()
    np.testing.assert_array_equal(taken(alive, SHAPE), expected)


def test_inner_borders_are_cells_between_those_beside_them() -> None:
    edges, rates = np.array([0.0, 1.0, 2.0, 3.0]), np.array([-1.0, 1.0])
    grid = axis_grid(edges, [0.0, 1.0, 2.5], rates, borders=True)
    places = {(*box[:2].tolist(), int(c)) for box, c in zip(grid.box, grid.cell, strict=True)}
    assert places == {
        (0.0, 1.0, 0), (1.0, 1.0, 1), (1.0, 2.0, 2), (2.0, 2.0, 3), (2.0, 2.5, 4), (2.5, 3.0, 4),
        (0.0, 0.0, 0),
    }  # fmt: skip
