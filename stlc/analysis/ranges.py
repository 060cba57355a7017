"""Intervals of the states and inputs of one agent over time."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from stlc.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False)
class Ranges:
    """Interval of every state (T+1, n) and input (T, m) of one agent at every step.

    Sound: every run that satisfies the mission stays within. `position_*` are (T+1, 3) [m], heights
    last.
    """

    state_lower: Floats
    state_upper: Floats
    input_lower: Floats
    input_upper: Floats
    position_lower: Floats
    position_upper: Floats

    def near(self, other: Ranges, tolerance: float) -> bool:
        """Whether the ends of every interval differ by no more than that."""
        pairs = ((getattr(self, f.name), getattr(other, f.name)) for f in fields(self))
        return all(np.allclose(a, b, rtol=0.0, atol=tolerance) for a, b in pairs)
