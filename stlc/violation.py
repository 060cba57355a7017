"""How far a point is from a model, as it is judged and as plans record it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Violations:
    """The largest violations of a model by a point, and the names of the worst row and column.

    Absolute in the rows' own units; relative ones are to 1 + the size of the terms.
    """

    rows: float
    bounds: float
    integrality: float
    rows_relative: float
    bounds_relative: float
    worst_row: str | None = None
    worst_column: str | None = None
    worst_integer: str | None = None

    def within(self, tolerance: float) -> bool:
        """Rows and bounds within `tolerance`, integers exact."""
        return max(self.rows, self.bounds) <= tolerance and self.integrality == 0.0

    def describe(self) -> str:
        """The worst of them in words."""
        if self.rows >= self.bounds:
            return f"row {self.worst_row} is violated by {self.rows:.3g}"
        return f"column {self.worst_column} is outside its bounds by {self.bounds:.3g}"
