"""Cells are closed: a point on a border touches both of them."""

import numpy as np

from stlc.solve.states.cells import touching


def test_a_border_touches_both_sides_and_the_outside_the_last() -> None:
    edges = np.array([0.0, 1.0, 2.0, 3.0])
    low, high = touching(edges, np.array([0.0, 0.5, 1.0, 2.0 - 1e-7, 3.0, 3.5]))
    assert low.tolist() == [0, 0, 0, 1, 2, 2]
    assert high.tolist() == [0, 0, 1, 2, 2, 2]
