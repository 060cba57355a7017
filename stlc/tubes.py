"""Disturbances that are bounded, and the feedback that keeps an agent near its plan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_NEGLIGIBLE, _MOST_TERMS = 1e-9, 20_000
"""Where a sum over time ends, and when it never does: a gain that takes hours of steps to act."""


@dataclass(frozen=True, slots=True, eq=False)
class Tube:
    """x(t+1) = A x + B (u + w) + drift with |w| <= `bound` (m,), whatever w is; the agent applies
    u = v + K e, its plan's input and `gain` K (m, n) times how far it is off the plan's state."""

    bound: Array
    gain: Array

    def widest(self, model_a: Array, model_b: Array) -> Array:
        """Bounds (n,) of how far a state may be off at any time, infinite where it may drift away.

        sum over all k of |M^k B| bound with M = A + B K. Once |M^K| <= q < 1 in the maximum norm,
        what is left from K on is at most q / (1 - q) times the largest entry of the sum up to K.
        """
        power = np.eye(len(model_a))
        closed, total = model_a + model_b @ self.gain, np.zeros(len(model_a))
        for _ in range(_MOST_TERMS):
            total += np.abs(power @ model_b) @ self.bound
            power = closed @ power
            size = float(np.abs(power).sum(axis=1).max())
            if not np.isfinite(size):
                break
            if size <= _NEGLIGIBLE:
                return np.asarray(total + size / (1.0 - size) * total.max())
        return np.full(len(model_a), np.inf)
