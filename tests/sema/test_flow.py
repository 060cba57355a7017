"""Discrete matrices back to continuous ones."""

from __future__ import annotations

import numpy as np
import pytest

from stlc.dynamics import Flow
from stlc.sema.discretise import zero_order_hold
from stlc.sema.flow import held_flow


def test_a_hold_is_undone() -> None:
    a, b, c = np.array([[-0.3, -1.0], [1.0, -0.3]]), np.array([[1.0], [0.5]]), np.array([0.2, 0.0])
    found = held_flow(Flow(*zero_order_hold(a, b, c, 0.5)), 0.5)
    assert found is not None
    np.testing.assert_allclose(found.A, a, atol=1e-9)
    np.testing.assert_allclose(found.B, b, atol=1e-9)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("huge", [1e100, 1e200, 1e308])
def test_matrices_that_overflow_on_the_way_have_none(huge: float) -> None:
    a = np.array([[1, 0, 1, 0], [0, 1, 0, 1], [0, 0, 1, 0], [huge, 0, 0, 1]])
    b = np.array([[1e100, 0], [0, 0], [1, 0], [0, 1]])
    assert held_flow(Flow(a, b, np.zeros(4)), 1.0) is None
