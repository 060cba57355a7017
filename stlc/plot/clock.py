"""Time as a reader wants it: milliseconds, seconds, minutes or hours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stlc.arrays import Floats
from stlc.plan import Plan

_UNITS = ((7200.0, 3600.0, "h"), (600.0, 60.0, "min"), (0.5, 1.0, "s"), (0.0, 1e-3, "ms"))
"""From so many seconds in all, a unit of so many seconds, its name."""


@dataclass(frozen=True, slots=True, eq=False)
class Clock:
    """`times` (T+1,) of the steps, in `unit`; a step is `step` of them."""

    times: Floats
    step: float
    unit: str

    @property
    def label(self) -> str:
        """Of an axis."""
        return f"time [{self.unit}]"

    def at(self, steps: Floats) -> Floats:
        """Times of fractional steps."""
        return np.asarray(steps * self.step)


def clock(plan: Plan) -> Clock:
    """The clock of a plan's steps."""
    whole = plan.horizon * plan.step
    _, seconds, unit = next(u for u in _UNITS if whole >= u[0])
    step = plan.step / seconds
    times = np.arange(plan.horizon + 1, dtype=np.float64) * step
    return Clock(times, step, unit)
