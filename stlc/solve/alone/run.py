"""What is known of one agent of a team alone."""

from __future__ import annotations

from dataclasses import dataclass

from stlc.arrays import Floats

Run = tuple[Floats, Floats]
"""States (T+1, n) and inputs (T, m)."""


@dataclass(frozen=True, slots=True, eq=False)
class LoneRun:
    """One agent alone: a lower bound of its effort, and the best run found, states (T+1, n) and
    inputs (T, m)."""

    agent: str
    bound: float
    run: Run | None
