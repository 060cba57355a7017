"""Least costs of legs: those of a linear programme, with its derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from stlc.arrays import Floats
from stlc.solve.routes.legs import Corners


def programme(k: int, blend: float, price: float, prices: Floats, ends: Floats) -> float | None:
    """Over p_0, w_0, p_k, w_k and the changes of the rate, upward and downward; None: no leg."""
    cost = np.concatenate([prices * [1, 1, -1, -1], np.full(2 * k, price)])
    reach = k - 1 - np.arange(k) + blend
    rows = np.zeros((2, 4 + 2 * k))
    rows[0] = [0, -1, 0, 1, *-np.ones(k), *np.ones(k)]
    rows[1] = [-1, -k, 1, 0, *-reach, *reach]
    found = linprog(cost, A_eq=rows, b_eq=[0, 0], bounds=[*ends, *[(0, None)] * (2 * k)])
    return float(found.fun) if found.status == 0 else None


@pytest.mark.parametrize("steps", [1, 2, 3, 8])
@pytest.mark.parametrize("blend", [0.0, 0.5, 1.0])
def test_least_costs_are_those_of_the_programme(steps: int, blend: float) -> None:
    rng = np.random.default_rng(steps)
    for _ in range(20):
        corners = Corners.of(steps, blend, rng.uniform(0.2, 2))
        prices = rng.normal(size=4) * rng.choice([0.01, 0.3, 1.0], size=4)
        low = rng.normal(size=4)
        high = low + rng.uniform(0, 3, size=4)
        expected = programme(steps, blend, corners.price, prices, np.stack([low, high], axis=1))
        value, slope = corners.least(prices[None], low[None], high[None])
        if expected is None:
            continue
        assert value[0] == pytest.approx(expected, abs=1e-7)
        other = prices + 0.1 * rng.normal(size=4)
        there = corners.least(other[None], low[None], high[None])[0][0]
        assert there <= value[0] + slope[0] @ (other - prices) + 1e-7
