"""Intervals of the states and inputs of one agent over time."""

from __future__ import annotations

from dataclasses import dataclass

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
