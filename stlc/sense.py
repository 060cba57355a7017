"""Which way a mission's objective goes; everything behind the border minimises."""

from __future__ import annotations

from enum import StrEnum
from typing import overload


class Sense(StrEnum):
    """Of a mission and of every figure that a person sees: plans, events, reports, records."""

    MINIMIZE = "minimize"
    MAXIMIZE = "maximize"

    @overload
    def own(self, value: float) -> float: ...
    @overload
    def own(self, value: float | None) -> float | None: ...
    def own(self, value: float | None) -> float | None:
        """A minimised figure as the mission states it, and the other way round; None stays."""
        if value is None or self is Sense.MINIMIZE:
            return value
        return 0.0 - value  # never -0.0
