"""Disturbances that are bounded, and the feedback that keeps an agent near its plan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Tube:
    """x(t+1) = A x + B (u + w) + drift with |w| <= `bound` (m,), whatever w is; the agent applies
    u = v + K e, its plan's input and `gain` K (m, n) times how far it is off the plan's state."""

    bound: Array
    gain: Array
