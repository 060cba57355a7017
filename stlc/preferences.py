"""What a mission would like to hold, but can do without; and limits on what costs add up to."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from stlc.ir.nodes import Node
from stlc.source import Span


class Measure(Enum):
    """How a preference's violation is measured."""

    ROBUSTNESS = "robustness"  # what the robustness lacks of the margin, in its unit
    LATE = "late"  # [s]
    SHARE = "share"  # of the parts, 0..1


@dataclass(frozen=True, slots=True)
class Preference:
    """One `prefer`: its violation counts `weight` / `scale` times, or in tier `priority`.

    ROBUSTNESS: violation max(0, margin - robustness of `formula`). Otherwise the sum over `parts`
    that don't reach the margin of `worth` each: a step's length [s] for each deadline that passes,
    one over their number for each part of a conjunction or window.

    `cost`: nobody prefers it, the objective counts it (`minimize time(reach)`).
    """

    name: str
    formula: Node
    weight: float = 1.0
    priority: int | None = None
    measure: Measure = Measure.ROBUSTNESS
    scale: float = 1.0
    margin: float = 0.0
    parts: tuple[Node, ...] = ()
    worth: float = 1.0
    unit: str = ""
    cost: bool = False
    span: Span | None = None
