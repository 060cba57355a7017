"""What the verifier says of one preference."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from stlc.source import Span


@dataclass(frozen=True, slots=True)
class PreferenceReport:
    """How much of one preference was given up, in `unit` (robustness: what it lacks of its margin;
    late: seconds; share: of its parts, 0..1). NaN: it can't be judged."""

    name: str
    violation: float
    unit: str
    measure: str
    weight: float
    priority: int | None
    cost: bool = False  # no preference, but what the objective counts
    span: Span | None = None

    @property
    def kept(self) -> bool:
        """Whether it holds; a cost is nothing that could be kept."""
        return self.cost or self.violation <= 1e-6

    def __str__(self) -> str:
        if self.cost:
            return f"{self.name} is {self.violation:.6g} {self.unit}"
        rank = f"weight {self.weight:g}"
        if self.priority is not None:
            rank = f"priority {self.priority:g}, {rank}"
        if self.kept:
            return f"kept {self.name}  ({rank})"
        lost = {
            "robustness": f"by {self.violation:.6g} {self.unit}".rstrip(),
            "late": f"late by {self.violation:.6g} s",
            "share": f"in {100 * self.violation:.4g} % of its parts",
        }[self.measure]
        return f"gave up {self.name} {lost}  ({rank})"

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON values; a violation that can't be judged is None."""
        amount = None if math.isnan(self.violation) else self.violation
        return {
            "name": self.name, "kept": self.kept, "violation": amount, "unit": self.unit,
            "measure": "time" if self.cost else self.measure,
        }  # fmt: skip
